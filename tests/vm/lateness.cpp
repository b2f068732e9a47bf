// How late a 1 kHz thread is while vision works on the same processor: our executor and our vision, measured by the
// executor's own statistics. For a machine whose time does not depend on the host's (tests/vm/boot.sh icount);
// elsewhere its verdict says nothing.
//
//   vm_lateness REFERENCE      0 when no release was missed and p50, p99 are within a factor 2 of the file's, else 1
//   vm_lateness --vision-first 0 when the executor counts overruns once vision has the higher priority, else 1
#include <algorithm>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <map>
#include <string>

#include "hal/board.hpp"
#include "hal/platform.hpp"
#include "msg/flight.hpp"
#include "rt/exec/real_time_executor.hpp"
#include "vision/pad_detector.hpp"

namespace sinew::vm {
namespace {

using namespace std::chrono_literals;

constexpr std::uint32_t kWidth = 320, kHeight = 240;
constexpr msg::Duration kPeriod = 1ms, kFramePeriod = 40ms, kMeasured = 5s;
constexpr double kFactor = 2;  // either side: a result twice as good needs a new reference

/// Draws an orange pad that travels over a textured floor.
class PaintedCamera final : public rt::Module {
 public:
  void declare(rt::Declaration& d) override { d.out("raw", image_); }
  rt::StepStatus step(const rt::Step& step) noexcept override {
    auto& image = image_.loan();
    image.stamp = step.now;
    image.frame_number = static_cast<std::uint32_t>(step.number);
    if (!image.format_as(msg::PixelFormat::rgb8, kWidth, kHeight)) return rt::StepStatus::fault;
    const int cx = 60 + static_cast<int>(step.number % 200), cy = 120;
    for (int y = 0; y < static_cast<int>(kHeight); ++y) {
      std::uint8_t* pixel = image.row(static_cast<std::uint32_t>(y));
      for (int x = 0; x < static_cast<int>(kWidth); ++x, pixel += 3) {
        const bool pad = (x - cx) * (x - cx) + (y - cy) * (y - cy) < 40 * 40;
        const auto floor = static_cast<std::uint8_t>(40 + ((x * 7 + y * 13) & 31));
        pixel[0] = pad ? 230 : floor, pixel[1] = pad ? 110 : floor, pixel[2] = pad ? 20 : floor;
      }
    }
    return rt::StepStatus::ok;
  }

 private:
  rt::Out<msg::Image> image_;
};

/// Follows the pad at 1 kHz, as a joint's loop would with vision's last result.
class Follower final : public rt::Module {
 public:
  void declare(rt::Declaration& d) override {
    d.in("sighting", sighting_);
    d.out("angle", angle_);
  }
  rt::StepStatus step(const rt::Step& step) noexcept override {
    const auto* seen = sighting_.get();
    if (seen && seen->found) {
      if (seen->stamp != last_) ++sightings, last_ = seen->stamp;
      angle_rad_ += (seen->direction_optical.x - angle_rad_) * 0.01;
    }
    auto& out = angle_.loan();
    out.stamp = step.now;
    out.range_m = angle_rad_;
    return rt::StepStatus::ok;
  }
  std::uint64_t sightings = 0;

