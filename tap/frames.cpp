#include "tap/frames.hpp"

#include <algorithm>
#include <cstring>

namespace sinew::tap {

const char* code_name(hal::Errc code) {
  switch (code) {
    case hal::Errc::not_found:
      return "not_found";
    case hal::Errc::busy:
      return "busy";
    case hal::Errc::denied:
      return "denied";
    case hal::Errc::not_supported:
      return "not_supported";
    case hal::Errc::bad_argument:
      return "bad_argument";
    case hal::Errc::bad_data:
      return "bad_data";
    case hal::Errc::closed:
      return "closed";
    case hal::Errc::timeout:
      return "timeout";
    case hal::Errc::out_of_memory:
      return "out_of_memory";
    case hal::Errc::io:
      break;
  }
  return "io";
}

std::array<std::byte, 4> frame_head(std::size_t bytes) {
  std::array<std::byte, 4> head;
  for (unsigned i = 0; i < 4; ++i) head[i] = static_cast<std::byte>(bytes >> (8 * i) & 0xFF);
  return head;
}

std::span<std::byte> FrameReader::room() {
  if (broken_ || frame()) return {};
  if (held_ < head_.size()) return std::span(head_).subspan(held_);
  // Grown as the bytes come: a large length alone takes no memory.
  constexpr std::size_t kStep = 16 * 1024;
  const std::size_t have = held_ - head_.size();
  const std::size_t want = std::min<std::size_t>(length_ - have, kStep);
  if (body_.size() < have + want) body_.resize(have + want);
  return std::span(body_).subspan(have, want);
}

void FrameReader::filled(std::size_t n) {
  const bool in_head = held_ < head_.size();
  held_ += n;
  if (!in_head || held_ < head_.size()) return;
  length_ = 0;
  for (unsigned i = 0; i < 4; ++i) length_ |= std::to_integer<std::uint32_t>(head_[i]) << (8 * i);
  broken_ = length_ == 0 || length_ > max_bytes_;
}

std::optional<std::string_view> FrameReader::frame() const {
  if (broken_ || held_ < head_.size() || held_ - head_.size() < length_) return std::nullopt;
  return std::string_view(reinterpret_cast<const char*>(body_.data()), length_);
}

void FrameReader::drop() {
  held_ = 0, length_ = 0;
  if (body_.capacity() > 64 * 1024) body_ = {};
}

}  // namespace sinew::tap
