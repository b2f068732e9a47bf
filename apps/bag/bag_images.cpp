#include <fmt/format.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>

#include "apps/bag/bag_options.hpp"
#include "apps/command/command.hpp"
#include "apps/command/json.hpp"
#include "dataset/png_image.hpp"
#include "msg/ros2_image.hpp"
#include "record/run/run_messages.hpp"

namespace sinew::app {
namespace {

namespace fs = std::filesystem;

msg::PixelFormat format_of(std::string_view encoding) {
  for (const auto& [name, format] : msg::kPixelFormats)
    if (msg::ros2_encoding(format) == encoding) return format;
  return msg::PixelFormat::none;
}

/// Empty, with `why`: the message is no image that can be shown.
std::string png_of(const record::Message& m, std::string& why) {
  const auto view = record::view_image(m.data);
  if (!view) {
    why = "its bytes are no sensor_msgs/msg/Image";
    return std::string();
  }
  const msg::PixelFormat format = format_of(view->encoding);
  if (format == msg::PixelFormat::none) {
    why = "encoding " + std::string(view->encoding) + ": mono8, rgb8, bgr8 or yuv422_yuy2";
    return std::string();
  }
  return dataset::encode_png(format, view->width, view->height, view->stride,
                             {reinterpret_cast<const std::uint8_t*>(view->pixels.data()), view->pixels.size()}, why);
}

/// Empty when written; else why not.
std::string write_file(const fs::path& path, const std::string& bytes) {
  std::FILE* const out = std::fopen(path.c_str(), "wx");
  if (!out) return std::strerror(errno);
  const bool all = std::fwrite(bytes.data(), 1, bytes.size(), out) == bytes.size();
  return std::fclose(out) == 0 && all ? std::string() : std::strerror(errno);
}

bool holds_images(const record::Reader& reader, const std::string& topic) {
  for (const auto& [id, channel] : reader.channels()) {
    const auto schema = reader.schemas().find(channel.schema);
    if (channel.topic == topic && schema != reader.schemas().end() &&
        schema->second.name == record::image_schema().name)
      return true;
  }
  return false;
}

}  // namespace

int bag_images(const BagTopicOptions& options) {
  std::uint64_t written = 0;
  bool good = true;
  {
    Progress progress("images");
    const auto reader = open_recording(options.file, progress);
    const auto query = reader ? query_of(*reader, options.what) : std::nullopt;
    if (!query) return kNotBegun;
    const std::string& topic = options.what.topics.front();
    if (!holds_images(*reader, topic))
      return fail(topic + ": no images; they are of " + std::string(record::image_schema().name));
    std::error_code error;
    fs::create_directories(options.out, error);
    if (error) return fail(options.out + ": " + error.message());
    auto messages = reader->messages(*query);
    record::Message m;
    for (record::Next next; (next = messages.next(m)) != record::Next::end;) {
      std::string why;
      if (next == record::Next::problem) {
        std::fprintf(stderr, "%s\n", to_string(messages.problem()).c_str());
        good = false;
        continue;
      }
      const std::string png = png_of(m, why);
      if (png.empty()) return fail(fmt::format("{} {}: {}", topic, m.stamps.sequence, why), kFailed);
      // Names as data sets have them: sorted by name they are sorted by time.
      const fs::path path = fs::path(options.out) / fmt::format("{:019}.png", m.stamps.publish_time);
      if (why = write_file(path, png); !why.empty()) return fail(path.string() + ": " + why, kFailed);
      ++written;
    }
  }
  if (options.json)
    std::printf("%s", to_line({{"folder", options.out}, {"images", written}}).c_str());
  else
    std::printf("%s: %llu images\n", options.out.c_str(), static_cast<unsigned long long>(written));
  return good ? kDone : kFailed;
}

}  // namespace sinew::app
