// A robot for tests of the monitor: that of the tests of tap, and a camera; in real time, or in virtual time that goes
// as fast as the wall's.
//   monitor_robot NAME [--virtual] [--camera WIDTH HEIGHT HZ] [--discs]        ends with SIGTERM
#include <algorithm>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <optional>
#include <random>
#include <thread>

#include "../../bench/camera_scene.hpp"
#include "../tap/tap_rig.hpp"

namespace {

using namespace sinew;
using namespace std::chrono_literals;

struct Options {
  std::string name;
  bool virtual_time = false, discs = false;
  std::uint32_t width = 320, height = 240;
  int hz = 30;
} options;

volatile std::sig_atomic_t ended = 0;

/// The time of a picture is that of its step.
class Camera final : public rt::Module {
 public:
  Camera() {
    if (options.discs) discs_.emplace(options.width, options.height);
  }
  void declare(rt::Declaration& d) override { d.out("raw", out_); }
  rt::StepStatus step(const rt::Step& step) noexcept override {
    msg::Image& image = out_.loan();
    if (!image.format_as(msg::PixelFormat::yuyv, options.width, options.height)) return rt::StepStatus::fault;
    image.stamp = step.now;
    image.frame_number = ++frame_;
    if (discs_)
      std::copy(discs_->picture(frame_).begin(), discs_->picture(frame_).end(), image.pixels());
    else
      squares_.paint(frame_, image.width, image.height, [&image](std::uint32_t y) { return image.row(y); });
    return rt::StepStatus::ok;
  }

 private:
  rt::Out<msg::Image> out_;
  std::uint32_t frame_ = 0;
  bench::NoisySquares squares_;
  std::optional<bench::ShadedDiscs> discs_;
};

/// Grants virtual time as it passes on the wall.
class WallGrants final : public hal::GrantSource {
 public:
  hal::Result<hal::Time> next_grant(hal::Time done_to) override {
    if (ended != 0) return hal::Error{hal::Errc::closed, "end of run"};
    std::this_thread::sleep_until(begin_ + std::chrono::nanoseconds(done_to.ns));
    return done_to + hal::Duration(5ms);
  }

 private:
  const std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
};

bool read_options(int argc, char** argv) {
  if (argc < 2) return false;
  options.name = argv[1];
  for (int i = 2; i < argc; ++i) {
    if (std::strcmp(argv[i], "--virtual") == 0) {
      options.virtual_time = true;
    } else if (std::strcmp(argv[i], "--discs") == 0) {
      options.discs = true;
    } else if (std::strcmp(argv[i], "--camera") == 0 && i + 3 < argc) {
      options.width = static_cast<std::uint32_t>(std::atoi(argv[++i]));
      options.height = static_cast<std::uint32_t>(std::atoi(argv[++i]));
      options.hz = std::atoi(argv[++i]);
    } else {
      return false;
    }
  }
  return options.hz > 0;
}

rt::GraphSpec spec() {
  tap::GraphOptions o;
  o.name = options.name, o.period = 5ms, o.eye_period = 20ms;
  rt::GraphSpec g = tap::robot_spec(o);
  rt::ModuleSpec camera;
  camera.name = "camera", camera.type = "test::Camera";
  camera.exec = {rt::ExecModel::Kind::constant, 100us, {}, 1.0, {}};
  g.modules.push_back(std::move(camera));
  rt::ThreadSpec thread;
  thread.name = "camera", thread.period = hal::Duration(1s) / options.hz, thread.priority = 10;
  thread.order = {{"camera", 0}};
  g.threads.push_back(std::move(thread));
  rt::TopicSpec raw;
  raw.name = "camera.raw", raw.image_bytes = options.width * options.height * 2;
  g.topics.push_back(std::move(raw));
  return g;
}

}  // namespace

int main(int argc, char** argv) {
  if (!read_options(argc, argv)) {
    std::fprintf(stderr, "usage: monitor_robot NAME [--virtual] [--camera WIDTH HEIGHT HZ] [--discs]\n");
    return 2;
  }
  std::signal(SIGTERM, [](int) { ended = 1; });
  std::signal(SIGINT, [](int) { ended = 1; });
  rt::ModuleTypes types = tap::robot_types();
  types.add<Camera>("test::Camera");
  hal::Os& os = hal::system_os();
  rt::Graph graph(spec(), types);
  for (const auto& p : graph.check({.virtual_time = options.virtual_time}))
    std::fprintf(stderr, "%s\n", rt::to_string(p, "robot").c_str());
  hal::EmptyBoard board;
  rt::ConfigureOptions configure;
  configure.os = &os;
  if (!graph.configure(board, configure)) return 1;
  std::string why;
  const auto name = tap::Name::take(options.name, why);
  if (!name) {
    std::fprintf(stderr, "%s\n", why.c_str());
    return 1;
  }
  tap::ServerOptions socket;
  socket.virtual_time = options.virtual_time, socket.stop = [] { ended = 1; };
  if (options.virtual_time) {
    hal::ManualClock clock;
    WallGrants grants;
    rt::DiscreteExecutor executor(graph, clock, grants);
    socket.clock = &clock;
    const auto server = tap::Server::open(**name, graph, executor.runner(), os, socket);
    if (!server) return 1;
    std::puts("ready"), std::fflush(stdout);
    return executor.run() ? 0 : 1;
  }
  rt::RealTimeOptions o;
  o.lock_memory = false, o.fixed_priority = false;
  rt::RealTimeExecutor executor(graph, os, o);
  if (!executor.start()) return 1;
  {
    const auto server = tap::Server::open(**name, graph, executor.runner(), os, socket);
    if (!server) return 1;
    std::puts("ready"), std::fflush(stdout);
    while (ended == 0) os.sleep_until(os.now() + 20ms);
  }
  executor.stop();
  return 0;
}
