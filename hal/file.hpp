#pragma once
// Files on disk, as a recorder and its readers need them. hal/linux/file.hpp opens real ones.
#include <cstddef>
#include <cstdint>
#include <span>

#include "hal/result.hpp"

namespace sinew::hal {

using Parts = std::span<const std::span<const std::byte>>;

/// A file that grows at its end. Thread: owner.
/// Errors:  io with errno in detail (28, ENOSPC: the disk is full).
class OutputFile {
 public:
  virtual ~OutputFile() = default;
  /// Appends all parts, one after the other. After an error any number of their bytes may be there: cut() removes them.
  virtual Status append(Parts parts) noexcept = 0;
  /// From now on the appended bytes survive a loss of power. May take long.
  virtual Status sync() noexcept = 0;
  /// Removes everything from `size` on.
  virtual Status cut(std::uint64_t size) noexcept = 0;
  /// Bytes that an ordinary user may still write on this disk.
  virtual Result<std::uint64_t> free_bytes() noexcept = 0;
  /// Waits until everything that was appended is in the file, where append() only takes it over. Errors: those of
  /// append().
  virtual Status settle() noexcept { return {}; }
  /// True if settle() would find everything in the file and synced as asked for. Never waits.
  virtual bool settled() noexcept { return true; }
  /// Removes the file, where it has a name. Nothing is appended afterwards. Errors: io.
  virtual Status remove() noexcept { return {}; }
};

/// A file for reading at any offset. Thread: any.
class InputFile {
 public:
  virtual ~InputFile() = default;
  virtual std::uint64_t size() const noexcept = 0;
  /// Fills `into` from `offset` on. Errors: bad_data when the file ends earlier (detail: its size), io.
  virtual Status read_at(std::uint64_t offset, std::span<std::byte> into) noexcept = 0;
};

}  // namespace sinew::hal
