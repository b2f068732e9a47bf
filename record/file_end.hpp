#pragma once
#include <memory>

#include "hal/file.hpp"

namespace sinew::record {

/// The end of a growing file: all of a piece is there, or nothing of it.
/// Thread:  owner.
class FileEnd {
 public:
  explicit FileEnd(std::unique_ptr<hal::OutputFile> file) : file_(std::move(file)) {}
  std::uint64_t size() const { return size_; }
  std::uint32_t crc() const { return crc_; }  // of everything so far
  bool broken() const { return broken_; }     // part of a piece could not be taken away again
  hal::OutputFile& file() { return *file_; }

  /// `crc`: of everything including these parts. Errors: those of the file; closed when broken.
  hal::Status append(hal::Parts parts, std::uint32_t crc) noexcept;
  hal::Status append(std::span<const std::byte> bytes) noexcept;
  /// Takes away what follows `size`, a place where append() ended once, with the checksum of then.
  hal::Status cut(std::uint64_t size, std::uint32_t crc) noexcept;

 private:
  std::unique_ptr<hal::OutputFile> file_;
  std::uint64_t size_ = 0;
  std::uint32_t crc_ = 0;
  bool broken_ = false;
};

}  // namespace sinew::record
