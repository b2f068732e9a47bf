#pragma once
// Small robots for the tests: modules of the test, threads around them, a run in virtual time.
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "rt/exec/discrete_executor.hpp"
#include "topic_fixture.hpp"

namespace sinew::rt {

using namespace std::chrono_literals;

/// A board with actuators only; remembers all their commands.
class FakeActuators final : public hal::Actuators {
 public:
  struct Event {
    Time at;
    bool stopped = false;
    std::array<double, msg::kMaxChannels> value{};
    Duration lease{};
    std::optional<hal::FallBack> fell_back{};  // stopped, but not switched off
  };
  explicit FakeActuators(const hal::Clock& clock) : clock_(clock) { events.reserve(100'000); }
  hal::Status write(const msg::ActuatorCommand& c, Duration lease) noexcept override {
    return note({clock_.now(), false, c.value, lease, {}});
  }
  hal::Status stop() noexcept override { return note({clock_.now(), true, {}, {}, {}}); }
  hal::Status fall_back(hal::FallBack how) noexcept override { return note({clock_.now(), true, {}, {}, how}); }
  std::vector<Event> events;
  bool refuses = false;

 private:
  hal::Status note(const Event& e) noexcept {
    if (events.size() < events.capacity()) events.push_back(e);
    if (refuses) return hal::Error{hal::Errc::io, "fake actuators"};
    return {};
  }
  const hal::Clock& clock_;
};

class FakeBoard final : public hal::Board {
 public:
  hal::Result<hal::Device*> open_sensor(hal::SensorKind, std::string_view) override { return none(); }
  hal::Result<hal::Camera*> camera(std::string_view) override { return none(); }
  hal::Result<hal::Radio*> radio(std::string_view) override { return none(); }
  hal::Result<hal::Actuators*> actuators(std::string_view name) override {
    for (auto& [n, device] : groups)
      if (n == name) return device.get();
    return hal::Error{hal::Errc::not_found, "fake board"};
  }
  FakeActuators& add(const std::string& name, const hal::Clock& clock) {
    groups.emplace_back(name, std::make_unique<FakeActuators>(clock));
    return *groups.back().second;
  }
  std::vector<std::pair<std::string, std::unique_ptr<FakeActuators>>> groups;

 private:
  static hal::Error none() { return {hal::Errc::not_found, "fake board"}; }
};

/// Grants up to the next thing to do, does it, goes on.
class ScriptedGrants final : public hal::GrantSource {
 public:
  void at(Time t, std::function<void()> action) { script_.push_back({t, std::move(action)}); }
  hal::Result<Time> next_grant(Time done_to) override {
    Time next = end;
    for (auto& [t, action] : script_) {
      if (!action) continue;
      if (t <= done_to)
        std::exchange(action, nullptr)();
      else
        next = std::min(next, t);
    }
    if (done_to >= end) return hal::Error{hal::Errc::closed, "end of the test"};
    return next;
  }
  Time end{};

 private:
  std::vector<std::pair<Time, std::function<void()>>> script_;
};

class Records final : public RunObserver {
 public:
  Records() { all.reserve(200'000); }
  void completed(const StepRecord& r) noexcept override {
    if (all.size() < all.capacity()) all.push_back(r);
  }
  std::vector<StepRecord> of(std::uint32_t module) const {
    std::vector<StepRecord> some;
    for (const auto& r : all)
      if (r.module == module) some.push_back(r);
    return some;
  }
  std::vector<StepRecord> all;
};

/// One robot: add modules and threads, then run().
class Robot {
 public:
  using Bindings = std::vector<std::pair<std::string, std::string>>;  // port, topic

  template <class M, class... A>
  M& add(const std::string& name, const Bindings& in = {}, A&&... args) {
    auto module = std::make_unique<M>(std::forward<A>(args)...);
    M& made = *module;
    types.add("test::" + name,
              [held = std::make_shared<std::unique_ptr<Module>>(std::move(module))] { return std::move(*held); });
    ModuleSpec m;
    m.name = name;
    m.type = "test::" + name;
    m.exec = {ExecModel::Kind::constant, 10us, {}, 1.0};
    for (const auto& [port, topic] : in) m.in[port] = {topic, 0};
    spec.modules.push_back(std::move(m));
    return made;
  }
  ModuleSpec& module(std::string_view name) {
    return *std::find_if(spec.modules.begin(), spec.modules.end(), [&](const auto& m) { return m.name == name; });
  }
  ThreadSpec& periodic(const std::string& name, int priority, Duration period, const std::vector<std::string>& order) {
    ThreadSpec& t = thread(name, priority, order);
    t.period = period;
    return t;
  }
  ThreadSpec& on_topics(const std::string& name, int priority, const std::vector<std::string>& topics,
                        const std::vector<std::string>& order, Duration timeout = {}) {
    ThreadSpec& t = thread(name, priority, order);
    t.trigger = ThreadSpec::Trigger::topics;
    for (const auto& topic : topics) t.topics.push_back({topic, 0});
    t.timeout = timeout;
    return t;
  }
  /// The group "motors" of the module "commander": two channels, -1 to 1.
  ActuatorSpec& two_motors(Duration lease) {
    ActuatorSpec& a = spec.actuators.emplace_back();
    a.name = "motors";
    a.command = {"commander.out", 0};
    a.channels = 2;
    a.min = -1;
    a.max = 1;
    a.lease = lease;
    return a;
  }
  ThreadSpec& on_device(const std::string& name, int priority, const std::vector<std::string>& order,
                        Duration timeout = {}) {
    ThreadSpec& t = thread(name, priority, order);
    t.trigger = ThreadSpec::Trigger::device;
    t.device_module = order.front();
    t.timeout = timeout;
    return t;
  }

  /// Checks and configures; the test fails when something is wrong.
  Graph& build() {
    if (graph_) return *graph_;
    graph_ = std::make_unique<Graph>(spec, types);
    const auto problems = graph_->check({.virtual_time = virtual_time});
    for (const Problem& p : problems) ADD_FAILURE() << to_string(p, "test");
    if (!problems.empty()) std::abort();  // nothing could be run
    const auto configured = graph_->configure(board, configure_options);
    if (!configured) ADD_FAILURE() << configured.error().where;
    return *graph_;
  }
  DiscreteReport run(Duration duration) {
    build();
    grants.end = Time{duration.count()};
    DiscreteOptions options;
    options.hash_topics = true;
    options.fault_limit = fault_limit;
    options.observer = &records;
    executor_ = std::make_unique<DiscreteExecutor>(*graph_, clock, grants, options);
    const auto report = executor_->run();
    if (!report) ADD_FAILURE() << report.error().where;
    return report ? *report : DiscreteReport{};
  }

  Graph& graph() { return *graph_; }
  Runner& runner() { return executor_->runner(); }
  const ModuleStats& stats(std::string_view module) { return runner().module_stats(graph_->find_module(module)); }
  const ThreadStats& thread_stats(std::string_view thread) {
    return runner().thread_stats(graph_->find_thread(thread));
  }
  std::uint64_t hash(std::string_view topic) { return runner().topic_hash(graph_->find_topic(topic)); }
  std::vector<StepRecord> steps(std::string_view module) const { return records.of(graph_->find_module(module)); }

  GraphSpec spec;
  ModuleTypes types;
  ConfigureOptions configure_options{.first_sequence = kNearWrap};
  std::uint32_t fault_limit = 10;
  bool virtual_time = true;
  hal::ManualClock clock;
  FakeBoard board;
  ScriptedGrants grants;
  Records records;

 private:
  ThreadSpec& thread(const std::string& name, int priority, const std::vector<std::string>& order) {
    spec.threads.emplace_back();
    ThreadSpec& t = spec.threads.back();
    t.name = name;
    t.priority = priority;
    for (const auto& m : order) t.order.push_back({m, 0});
    return t;
  }
  std::unique_ptr<Graph> graph_;
  std::unique_ptr<DiscreteExecutor> executor_;
};

}  // namespace sinew::rt
