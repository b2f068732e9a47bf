#include "apps/sim/redraw.hpp"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "apps/sim/render_test.hpp"
#include "apps/sim/scene_record.hpp"
#include "apps/sim/sim_options.hpp"
#include "hal/linux/file.hpp"
#include "hal/linux/temporary_folder.hpp"
#include "msg/image_buffer.hpp"
#include "msg/ros2_image.hpp"
#include "record/writer.hpp"
#include "sim_hil/plant/pixels.hpp"

namespace sinew::plant {
namespace {

int fail(const std::string& what, const std::string& why) {
  std::fprintf(stderr, "sinew-sim: --redraw %s: %s\n", what.c_str(), why.c_str());
  return 1;
}

/// The options of the run. False: it was said why.
bool read_world(const SceneWorld& world, const std::string& folder, SimulatorOptions& s) {
  std::vector<std::string> words{"sinew-sim"};
  words.insert(words.end(), world.words.begin(), world.words.end());
  for (const auto& [robot, text] : world.bodies) {
    const std::string path = folder + "/" + (robot.empty() ? "body" : robot) + ".toml";
    std::ofstream out(path, std::ios::binary);
    out << text;
    out.close();
    if (!out) return fail(path, "cannot be written") == 0;
    words.push_back("--body=" + (robot.empty() ? "" : robot + "=") + path);
  }
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  int exit_code = 0;
  return read_command_line(static_cast<int>(argv.size()), argv.data(), s, exit_code);
}

/// One camera of a robot.
struct Eye {
  const char* device = "";
  PixelNoise noise;
};

std::vector<Eye> eyes_of(const SimulatorOptions& s, std::size_t robot) {
  std::vector<Eye> eyes;
  const std::uint64_t seed = seed_of_robot(*s.session.seed, robot);
  for (const WorldDevice& device : s.session.world.info_of(robot).devices)
    if (device.part == Part::camera) eyes.push_back({device.name, PixelNoise(s.view.noise, seed + eyes.size())});
  return eyes;
}

/// Where a robot's pictures go. Errors: false, with `why`.
class PictureOutput {
 public:
  virtual ~PictureOutput() = default;
  virtual bool put(std::size_t camera, std::uint32_t number, hal::Time at, std::span<const std::uint8_t> pixels,
                   std::string& why) = 0;
  virtual bool finish(std::string& why) = 0;
};

class StandardOutput final : public PictureOutput {
 public:
  explicit StandardOutput(const std::vector<Eye>& eyes) : eyes_(eyes) {}
  bool put(std::size_t camera, std::uint32_t number, hal::Time, std::span<const std::uint8_t> pixels,
           std::string& why) override {
    std::printf("%s %u %zu\n", eyes_[camera].device, number, pixels.size());
    if (std::fwrite(pixels.data(), 1, pixels.size(), stdout) == pixels.size()) return true;
    why = "the pictures are not taken any more";
    return false;
  }
  bool finish(std::string& why) override {
    if (std::fflush(stdout) == 0) return true;
    why = "the pictures are not taken any more";
    return false;
  }

 private:
  const std::vector<Eye>& eyes_;
};

class PictureFile final : public PictureOutput {
 public:
  PictureFile(const std::vector<Eye>& eyes, const CameraOptions& view)
      : eyes_(eyes), view_(view), image_(view.width * view.height * msg::bytes_per_pixel(view.format)) {}

  bool open(const std::string& path, std::string& why) {
    auto file = hal::create_file(path);
    if (!file) return say(file.error(), why);
    auto writer = record::Writer::open(std::move(*file), {.profile = "ros2"});
    if (!writer) return say(writer.error(), why);
    writer_ = std::move(*writer);
    const auto& about = msg::ros2_image_schema();
    const auto schema = writer_->add_schema(about.name, "ros2msg", about.text);
    if (!schema) return say(schema.error(), why);
    for (const Eye& eye : eyes_) {
      const auto channel = writer_->add_channel(eye.device, "cdr", *schema, {}, record::Packing::plain);
      if (!channel) return say(channel.error(), why);
      channels_.push_back(*channel);
    }
    return true;
  }
  bool put(std::size_t camera, std::uint32_t number, hal::Time at, std::span<const std::uint8_t> pixels,
           std::string& why) override {
    if (!image_->format_as(view_.format, view_.width, view_.height)) {
      why = "pictures of this size are not recorded";
      return false;
    }
    image_->stamp = at;
    image_->frame_number = number;
    const auto head = msg::Ros2ImageHead::of_image(*image_, image_->bulk_used(), 0, eyes_[camera].device);
    const std::span<const std::byte> parts[] = {std::as_bytes(std::span(head.bytes())), std::as_bytes(pixels)};
    const auto time = static_cast<std::uint64_t>(at.ns);
    const hal::Status written = writer_->write_parts(channels_[camera], {number, time, time}, parts);
    return written || say(written.error(), why);
  }
  bool finish(std::string& why) override {
    const hal::Status finished = writer_->finish();
    return finished || say(finished.error(), why);
  }

