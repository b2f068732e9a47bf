#include "apps/sight/carpets.hpp"

#include <algorithm>
#include <cstdio>
#include <map>

#include "hal/linux/file.hpp"
#include "msg/cdr.hpp"
#include "msg/ros2msg.hpp"
#include "record/reader.hpp"
#include "record/run/run_messages.hpp"
#include "soccer/sight/picture.hpp"

namespace sinew::sight {
namespace {

/// Measures one picture after the other, each by itself.
class Measurer {
 public:
  explicit Measurer(Carpets& out) : out_(out) {}
  void add(const vision::ImageView& image, const soccer::GroundView& view) {
    ++out_.pictures;
    soccer::CarpetLook look;
    if (!view.is_upright() || !meter_.measure(image, view, look)) return;
    out_.looks.push_back(look);
    colours_.set(look);
    if (!picture_.read(image, colours_)) return;
    for (int y = 0; y < picture_.height(); ++y)
      for (int x = 0; x < picture_.width(); ++x) ++out_.classes[static_cast<std::size_t>(picture_.at(x, y))];
  }

 private:
  Carpets& out_;
  soccer::CarpetMeter meter_;
  soccer::FieldColours colours_;
  soccer::Picture picture_;
};

template <class M>
bool is_of(const record::Reader& reader, const std::string& topic, std::string_view name, std::string& why) {
  for (const auto& [id, channel] : reader.channels()) {
    const auto schema = reader.schemas().find(channel.schema);
    if (channel.topic == topic && schema != reader.schemas().end() && schema->second.name == name) return true;
  }
  why = "no topic " + topic + " of " + std::string(name);
  return false;
}

struct Bounds {
  double low, middle, high;
};
Bounds bounds(const Carpets& c, double soccer::CarpetLook::*what) {
  std::vector<double> all;
  for (const soccer::CarpetLook& l : c.looks) all.push_back(l.*what);
  std::ranges::sort(all);
  return {all[all.size() * 5 / 100], all[all.size() / 2], all[all.size() * 95 / 100]};
}

}  // namespace

bool measure_record(const std::string& path, const RecordTopics& topics, Carpets& out, std::string& why) {
  auto file = hal::open_file(path);
  if (!file) return why = path + ": cannot be opened", false;
  record::FileProblem problem;
  const auto reader = record::Reader::open(std::move(*file), problem);
  if (!reader) return why = path + ": no record", false;
  if (!is_of<msg::CameraPose>(*reader, topics.pose, msg::ros2_name(msg::type_info<msg::CameraPose>()), why) ||
      !is_of<msg::Image>(*reader, topics.image, record::image_schema().name, why))
    return why = path + ": " + why, false;
  // A picture comes before its pose; both have the stamp of the exposure.
  std::map<std::int64_t, msg::CameraPose> poses;
  record::Message m;
  {
    auto messages = reader->messages({.topics = {topics.pose}});
    for (record::Next next; (next = messages.next(m)) != record::Next::end;) {
      msg::CameraPose pose;
      if (next == record::Next::problem) continue;  // told with the pictures
      if (!msg::cdr_decode(msg::type_info<msg::CameraPose>(),
                           {reinterpret_cast<const std::uint8_t*>(m.data.data()), m.data.size()}, &pose))
        return why = path + ": " + topics.pose + ": of another version", false;
      poses[pose.stamp.ns] = pose;
    }
  }
  Measurer measurer(out);
  auto messages = reader->messages({.topics = {topics.image}});
  for (record::Next next; (next = messages.next(m)) != record::Next::end;) {
    if (next == record::Next::problem) return why = path + ": " + to_string(messages.problem()), false;
    const auto image = record::view_image(m.data);
    if (!image || image->encoding != msg::ros2_encoding(msg::PixelFormat::yuyv) || image->width > 640 ||
        image->height > 480 || image->width % 2 != 0 || image->stride < 2 * image->width ||
        image->pixels.size() < std::size_t{image->stride} * image->height)
      return why = path + ": " + topics.image + ": pictures must be yuyv, up to 640 x 480", false;
    const auto pose = poses.find(image->stamp_ns);
    if (pose == poses.end()) continue;
    const auto camera = vision::Pinhole::from_fov(topics.fov_y_rad, image->width, image->height);
    // The frame "robot": below the camera, as only distances to it matter.
    const soccer::RobotAt robot{pose->second.p_world_m.x, pose->second.p_world_m.y, 0};
    measurer.add({reinterpret_cast<const std::uint8_t*>(image->pixels.data()), image->width, image->height,
                  image->stride, msg::PixelFormat::yuyv},
                 soccer::GroundView(camera, pose->second, robot, {}));
  }
  if (out.pictures == 0) return why = path + ": no picture of " + topics.image + " has a pose of its time", false;
  return true;
}

void measure_photos(std::span<const Photo> photos, double height_m, Carpets& out) {
  Measurer measurer(out);
  for (const Photo& p : photos) {
    PhotoCamera camera;
    camera.camera = {0.9 * p.width, 0.9 * p.width, 0.5 * (p.width - 1.0), 0.5 * (p.height - 1.0)};
    camera.horizon_px = camera.camera.cy_px, camera.height_m = height_m;
    measurer.add(p.view(), soccer::GroundView(camera.camera, camera.pose(), {}, {}));
  }
}

soccer::CarpetLook median(const Carpets& c) {
  using L = soccer::CarpetLook;
  return {bounds(c, &L::luma).middle, bounds(c, &L::u).middle, bounds(c, &L::v).middle, bounds(c, &L::spread).middle};
}

std::string report(const Carpets& c) {
  using L = soccer::CarpetLook;
  char line[200];
  std::snprintf(line, sizeof line,
                "%zu pictures, %zu with a carpet\n\n| carpet | 5 %% of pictures | half | 95 %% |\n|---|---|---|---|\n",
                c.pictures, c.looks.size());
  std::string out = line;
  const std::pair<const char*, double L::*> rows[] = {
      {"luma", &L::luma}, {"u", &L::u}, {"v", &L::v}, {"spread", &L::spread}};
  for (const auto& [name, what] : rows) {
    const Bounds b = bounds(c, what);
    std::snprintf(line, sizeof line, "| %s | %.3f | %.3f | %.3f |\n", name, b.low, b.middle, b.high);
    out += line;
  }
  std::uint64_t all = 0;
  for (const std::uint64_t n : c.classes) all += n;
  constexpr const char* kNames[] = {"other", "carpet", "white", "dark", "blue", "red"};
  out += "\nPixels:";
  for (std::size_t i = 0; i < c.classes.size(); ++i) {
    std::snprintf(line, sizeof line, "%s %s %.1f %%", i > 0 ? "," : "", kNames[i],
                  100.0 * static_cast<double>(c.classes[i]) / static_cast<double>(std::max<std::uint64_t>(1, all)));
    out += line;
  }
  const L l = median(c);
  std::snprintf(line, sizeof line,
                "\n\nparams = { carpet_luma = %.1f, carpet_u = %.3f, carpet_v = %.3f, carpet_spread = %.3f }\n", l.luma,
                l.u, l.v, l.spread);
  return out + line;
}

}  // namespace sinew::sight
