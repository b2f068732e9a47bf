#pragma once
#include <memory>

#include "hal/result.hpp"
#include "record/format.hpp"

namespace sinew::record {

/// Compresses chunks, one after the other, in memory that it keeps: an lz4 or a zstd frame each.
/// Thread:  owner.
class Compressor {
 public:
  /// `level`: zstd's, 1 to 19; lz4 has its fast one only. Errors: out_of_memory.
  static hal::Result<std::unique_ptr<Compressor>> make(Compression compression, int level);
  virtual ~Compressor() = default;
  /// The frame replaces what is in `to`.
  virtual hal::Status compress(std::span<const std::byte> from, Buffer& to) noexcept = 0;
};

/// Takes frames of anybody apart. Thread: owner.
class Decompressor {
 public:
  Decompressor();
  ~Decompressor();
  /// Fills `to` exactly. Errors: bad_data when the frame is damaged or holds fewer or more bytes; out_of_memory.
  hal::Status decompress(Compression compression, std::span<const std::byte> from, std::span<std::byte> to) noexcept;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace sinew::record
