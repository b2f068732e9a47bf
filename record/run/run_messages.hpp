#pragma once
// Content of a run's recording besides the robot's own messages: the steps, the requests from outside, and images in
// the form that other programs know. docs/recording.md has the names.
#include <optional>
#include <string_view>
#include <vector>

#include "msg/image.hpp"
#include "msg/ros2_image.hpp"
#include "record/buffer.hpp"
#include "record/run/step_log.hpp"

namespace sinew::record {

inline constexpr std::string_view kStepsTopic = "sinew/steps", kRequestsTopic = "sinew/requests",
                                  kStatesTopic = "sinew/states";
/// Suffix of an image topic's name for its heads.
inline constexpr std::string_view kHeadSuffix = "/head";

using RecordSchema = msg::Ros2Schema;  // "sinew_msgs/msg/StepBatch", ros2msg
const RecordSchema& step_batch_schema();
const RecordSchema& request_schema();
const RecordSchema& state_schema();
inline const RecordSchema& image_schema() { return msg::ros2_image_schema(); }
const RecordSchema& image_head_schema();  // sinew_msgs/msg/ImageHead

/// Steps of one thread, in their order, as they come.
class StepBatch {
 public:
  void add(const LoggedStep& step);
  bool empty() const { return count_ == 0; }
  std::uint32_t count() const { return count_; }
  rt::Time first() const { return first_; }  // now of the first step
  std::span<const std::byte> bytes() const { return bytes_.bytes(); }
  void clear() { count_ = 0; }

 private:
  Buffer bytes_;
  std::uint32_t count_ = 0;
  rt::Time first_;
};
/// False: not the bytes of a batch; `steps` holds nothing then.
bool decode(std::span<const std::byte> bytes, std::vector<LoggedStep>& steps);

void encode(Buffer& to, const LoggedRequest& request);
bool decode(std::span<const std::byte> bytes, LoggedRequest& request);

/// `layout`: rt::SavedState::layout(), to be compared before the state is used.
void encode(Buffer& to, const LoggedState& state, std::uint64_t layout);
/// The bytes are those of the input.
bool decode(std::span<const std::byte> bytes, LoggedState& state, std::uint64_t& layout);

/// The fields that sensor_msgs/msg/Image lacks, and all that is kept of an image without its pixels.
struct ImageHead {
  rt::Time stamp;
  std::int64_t exposure_ns = 0;
  std::uint32_t frame_number = 0, width = 0, height = 0, stride = 0, format = 0, capacity_bytes = 0;
  std::uint64_t pixel_hash = 0;  // XXH64 of the used bytes
  bool has_pixels = false;       // recorded with the same sequence
  friend bool operator==(const ImageHead&, const ImageHead&) = default;
};
ImageHead head_of(const msg::Image& image, bool has_pixels);
void encode(Buffer& to, const ImageHead& head);
bool decode(std::span<const std::byte> bytes, ImageHead& head);

class CdrWriter;
/// A std_msgs/Header.
void put_header(CdrWriter& to, std::int64_t stamp_ns, std::string_view frame_id);

/// Up to the beginning of the pixels. `unix_ns`: added to the stamp for the header.
void encode_image_head(Buffer& to, const msg::Image& image, std::int64_t unix_ns, std::string_view frame_id);
/// A view of a sensor_msgs/msg/Image in its bytes.
struct ImageView {
  std::int64_t stamp_ns = 0;
  std::string_view frame_id, encoding;
  std::uint32_t width = 0, height = 0, stride = 0;
  std::span<const std::byte> pixels;
};
/// Nothing when the bytes are no such image. The numbers may be anything.
std::optional<ImageView> view_image(std::span<const std::byte> bytes);
inline std::optional<std::span<const std::byte>> image_pixels(std::span<const std::byte> bytes) {
  const auto view = view_image(bytes);
  return view ? std::optional(view->pixels) : std::nullopt;
}

}  // namespace sinew::record
