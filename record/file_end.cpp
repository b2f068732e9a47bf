#include "record/file_end.hpp"

#include "record/crc32.hpp"

namespace sinew::record {

hal::Status FileEnd::append(hal::Parts parts, std::uint32_t crc) noexcept {
  if (broken_) return hal::Error{hal::Errc::closed, "record: a part of a chunk could not be taken out of the file"};
  if (auto done = file_->append(parts); !done) {
    if (!file_->cut(size_)) broken_ = true;
    return done;
  }
  for (const auto& part : parts) size_ += part.size();
  crc_ = crc;
  return {};
}

hal::Status FileEnd::append(std::span<const std::byte> bytes) noexcept {
  return append({&bytes, 1}, crc32(bytes, crc_));
}

hal::Status FileEnd::cut(std::uint64_t size, std::uint32_t crc) noexcept {
  if (auto done = file_->cut(size); !done) {
    broken_ = true;
    return done;
  }
  size_ = size, crc_ = crc;
  return {};
}

}  // namespace sinew::record
