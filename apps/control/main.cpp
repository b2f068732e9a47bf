// sinew-control: the smallest robot that controls something. It has the modules of a quadrotor's 1 kHz thread (IMU,
// filter, attitude, mixer) and the guardian, but no robot file, camera, recorder, network or monitor. In real time it
// brings a body on a stand from 17 degrees to level. To control your own body, put your board in the place of
// app::Stand.
#include <charconv>
#include <cstdio>
#include <string_view>

#include "apps/control/stand.hpp"
#include "control/attitude_controller.hpp"
#include "control/error_state_filter.hpp"
#include "control/mixer.hpp"
#include "drivers/sources/sensor_source.hpp"
#include "hal/linux/memory.hpp"
#include "hal/linux/process.hpp"
#include "hal/platform.hpp"
#include "hal/scaled_os.hpp"
#include "rt/exec/real_time_executor.hpp"

using namespace sinew;
using namespace std::chrono_literals;

namespace {

constexpr double kRunFor_s = 2, kStartTilt_rad = 0.3, kLevel_rad = 0.02, kShortest_s = 0.01, kLongest_s = 1e6;

/// Commands a level attitude, with the thrust that carries the body.
class Level final : public rt::Module {
  void declare(rt::Declaration& d) override { d.out("attitude", out_); }
  rt::StepStatus step(const rt::Step& step) noexcept override {
    msg::AttitudeSetpoint& wanted = out_.loan();
    wanted.stamp = step.now;
    wanted.q_world_base.w = 1;
    wanted.thrust_n = 12;
    wanted.armed = 1;
    return rt::StepStatus::ok;
  }
  rt::Out<msg::AttitudeSetpoint> out_;
};

rt::GraphSpec robot() {
  rt::GraphSpec spec;
  spec.robot = "control";
  spec.modules = {
      {.name = "imu", .type = "ImuSource"},
      {.name = "level", .type = "Level"},
      {.name = "filter", .type = "Filter", .in = {{"imu", {"imu.raw"}}}},
      {.name = "attitude", .type = "Attitude", .in = {{"state", {"filter.state"}}, {"attitude", {"level.attitude"}}}},
      {.name = "mixer", .type = "Mixer", .in = {{"wrench", {"attitude.wrench"}}}}};
  spec.threads = {{.name = "stabilise",
                   .priority = 80,
                   .period = 1ms,
                   .stack_kib = 64,
                   .order = {{"imu"}, {"level"}, {"filter"}, {"attitude"}, {"mixer"}}}};
  spec.actuators = {{.name = "motors", .command = {"mixer.motors"}, .channels = 4, .max = 1, .lease = 20ms}};
  spec.tap_history = rt::Duration{0};  // no monitor reads; its history is most of the topics' memory
  return spec;
}

constexpr const char* kUsage =
    "usage: sinew-control [SECONDS [RATE]]\n"
    "Brings a simulated body on a stand to the level, in real time.\n"
    "  SECONDS   how long it runs; 2 by default\n"
    "  RATE      of its clock, 0.01 to 1: slower than real time for an emulator that cannot keep 1 ms\n"
    "0: level in the end; 1: not; 2: could not begin.\n";

bool read_number(std::string_view text, double least, double most, double& number) {
  const auto end = text.data() + text.size();
  const auto read = std::from_chars(text.data(), end, number);
  return read.ec == std::errc() && read.ptr == end && number >= least && number <= most;
}

int fail(const hal::Error& e) {
  std::fprintf(stderr, "sinew-control: %s: %s (%lld)\n", e.where, hal::to_string(e.code),
               static_cast<long long>(e.detail));
  return 2;
}

unsigned long long whole(std::uint64_t n) { return n; }

void report(const rt::ThreadStats& s, const app::Stand& stand, const hal::MemoryUse& m) {
  std::printf("cycles %llu, overruns %llu, commands %u\n", whole(s.completions.value()), whole(s.overruns.value()),
              stand.commands());
  std::printf("tilt %.1f mrad, at first %.1f\n", stand.tilt_rad() * 1e3, kStartTilt_rad * 1e3);
  std::printf("memory %llu kB: program %llu, libraries %llu, topics and heap %llu, stacks %llu\n",
              whole(m.total / 1024), whole(m.program / 1024), whole(m.libraries / 1024),
              whole((m.slots + m.heap) / 1024), whole(m.stacks / 1024));
}

}  // namespace

int main(int count, char** words) {
  double run_for_s = kRunFor_s, rate = 1;
  if (count == 2 && std::string_view(words[1]) == "--help") {
    std::fputs(kUsage, stdout);
    return 0;
  }
  if (count > 3 || (count > 1 && !read_number(words[1], kShortest_s, kLongest_s, run_for_s)) ||
      (count > 2 && !read_number(words[2], 0.01, 1, rate))) {
    std::fputs(kUsage, stderr);
    return 2;
  }
  rt::ModuleTypes types;
  types.add<drivers::ImuSource>("ImuSource");
  types.add<Level>("Level");
  types.add<control::ErrorStateFilter>("Filter");
  types.add<control::AttitudeController>("Attitude");
  types.add<control::Mixer>("Mixer");
  rt::Graph graph(robot(), types);
  const auto problems = graph.check();
  for (const rt::Problem& p : problems) std::fprintf(stderr, "%s\n", rt::to_string(p, "main.cpp").c_str());
  if (!problems.empty()) return 2;

  hal::ScaledOs os(hal::system_os(), rate);
  app::Stand stand(os, kStartTilt_rad);
  if (const auto ready = graph.configure(stand); !ready) return fail(ready.error());
  rt::RealTimeExecutor executor(graph, os);
  if (const auto started = executor.start(); !started) return fail(started.error());
  const hal::Time ready = hal::system_os().now();
  for (const auto& line : executor.shortfalls()) std::printf("not granted: %s\n", line.c_str());
  os.sleep_until(executor.started_at() + rt::Duration{static_cast<std::int64_t>(run_for_s * 1e9)});
  const hal::MemoryUse memory = hal::memory_use();
  executor.stop();
  report(executor.runner().thread_stats(graph.find_thread("stabilise")), stand, memory);
  // Threads made and memory locked; the first cycle follows 20 ms later.
  if (const auto began = hal::process_start())
    std::printf("ready %.2f s after the start\n", msg::seconds(ready - *began));
  return stand.commands() > 0 && stand.tilt_rad() < kLevel_rad ? 0 : 1;
}
