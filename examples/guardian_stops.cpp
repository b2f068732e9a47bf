// A controller falls silent; the guardian lets its last command live for the lease, then stops the motors by itself.
#include <cstdio>

#include "hal/board.hpp"
#include "rt/exec/discrete_executor.hpp"

using namespace sinew;
using namespace std::chrono_literals;

/// Commands one motor for 100 ms, then nothing any more.
class Pilot final : public rt::Module {
  void declare(rt::Declaration& d) override { d.out("motor", out_); }
  rt::StepStatus step(const rt::Step& step) noexcept override {
    if (step.now >= rt::Time{100'000'000}) return rt::StepStatus::stale;
    auto& command = out_.loan();
    command.stamp = step.now;
    command.count = command.armed = 1;
    command.value[0] = 0.5;
    return rt::StepStatus::ok;
  }
  rt::Out<msg::ActuatorCommand> out_;
};

/// The device: notes when it is stopped for the first time.
class Motor final : public hal::EmptyBoard, public hal::Actuators {
 public:
  explicit Motor(const hal::Clock& clock) : clock_(clock) {}
  hal::Result<hal::Actuators*> actuators(std::string_view) override { return static_cast<hal::Actuators*>(this); }
  hal::Status write(const msg::ActuatorCommand&, hal::Duration) noexcept override {
    ran_ = true;
    return hal::Status();
  }
  hal::Status stop() noexcept override {
    if (ran_ && stopped_at == hal::kNever) stopped_at = clock_.now();
    return {};
  }
  hal::Time stopped_at = hal::kNever;

 private:
  const hal::Clock& clock_;
  bool ran_ = false;
};

int main() {
  rt::ModuleTypes types;
  types.add<Pilot>("Pilot");
  rt::GraphSpec spec;
  spec.modules = {{.name = "pilot", .type = "Pilot", .exec = {rt::ExecModel::Kind::constant, 10us, {}, 1}}};
  spec.threads = {{.name = "loop", .priority = 10, .period = 1ms, .order = {{"pilot"}}}};
  spec.actuators = {{.name = "motor", .command = {"pilot.motor"}, .channels = 1, .max = 1, .lease = 20ms}};
  rt::Graph graph(spec, types);
  hal::ManualClock clock;
  Motor motor(clock);
  hal::FixedGrant grants(hal::Time{200'000'000});
  if (!graph.check({.virtual_time = true}).empty() || !graph.configure(motor)) return 1;
  if (!rt::DiscreteExecutor(graph, clock, grants).run()) return 1;
  std::printf("last command 99.010 ms, motor stopped at %.3f ms\n", msg::seconds(motor.stopped_at) * 1e3);
  return motor.stopped_at > hal::Time{119'000'000} && motor.stopped_at < hal::Time{119'100'000} ? 0 : 1;
}
