#pragma once
#include <algorithm>
#include <cstddef>
#include <span>

#include "hal/file.hpp"

namespace sinew::record {

/// A file that lies in memory.
/// Owner:   the bytes outlive it.
class MemoryInput final : public hal::InputFile {
 public:
  explicit MemoryInput(std::span<const std::byte> bytes) : bytes_(bytes) {}
  std::uint64_t size() const noexcept override { return bytes_.size(); }
  hal::Status read_at(std::uint64_t offset, std::span<std::byte> into) noexcept override {
    if (offset > bytes_.size() || into.size() > bytes_.size() - offset)
      return hal::Error{hal::Errc::bad_data, "file ends early", static_cast<std::int64_t>(bytes_.size())};
    std::copy_n(bytes_.begin() + static_cast<std::ptrdiff_t>(offset), into.size(), into.begin());
    return {};
  }

 private:
  std::span<const std::byte> bytes_;
};

}  // namespace sinew::record
