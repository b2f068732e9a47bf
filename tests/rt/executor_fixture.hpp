#pragma once
// Graphs of small modules, with ports, parameters and steps that a test defines in place, and a board made of arrays.
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "msg/actuators.hpp"
#include "msg/sensors.hpp"
#include "rt/exec/discrete_executor.hpp"
#include "topic_fixture.hpp"

namespace sinew::rt {

using namespace std::chrono_literals;

/// A module with one port of every kind and a step that the test defines. Only the ports in `declares` are declared.
class Probe : public DriverModule {
 public:
  std::function<void(Declaration&, Probe&)> declares;
  std::function<StepStatus(Probe&, const Step&)> steps = [](Probe&, const Step&) { return StepStatus::ok; };
  std::function<void(Probe&, Time)> collects, emits;
  In<Pair> in, other, back;
  InQueue<Pair> queue;
  Raw<Pair> raw;
  Out<Pair> out, second;
  In<msg::ActuatorCommand> command_in;
  Out<msg::ActuatorCommand> command;
  double gain = 1.0;
  int resets = 0;
  hal::Device* behind = nullptr;

  void declare(Declaration& d) override {
    if (declares) declares(d, *this);
  }
  void reset() override { ++resets; }
  StepStatus step(const Step& step) noexcept override { return steps(*this, step); }
  void collect(Time now) noexcept override {
    if (collects) collects(*this, now);
  }
  void emit(Time now) noexcept override {
    if (emits) emits(*this, now);
  }
  hal::Device* device() override { return behind; }
};

/// Actuators that log their commands.
class LoggedActuators final : public hal::Actuators {
 public:
  struct Entry {
    Time at;
    bool stop;
    double value;
    Duration lease;
    bool operator==(const Entry&) const = default;
  };
  explicit LoggedActuators(const hal::Clock& clock) : clock_(clock) { log.reserve(100'000); }
  hal::Status write(const msg::ActuatorCommand& c, Duration lease) noexcept override {
    log.push_back({clock_.now(), false, c.value[0], lease});
    return refuse ? hal::Status(hal::Error{hal::Errc::io, "test"}) : hal::Status();
  }
  hal::Status stop() noexcept override {
    log.push_back({clock_.now(), true, 0, Duration{}});
    return refuse ? hal::Status(hal::Error{hal::Errc::io, "test"}) : hal::Status();
  }
  std::vector<Entry> log;
  bool refuse = false;

 private:
  const hal::Clock& clock_;
};

/// An IMU whose samples are due at instants listed before.
class ListedImu final : public hal::Imu {
 public:
  explicit ListedImu(const hal::Clock& clock) : clock_(clock) {}
  std::vector<Time> due;
  hal::Result<bool> read(msg::ImuSample& out) noexcept override {
    if (next_ == due.size() || due[next_] > clock_.now()) return false;
    out.stamp = due[next_++];
    return true;
  }
  Time ready_at() const noexcept override { return next_ < due.size() ? due[next_] : hal::kNever; }
  void set_wake(hal::Wake*) noexcept override {}

 private:
  const hal::Clock& clock_;
  std::size_t next_ = 0;
};

class ListedBoard final : public hal::Board {
 public:
  explicit ListedBoard(const hal::Clock& clock) : imu_device(clock), motors(clock) {}
  hal::Result<hal::Device*> open_sensor(hal::SensorKind kind, std::string_view) override {
    if (kind != hal::SensorKind::imu) return none();
    return &imu_device;
  }
  hal::Result<hal::Camera*> camera(std::string_view) override { return none(); }
  hal::Result<hal::Radio*> radio(std::string_view) override { return none(); }
  hal::Result<hal::Actuators*> actuators(std::string_view name) override {
    if (name != "motors") return none();
    return &motors;
  }
  ListedImu imu_device;
  LoggedActuators motors;

 private:
  static hal::Error none() { return {hal::Errc::not_found, "no such device"}; }
};

/// A graph in the making: probes by name, threads, then run().
class GraphRig {
 public:
  GraphSpec spec;
  ModuleTypes types;
  std::map<std::string, Probe*> probes;  // after build()
  hal::ManualClock clock;
  ListedBoard board{clock};
  std::unique_ptr<Graph> graph;
  std::unique_ptr<DiscreteExecutor> executor;
  DiscreteOptions options;
  ConfigureOptions configure_options{.first_sequence = kNearWrap};

  using Declares = std::function<void(Declaration&, Probe&)>;
  using Steps = std::function<StepStatus(Probe&, const Step&)>;
  using Bindings = std::map<std::string, std::string>;

  ModuleSpec& module(const std::string& name, Declares declares, Bindings in = {}, Steps steps = {},
                     Duration exec = 10us) {
    types.add("test::" + name, [this, name, declares, steps] {
      auto probe = std::make_unique<Probe>();
      probe->declares = declares;
      if (steps) probe->steps = steps;
      probes[name] = probe.get();
      return probe;
    });
    ModuleSpec m;
    m.name = name;
    m.type = "test::" + name;
    m.line = static_cast<int>(100 + spec.modules.size());
    m.exec = {ExecModel::Kind::constant, exec, {}, 1.0};
    for (const auto& [port, topic] : in) m.in[port] = {topic, 0};
    spec.modules.push_back(std::move(m));
    return spec.modules.back();
  }
  ThreadSpec& thread(const std::string& name, int priority, std::vector<std::string> order) {
    ThreadSpec t;
    t.name = name;
    t.priority = priority;
    t.line = static_cast<int>(10 + spec.threads.size());
    for (std::string& m : order) t.order.push_back({std::move(m), 0});
    spec.threads.push_back(std::move(t));
    return spec.threads.back();
  }
  ThreadSpec& periodic(const std::string& name, int priority, Duration period, std::vector<std::string> order) {
    ThreadSpec& t = thread(name, priority, std::move(order));
    t.period = period;
    return t;
  }
  ThreadSpec& on_topic(const std::string& name, int priority, const std::string& topic,
                       std::vector<std::string> order) {
    ThreadSpec& t = thread(name, priority, std::move(order));
    t.trigger = ThreadSpec::Trigger::topics;
    t.topics.push_back({topic, 0});
    return t;
  }
  ActuatorSpec& motors(const std::string& command) {
    ActuatorSpec a;
    a.name = "motors";
    a.command.value = command;
    a.channels = 2;
    a.max = 10;
    a.lease = 20ms;
    a.line = 50;
    spec.actuators.push_back(std::move(a));
    return spec.actuators.back();
  }

  std::vector<std::string> problems(const CheckOptions& check = {.virtual_time = true}) {
    graph = std::make_unique<Graph>(spec, types);
    std::vector<std::string> lines;
    for (const Problem& p : graph->check(check)) lines.push_back(to_string(p, "r"));
    return lines;
  }
  /// Checks and configures; returns the problems in words.
  std::string build() {
    for (const std::string& p : problems()) return p;
    const auto configured = graph->configure(board, configure_options);
    for (const Problem& p : graph->configure_problems()) return to_string(p, "r");
    return configured ? "" : configured.error().where;
  }
  /// Runs for this long, or on.
  DiscreteReport run(Duration duration) {
    grants_ = std::make_unique<hal::FixedGrant>(Time{} + duration);
    options.duration = duration;
    executor = std::make_unique<DiscreteExecutor>(*graph, clock, *grants_, options);
    return *executor->run();
  }
  Runner& runner() { return executor->runner(); }
  std::uint32_t topic(std::string_view name) const { return graph->find_topic(name); }

 private:
  std::unique_ptr<hal::GrantSource> grants_;
};

}  // namespace sinew::rt
