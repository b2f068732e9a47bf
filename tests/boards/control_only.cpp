// The smallest robot that controls something, to be measured on boards: what a quadrotor's 1 kHz thread has (filter,
// attitude, mixer) on motors that only count, in real time for two seconds, without robot file, simulator or recorder.
// Prints what the process has in memory and how long it took to its first cycle. Fails when no command reached a motor.
#include <cstdio>

#include "control/attitude_controller.hpp"
#include "control/error_state_filter.hpp"
#include "control/mixer.hpp"
#include "hal/linux/memory.hpp"
#include "hal/linux/os.hpp"
#include "hal/linux/process.hpp"
#include "msg/sensors.hpp"
#include "rt/real_time_executor.hpp"

using namespace sinew;
using namespace std::chrono_literals;

namespace {

/// An IMU that lies on a table.
class AtRest final : public rt::Module {
  void declare(rt::Declaration& d) override { d.out("raw", out_); }
  rt::Status step(const rt::Step& step) noexcept override {
    msg::ImuSample& sample = out_.loan();
    sample.stamp = step.now;
    sample.gyro_radps = {};
    sample.accel_mps2 = {0, 0, 9.80665};
    return rt::Status::ok;
  }
  rt::Out<msg::ImuSample> out_;
};

/// Wants to stay level.
class Hover final : public rt::Module {
  void declare(rt::Declaration& d) override { d.out("attitude", out_); }
  rt::Status step(const rt::Step& step) noexcept override {
    msg::AttitudeSetpoint& wanted = out_.loan();
    wanted = {};
    wanted.stamp = step.now;
    wanted.q_world_base.w = 1;
    wanted.thrust_n = 12;
    wanted.armed = 1;
    return rt::Status::ok;
  }
  rt::Out<msg::AttitudeSetpoint> out_;
};

class Motors final : public hal::EmptyBoard, public hal::Actuators {
 public:
  hal::Result<hal::Actuators*> actuators(std::string_view) override { return static_cast<hal::Actuators*>(this); }
  hal::Status write(const msg::ActuatorCommand&, hal::Duration) noexcept override { return ++commands, hal::Status(); }
  hal::Status stop() noexcept override { return {}; }
  std::uint32_t commands = 0;  // written by the guardian's thread, read when that has ended
};

rt::GraphSpec quad() {
  rt::GraphSpec spec;
  spec.modules = {
      {.name = "imu", .type = "AtRest"},
      {.name = "hover", .type = "Hover"},
      {.name = "filter", .type = "Filter", .in = {{"imu", {"imu.raw"}}}},
      {.name = "attitude", .type = "Attitude", .in = {{"state", {"filter.state"}}, {"attitude", {"hover.attitude"}}}},
      {.name = "mixer", .type = "Mixer", .in = {{"wrench", {"attitude.wrench"}}}}};
  spec.threads = {{.name = "stabilise",
                   .priority = 80,
                   .period = 1ms,
                   .stack_kib = 64,
                   .order = {{"imu"}, {"hover"}, {"filter"}, {"attitude"}, {"mixer"}}}};
  spec.actuators = {{.name = "motors", .command = {"mixer.motors"}, .channels = 4, .max = 1, .lease = 20ms}};
  return spec;
}

}  // namespace

int main() {
  rt::ModuleTypes types;
  types.add<AtRest>("AtRest");
  types.add<Hover>("Hover");
  types.add<control::ErrorStateFilter>("Filter");
  types.add<control::AttitudeController>("Attitude");
  types.add<control::Mixer>("Mixer");
  rt::Graph graph(quad(), types);
  Motors motors;
  bool ready = true;
  for (const rt::Problem& p : graph.check()) std::printf("%s\n", rt::to_string(p, "quad").c_str()), ready = false;
  if (!ready || !graph.configure(motors)) return 2;

  hal::Os& os = hal::linux_os();
  rt::RealTimeExecutor executor(graph, os);
  if (!executor.start()) return 2;
  const auto program = hal::process_start();
  for (const auto& line : executor.shortfalls()) std::printf("not granted: %s\n", line.c_str());
  os.sleep_until(executor.started_at() + 2s);
  const hal::MemoryUse memory = hal::memory_use();
  executor.stop();

  const rt::ThreadStats& s = executor.runner().thread_stats(graph.find_thread("stabilise"));
  std::printf("cycles %llu, overruns %llu, commands %u\n", static_cast<unsigned long long>(s.completions.value()),
              static_cast<unsigned long long>(s.overruns.value()), motors.commands);
  std::printf("start-up %.2f s, memory %llu kB\n", program ? msg::seconds(executor.started_at() - *program) : -1.0,
              static_cast<unsigned long long>(memory.total / 1024));
  return motors.commands > 0 ? 0 : 1;
}
