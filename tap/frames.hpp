#pragma once
// The socket's frames: four bytes little-endian with the length, then so many bytes of JSON text.
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "hal/result.hpp"

namespace sinew::tap {

inline constexpr std::uint32_t kProtocolVersion = 1;
inline constexpr std::uint32_t kMaxRequestBytes = 64 * 1024;
inline constexpr std::size_t kMostBytesAtOnce = 16;  // messages of one publish.bytes
inline constexpr std::uint32_t kMaxReplyBytes = 8 * 1024 * 1024;

/// The "code" of an error, as docs/robot-socket.md names them: "bad_argument".
const char* code_name(hal::Errc code);

/// The length in front of a frame.
std::array<std::byte, 4> frame_head(std::size_t bytes);

/// Puts frames together from the pieces in which they arrive, holding one at most.
/// Thread:  owner.
class FrameReader {
 public:
  explicit FrameReader(std::uint32_t max_bytes) : max_bytes_(max_bytes) {}
  /// Where the next bytes of the stream go; never empty while no frame is complete and the stream is not broken.
  std::span<std::byte> room();
  /// `n` bytes arrived in room().
  void filled(std::size_t n);
  /// The complete frame, until drop(). Nothing: more bytes are needed, or broken().
  std::optional<std::string_view> frame() const;
  void drop();
  /// True after a length of 0 or above the maximum: the bytes that follow cannot be understood any more.
  bool broken() const { return broken_; }
  /// Only a part of a frame is here.
  bool half() const { return held_ > 0 && !frame(); }

 private:
  std::uint32_t max_bytes_;
  std::uint32_t length_ = 0;  // of the frame, once its head is here
  std::size_t held_ = 0;      // of head and frame together
  std::array<std::byte, 4> head_{};
  std::vector<std::byte> body_;
  bool broken_ = false;
};

}  // namespace sinew::tap