 private:
  rt::In<msg::PadSighting> sighting_;
  rt::Out<msg::RangeSample> angle_;
  msg::Time last_{};
  double angle_rad_ = 0;
};

rt::GraphSpec robot(bool vision_first) {
  rt::GraphSpec spec;
  spec.robot = "lateness";
  spec.modules = {{.name = "camera", .type = "PaintedCamera"},
                  {.name = "finder", .type = "vision::PadDetector", .in = {{"image", {"camera.raw"}}}},
                  {.name = "follower", .type = "Follower", .in = {{"sighting", {"finder.sighting"}}}}};
  spec.threads = {{.name = "loop", .priority = 50, .period = kPeriod, .order = {{"follower"}}},
                  {.name = "vision",
                   .priority = vision_first ? 60 : 20,
                   .period = kFramePeriod,
                   .order = {{"camera"}, {"finder"}}}};
  spec.topics = {{.name = "camera.raw", .image_bytes = kWidth * kHeight * 3}};
  return spec;
}

/// Lines "name value"; '#' begins a comment.
std::map<std::string, double> read_reference(const char* path) {
  std::map<std::string, double> out;
  std::ifstream file(path);
  for (std::string name; file >> name;) {
    if (name[0] == '#')
      std::getline(file, name);
    else
      file >> out[name];
  }
  return out;
}

struct Verdict {
  bool good = true;
  void expect(bool holds, const char* what) {
    if (!holds) std::printf("FAILED: %s\n", what);
    good &= holds;
  }
};

void compare(const rt::Histogram& lateness, const char* path, Verdict& verdict) {
  const auto reference = read_reference(path);
  for (const auto& [name, quantile] : {std::pair{"lateness_p50_ns", 0.5}, {"lateness_p99_ns", 0.99}}) {
    const auto wanted = reference.find(name);
    const auto seen = static_cast<double>(lateness.quantile(quantile).count());
    if (wanted == reference.end() || wanted->second <= 0) {
      std::printf("%s: not in %s\n", name, path);
      verdict.good = false;
      continue;
    }
    std::printf("%s %.0f, reference %.0f\n", name, seen, wanted->second);
    verdict.expect(seen <= wanted->second * kFactor && seen >= wanted->second / kFactor, name);
  }
}

int run(const char* reference) {
  const bool vision_first = std::strcmp(reference, "--vision-first") == 0;
  rt::ModuleTypes types;
  types.add<PaintedCamera>("PaintedCamera");
  types.add<Follower>("Follower");
  types.add<vision::PadDetector>("vision::PadDetector");
  rt::Graph graph(robot(vision_first), types);
  hal::EmptyBoard board;
  for (const auto& p : graph.check({})) std::printf("%s\n", rt::to_string(p, "lateness").c_str());
  if (!graph.check({}).empty() || !graph.configure(board)) return 2;

  hal::Os& os = hal::system_os();
  rt::RealTimeOptions options;
  options.strict = true;  // not a figure without fixed priorities and locked memory
  rt::RealTimeExecutor executor(graph, os, options);
  if (const auto started = executor.start(); !started) {
    for (const auto& line : executor.shortfalls()) std::printf("not granted: %s\n", line.c_str());
    return 2;
  }
  os.sleep_until(executor.started_at() + kMeasured);
  executor.stop();

  const auto& loop = executor.runner().thread_stats(graph.find_thread("loop"));
  const auto& vision = executor.runner().thread_stats(graph.find_thread("vision"));
  const auto& follower = static_cast<const Follower&>(*graph.modules()[graph.find_module("follower")].module);
  const auto ns = [](msg::Duration d) { return static_cast<long long>(d.count()); };
  std::printf("loop: %llu cycles, %llu overruns, %llu skips, lateness min %lld, p50 %lld, p99 %lld, max %lld ns\n",
              static_cast<unsigned long long>(loop.completions.value()),
              static_cast<unsigned long long>(loop.overruns.value()),
              static_cast<unsigned long long>(loop.skips.value()), ns(loop.lateness.min()),
              ns(loop.lateness.quantile(0.5)), ns(loop.lateness.quantile(0.99)), ns(loop.lateness.max()));
  std::printf("vision: %llu frames of %lld us (p50), the pad seen in %llu\n",
              static_cast<unsigned long long>(vision.completions.value()), ns(vision.exec.quantile(0.5)) / 1000,
              static_cast<unsigned long long>(follower.sightings));

  Verdict verdict;
  constexpr auto frames = static_cast<std::uint64_t>(kMeasured / kFramePeriod);
  verdict.expect(follower.sightings + 5 >= frames, "vision sees the pad in each frame");
  verdict.expect(vision.exec.quantile(0.5) > 2 * kPeriod, "vision works for longer than the loop's period");
  if (vision_first) {
    verdict.expect(loop.skips.value() > 0, "the loop misses releases while vision goes first");
    return verdict.good ? 0 : 1;
  }
  verdict.expect(loop.completions.value() + 5 >= static_cast<std::uint64_t>(kMeasured / kPeriod), "all cycles ran");
  verdict.expect(loop.overruns.value() == 0 && loop.skips.value() == 0, "no overrun");
  compare(loop.lateness, reference, verdict);
  return verdict.good ? 0 : 1;
}

}  // namespace
}  // namespace sinew::vm

int main(int argc, char** argv) {
  if (argc == 2) return sinew::vm::run(argv[1]);
  std::fprintf(stderr, "usage: vm_lateness REFERENCE | --vision-first\n");
  return 2;
}
