#include "apps/calibrate/recorded_boards.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "msg/ros2_image.hpp"
#include "record/run/run_messages.hpp"
#include "vision/luma.hpp"

namespace sinew::app {
namespace {

constexpr double kStill_px = 0.7;  // from one picture to the next: its corners are sharp
constexpr std::size_t kEnoughStill = 10;
constexpr double kInf = std::numeric_limits<double>::infinity();

msg::PixelFormat format_of(std::string_view encoding) {
  for (const auto& [name, format] : msg::kPixelFormats)
    if (msg::ros2_encoding(format) == encoding) return format;
  return msg::PixelFormat::none;
}

std::optional<std::string> topic_of(const record::Reader& reader, const std::string& named, std::string& why) {
  std::string all, only;
  std::size_t count = 0;
  for (const auto& [id, channel] : reader.channels()) {
    const auto schema = reader.schemas().find(channel.schema);
    if (schema == reader.schemas().end() || schema->second.name != record::image_schema().name) continue;
    if (channel.topic == named) return named;
    all += (all.empty() ? "" : ", ") + channel.topic, only = channel.topic, ++count;
  }
  if (count == 0)
    why = "it has no topic of images";
  else if (!named.empty())
    why = "--topic " + named + ": it has no such topic of images; it has: " + all;
  else if (count > 1)
    why = "it has several topics of images: " + all + "; choose one with --topic";
  return why.empty() ? std::optional(only) : std::nullopt;
}

}  // namespace

double farthest_px(const SeenBoard& a, const SeenBoard& b) {
  double most = 0;
  for (std::size_t i = 0; i < a.corners.size(); ++i)
    most = std::max(most, std::hypot(a.corners[i].u_px - b.corners[i].u_px, a.corners[i].v_px - b.corners[i].v_px));
  return most;
}

std::optional<RecordedBoards> read_boards(record::Reader& reader, const std::string& topic,
                                          const vision::BoardSize& size, std::string& why) {
  const auto found = topic_of(reader, topic, why);
  if (!found) return std::nullopt;
  RecordedBoards all;
  all.topic = *found;
  vision::BoardFinder finder(size);
  vision::Luma luma(std::size_t{msg::kMaxImageWidth} * msg::kMaxImageHeight);
  record::MessageReader messages = reader.messages({.topics = {*found}});
  record::Message m;
  bool before = false;  // the picture before shows it, too
  std::size_t without_pixels = 0;
  for (record::Next next; (next = messages.next(m)) != record::Next::end;) {
    if (next == record::Next::problem) continue;  // what is missing is missing: each view stands for itself
    const auto view = record::view_image(m.data);
    if (!view) {
      why = *found + ": its bytes are no sensor_msgs/msg/Image";
      return std::nullopt;
    }
    const msg::PixelFormat format = format_of(view->encoding);
    if (format != msg::PixelFormat::mono8 && format != msg::PixelFormat::yuyv) {
      why = fmt::format("{}: encoding {} has no grey values: mono8 or yuv422_yuy2", *found, view->encoding);
      return std::nullopt;
    }
    const std::uint64_t row = std::uint64_t{view->width} * msg::bytes_per_pixel(format);
    if (view->width == 0 || view->height == 0 || view->width > msg::kMaxImageWidth ||
        view->height > msg::kMaxImageHeight || view->stride < row ||
        view->pixels.size() < std::uint64_t{view->stride} * (view->height - 1) + row) {
      ++without_pixels;
      before = false;
      continue;
    }
    if (all.pictures > 0 && (all.width != view->width || all.height != view->height)) {
      why = fmt::format("{}: pictures of several sizes, {} x {} and {} x {}", *found, all.width, all.height,
                        view->width, view->height);
      return std::nullopt;
    }
    all.width = view->width, all.height = view->height, ++all.pictures;
    const vision::ImageView image{reinterpret_cast<const std::uint8_t*>(view->pixels.data()), view->width, view->height,
                                  view->stride, format};
    if (!luma.take(image, 1) || !finder.find(luma.view())) {
      before = false;
      continue;
    }
    SeenBoard seen{view->stamp_ns, {finder.corners().begin(), finder.corners().end()}, kInf};
    if (before) {
      seen.moved_px = farthest_px(seen, all.boards.back());
      all.boards.back().moved_px = std::min(all.boards.back().moved_px, seen.moved_px);
    }
    if (all.sample.empty() || all.boards.size() % 16 == 0)
      all.sample.assign(luma.view().data, luma.view().data + std::size_t{all.width} * all.height);
    all.boards.push_back(std::move(seen));
    before = true;
  }
  if (all.pictures == 0) {
    why = without_pixels > 0 ? *found + ": its pixels were not recorded: `sinew run --record-images`"
                             : *found + ": it has no pictures";
    return std::nullopt;
  }
  return all;
}

std::vector<SeenBoard> choose_boards(const std::vector<SeenBoard>& all, std::size_t most) {
  std::vector<SeenBoard> from;
  for (const SeenBoard& b : all)
    if (b.moved_px < kStill_px) from.push_back(b);
  if (from.size() < kEnoughStill) from = all;
  if (from.empty()) return from;
  // The next one is always that which is farthest from those that there are.
  std::vector<bool> taken(from.size());
  std::vector<double> apart(from.size(), kInf);
  std::size_t next = 0;
  for (std::size_t n = 0; n < std::min(most, from.size()); ++n) {
    taken[next] = true;
    std::size_t best = next;
    double farthest = 0;
    for (std::size_t i = 0; i < from.size(); ++i) {
      apart[i] = std::min(apart[i], farthest_px(from[i], from[next]));
      if (!taken[i] && apart[i] > farthest) farthest = apart[i], best = i;
    }
    if (best == next || farthest < 2 * kStill_px) break;  // the rest are the same views again
    next = best;
  }
  std::vector<SeenBoard> chosen;
  for (std::size_t i = 0; i < from.size(); ++i)
    if (taken[i]) chosen.push_back(from[i]);
  return chosen;
}

}  // namespace sinew::app
