#pragma once
#include <memory>

#include "hal/result.hpp"
#include "record/format.hpp"

namespace sinew::record {

/// Compresses chunks one after the other, each to an lz4 or zstd frame, in memory that it keeps.
/// Thread:  owner.
class Compressor {
 public:
  /// `level`: 1 to 19 for zstd; lz4 has only its fast level. Errors: out_of_memory.
  static hal::Result<std::unique_ptr<Compressor>> make(Compression compression, int level);
  virtual ~Compressor() = default;
  /// The frame replaces the content of `to`.
  virtual hal::Status compress(std::span<const std::byte> from, Buffer& to) noexcept = 0;
};

/// Decompresses frames from any program. Thread: owner.
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
