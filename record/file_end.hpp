#pragma once
#include <memory>
#include <utility>

#include "hal/file.hpp"

namespace sinew::record {

/// The end of a growing file: a piece is appended whole or not at all.
/// Thread:  owner.
class FileEnd {
 public:
  explicit FileEnd(std::unique_ptr<hal::OutputFile> file) : file_(std::move(file)) {}
  std::uint64_t size() const { return size_; }
  std::uint32_t crc() const { return crc_; }  // of everything so far
  bool broken() const { return broken_; }     // part of a piece could not be removed
  hal::OutputFile& file() { return *file_; }
  /// Another file takes its place.
  std::unique_ptr<hal::OutputFile> exchange(std::unique_ptr<hal::OutputFile> file) {
    std::swap(file_, file);
    size_ = 0, crc_ = 0, broken_ = false;
    return file;
  }

  /// `crc`: of the whole file including these parts. Errors: those of the file; closed when broken.
  hal::Status append(hal::Parts parts, std::uint32_t crc) noexcept;
  hal::Status append(std::span<const std::byte> bytes) noexcept;
  /// Cuts the file back to `size`, a place where append() once ended; `crc`: the checksum at that time.
  hal::Status cut(std::uint64_t size, std::uint32_t crc) noexcept;

 private:
  std::unique_ptr<hal::OutputFile> file_;
  std::uint64_t size_ = 0;
  std::uint32_t crc_ = 0;
  bool broken_ = false;
};

}  // namespace sinew::record
