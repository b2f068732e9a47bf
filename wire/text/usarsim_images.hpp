#pragma once
// The pictures of USARSim's image server (TCP port 5003): the client asks, the server answers with one picture.
//
//   asked:    "OK" (the whole picture), or 'U' and u32 x, y, width, height (a part of it)
//   answered: u8 type (0: raw, 1 to 5: JPEG of falling quality), u32 size, `size` bytes
//   raw:      u16 width, u16 height, then rows of 3 bytes a pixel, top first, each row padded to a multiple of 4 bytes
//
// Numbers are big-endian. In the mode that USARSim calls legacy a picture comes without being asked, at the connection.
// Source:  robocup-usarsim, USARDLL/ImageServer/ImageServer.cpp.
#include <cstddef>
#include <cstdint>
#include <span>

namespace sinew::wire {

inline constexpr std::size_t kUsarImageHead = 5;
inline constexpr std::uint32_t kUsarMostImage = 64u << 20;  // bytes: 16 times a screen of 1280x960

enum class UsarImageError : std::uint8_t {
  none,
  type,   // no type of picture: the stream is not at the beginning of an answer
  size,   // empty, or larger than any picture
  shape,  // raw: no pixels, or other bytes than the shape needs
};

struct UsarImageHead {
  bool jpeg = false;
  std::uint32_t size = 0;  // of what follows
};

/// `bytes`: kUsarImageHead of them.   RT: yes.
UsarImageError parse_usarsim_image_head(std::span<const std::uint8_t, kUsarImageHead> bytes,
                                        UsarImageHead& out) noexcept;

/// Of a raw picture. Points into it.
struct UsarRawImage {
  std::uint32_t width = 0, height = 0;
  std::size_t stride = 0;                  // bytes from row to row
  std::span<const std::uint8_t> pixels{};  // (height - 1) * stride + 3 * width bytes at least

  const std::uint8_t* row(std::uint32_t y) const { return pixels.data() + y * stride; }
};

/// What stands behind the head. Rows without padding are taken, too.   RT: yes.
UsarImageError parse_usarsim_raw_image(std::span<const std::uint8_t> bytes, UsarRawImage& out) noexcept;

struct UsarImageRegion {
  std::uint32_t x = 0, y = 0, width = 0, height = 0;  // width 0: the whole picture
};
inline constexpr std::size_t kUsarImageRequest = 17;  // at most

/// Returns the bytes written.   RT: yes.
std::size_t write_usarsim_image_request(const UsarImageRegion& region,
                                        std::span<std::uint8_t, kUsarImageRequest> out) noexcept;

}  // namespace sinew::wire
