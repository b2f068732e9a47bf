#include "msg/ros2_image.hpp"

#include <algorithm>

namespace sinew::msg {

const Ros2Schema& ros2_image_schema() {
  static constexpr Ros2Schema kSchema{"sensor_msgs/msg/Image",
                                      R"(std_msgs/Header header
uint32 height
uint32 width
string encoding
uint8 is_bigendian
uint32 step
uint8[] data
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
)"};
  return kSchema;
}

const Ros2Schema& ros2_compressed_image_schema() {
  static constexpr Ros2Schema kSchema{"sensor_msgs/msg/CompressedImage",
                                      R"(std_msgs/Header header
string format
uint8[] data
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
)"};
  return kSchema;
}

std::string_view ros2_encoding(PixelFormat format) {
  switch (format) {
    case PixelFormat::mono8:
      return "mono8";
    case PixelFormat::rgb8:
      return "rgb8";
    case PixelFormat::bgr8:
      return "bgr8";
    case PixelFormat::yuyv:
      return "yuv422_yuy2";
    case PixelFormat::none:
      break;
  }
  return "";
}

Ros2ImageHead Ros2ImageHead::of_image(const Image& image, std::uint32_t pixel_bytes, std::int64_t unix_ns,
                                      std::string_view frame_id) {
  Ros2ImageHead head;
  head.header(image.stamp.ns + unix_ns, frame_id);
  head.u32(image.height);
  head.u32(image.width);
  head.text(ros2_encoding(image.format));
  head.u8(0);  // not big-endian
  head.u32(image.stride);
  head.u32(pixel_bytes);
  return head;
}

Ros2ImageHead Ros2ImageHead::of_file(std::int64_t stamp_ns, std::string_view frame_id, std::string_view format,
                                     std::uint32_t file_bytes) {
  Ros2ImageHead head;
  head.header(stamp_ns, frame_id);
  head.text(format);
  head.u32(file_bytes);
  return head;
}

void Ros2ImageHead::header(std::int64_t stamp_ns, std::string_view frame_id) {
  constexpr std::int64_t kSecond = 1'000'000'000;
  const std::int64_t sec = stamp_ns / kSecond - (stamp_ns % kSecond < 0 ? 1 : 0);
  u32(static_cast<std::uint32_t>(static_cast<std::int32_t>(sec)));
  u32(static_cast<std::uint32_t>(stamp_ns - sec * kSecond));
  text(frame_id);
}

void Ros2ImageHead::align4() {
  while (size_ % 4 != 0) u8(0);  // the header of 4 bytes does not change where numbers are aligned
}

void Ros2ImageHead::u32(std::uint32_t value) {
  align4();
  for (int shift = 0; shift < 32; shift += 8) u8(static_cast<std::uint8_t>(value >> shift));
}

void Ros2ImageHead::text(std::string_view text) {
  text = text.substr(0, kMostText);
  u32(static_cast<std::uint32_t>(text.size() + 1));
  for (const char c : text) u8(static_cast<std::uint8_t>(c));
  u8(0);
}

}  // namespace sinew::msg
