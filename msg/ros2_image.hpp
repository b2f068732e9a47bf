#pragma once
// Pictures as ROS 2 tools know them: sensor_msgs/msg/Image of an image message, and sensor_msgs/msg/CompressedImage of
// a picture file. Recordings and the monitor send the same bytes. Source:  sensor_msgs/msg/Image.msg,
// CompressedImage.msg (ROS 2 common_interfaces); CDR as msg/cdr.hpp has it.
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "msg/image.hpp"

namespace sinew::msg {

struct Ros2Schema {
  std::string_view name, text;  // "sensor_msgs/msg/Image", and its definition as "ros2msg"
};
const Ros2Schema& ros2_image_schema();
const Ros2Schema& ros2_compressed_image_schema();

/// "mono8", "rgb8", "bgr8", "yuv422_yuy2": as sensor_msgs/image_encodings.hpp has them; "" for none.
std::string_view ros2_encoding(PixelFormat format);

/// What comes before the pixels, or before the bytes of the file, with their number.
class Ros2ImageHead {
 public:
  /// Of a sensor_msgs/msg/Image. `pixel_bytes` of pixels follow. `unix_ns`: added to the stamp for the header.
  /// A `frame_id` longer than a topic's name may be is cut.
  /// Thread:  any.   RT: yes.
  static Ros2ImageHead of_image(const Image& image, std::uint32_t pixel_bytes, std::int64_t unix_ns,
                                std::string_view frame_id);
  /// Of a sensor_msgs/msg/CompressedImage. `format`: "jpeg", "png".
  static Ros2ImageHead of_file(std::int64_t stamp_ns, std::string_view frame_id, std::string_view format,
                               std::uint32_t file_bytes);
  std::span<const std::byte> bytes() const { return {bytes_.data(), size_}; }

 private:
  void header(std::int64_t stamp_ns, std::string_view frame_id);
  void align4();
  void u8(std::uint8_t value) { bytes_[size_++] = std::byte{value}; }
  void u32(std::uint32_t value);
  void text(std::string_view text);

  static constexpr std::size_t kMostText = 72;
  std::array<std::byte, 256> bytes_{std::byte{0}, std::byte{1}};
  std::size_t size_ = 4;  // the encapsulation header: XCDR1, little-endian
};

}  // namespace sinew::msg