 private:
  static bool say(const hal::Error& error, std::string& why) {
    why = std::string(hal::to_string(error.code)) + " (" + error.where + ")";
    return false;
  }
  const std::vector<Eye>& eyes_;
  const CameraOptions& view_;
  msg::ImageBuffer image_;
  std::unique_ptr<record::Writer> writer_;
  std::vector<std::uint16_t> channels_;
};

int draw_all(SceneFile& file, const SimulatorOptions& s, std::size_t robot, const RedrawOptions& options) {
  const CameraOptions& view = s.view;
  const auto painter = view.painter();
  const std::vector<Eye> eyes = eyes_of(s, robot);
  std::string why;
  std::unique_ptr<PictureOutput> output = std::make_unique<StandardOutput>(eyes);
  if (!options.mcap.empty()) {
    auto pictures = std::make_unique<PictureFile>(eyes, view);
    if (!pictures->open(options.mcap, why)) return fail(options.mcap, why);
    output = std::move(pictures);
  }
  const std::uint32_t row_bytes = view.width * msg::bytes_per_pixel(view.format);
  std::vector<std::uint8_t> pixels(std::size_t{row_bytes} * view.height);
  const auto wanted = [&](hal::Time at) {
    const double at_s = msg::seconds(at);
    return options.window_s.empty() || (at_s >= options.window_s[0] && at_s <= options.window_s[1]);
  };
  while (const auto taken = file.next(why))
    for (const TakenScene::Picture& p : taken->pictures) {
      if (p.robot != robot || p.camera >= eyes.size() || !wanted(taken->at)) continue;
      const auto* const drawn = reinterpret_cast<const std::uint8_t*>(painter->draw(taken->scene(p.pose)).data());
      convert_image(drawn, view.width, view.height, view.format, pixels.data(), FirstRow::top);
      if (eyes[p.camera].noise.on()) eyes[p.camera].noise.add(pixels.data(), row_bytes, view.height, p.number);
      if (!output->put(p.camera, p.number, taken->at, pixels, why)) return fail(options.file, why);
    }
  if (!why.empty() || !output->finish(why)) return fail(options.file, why);
  return 0;
}

int draw_outside(SceneFile& file, const SimulatorOptions& s, const RedrawOptions& options) {
  constexpr std::uint32_t kWidth = 960, kHeight = 540;
  std::error_code error;
  std::filesystem::create_directories(options.folder, error);
  if (error) return fail(options.folder, error.message());
  const auto painter = s.session.world.type->painter(kWidth, kHeight, s.session.world);
  const auto point = [](const std::vector<double>& v) { return msg::Vec3{v[0], v[1], v[2]}; };
  const CameraPose camera = camera_of({point(options.eye_m), point(options.target_m)});
  std::vector<double> at_s = options.at_s;
  std::ranges::sort(at_s);
  std::vector<std::uint8_t> rgb(std::size_t{kWidth} * kHeight * 3);
  const auto draw = [&](const TakenScene& taken, double wanted_s) {
    convert_image(reinterpret_cast<const std::uint8_t*>(painter->draw(taken.scene(camera)).data()), kWidth, kHeight,
                  msg::PixelFormat::rgb8, rgb.data(), FirstRow::top);
    char name[32];
    std::snprintf(name, sizeof name, "at-%.1f.png", wanted_s);
    return write_png(std::filesystem::path(options.folder) / name, kWidth, kHeight, rgb);
  };
  std::string why;
  std::optional<TakenScene> last;
  std::size_t next = 0;
  while (next < at_s.size()) {
    auto taken = file.next(why);
    if (!why.empty()) return fail(options.file, why);
    for (; next < at_s.size() && last && (!taken || msg::seconds(taken->at) > at_s[next]); ++next)
      if (!draw(*last, at_s[next])) return 1;
    if (!taken) break;
    last = std::move(taken);
  }
  return next == at_s.size() ? 0 : fail(options.file, "it has no scene at that time");
}

}  // namespace

int redraw(const RedrawOptions& options) {
  std::string why;
  const auto file = SceneFile::open(options.file, why);
  if (!file) return fail(options.file, why);
  const auto folder = hal::TemporaryFolder::make("sinew-redraw");
  if (!folder) return fail(options.file, "no temporary folder");
  SimulatorOptions s;
  if (!read_world(file->world(), (*folder)->path(), s)) return 1;
  if (!s.view.painter || !s.session.seed) return fail(options.file, "its world cannot be drawn again");
  if (options.of.empty()) return draw_outside(*file, s, options);
  const auto& robots = s.session.world.robots;
  const auto robot = std::ranges::find(robots, options.of, &NamedRobot::name);
  if (robot == robots.end() && !robots.empty()) return fail(options.file, "no robot " + options.of + " in it");
  return draw_all(*file, s, static_cast<std::size_t>(robot - robots.begin()), options);
}

}  // namespace sinew::plant
