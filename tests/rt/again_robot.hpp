#pragma once
// A robot whose modules use everything that a step may use, for the tests of executing it again.
#include <algorithm>
#include <bit>
#include <chrono>
#include <vector>

#include "msg/actuators.hpp"
#include "rt/graph.hpp"
#include "topic_fixture.hpp"

namespace sinew::rt {

using namespace std::chrono_literals;

/// A driver: its hook fills the raw topic from a device of its own and learns whether the device is well.
class Sampler final : public DriverModule {
 public:
  void declare(Declaration& d) override {
    d.raw("raw", raw_, {.burst = 4});
    d.out("out", out_, {.burst = 4});
    d.state(sum_);
  }
  void reset() override { sum_ = 0; }
  void collect(Time now) noexcept override {
    ++polls_;
    ill_ = polls_ % 7 == 0 ? polls_ : 0;
    for (std::uint32_t i = 0; i <= polls_ % 3; ++i) {
      Pair& p = *raw_.loan();
      p.stamp = now;
      p.number = polls_ * 10 + i;
    }
  }
  std::uint32_t device_state() const noexcept override { return ill_; }
  void set_device_state(std::uint32_t state) noexcept override { ill_ = state; }
  StepStatus step(const Step&) noexcept override {
    for (const Pair& p : raw_) {
      Pair& out = out_.loan();
      out.stamp = p.stamp;
      out.number = sum_ += p.number + ill_;
    }
    return StepStatus::ok;
  }

 private:
  Raw<Pair> raw_;
  Out<Pair> out_;
  std::uint32_t polls_ = 0, ill_ = 0, sum_ = 0;
};

/// Reads everything that a step may read, keeps state of every kind.
class Mixed final : public Module {
 public:
  void declare(Declaration& d) override {
    d.in("queue", queue_, {.depth = 4});
    d.in("latest", latest_, {.max_age = 15ms});
    d.out("out", out_);
    d.out("some", some_);
    d.param("gain", memory_.gain, {.min = 0, .max = 10});
    d.param("size", size_, {.min = 1, .max = 100});
    d.state(memory_, ring_);
  }
  hal::Status configure(Setup&) override {
    ring_.resize(static_cast<std::size_t>(size_));
    return {};
  }
  void reset() override {
    memory_ = {.sum = static_cast<std::uint64_t>(1000 * memory_.gain), .gain = memory_.gain};
    std::fill(ring_.begin(), ring_.end(), 0);
  }
  StepStatus step(const Step& step) noexcept override {
    memory_.odd ^= 1;
    for (const Pair& p : queue_) memory_.sum += p.number;
    double& oldest = ring_[step.number % ring_.size()];
    const double delta = static_cast<double>(memory_.sum) - oldest;
    oldest = static_cast<double>(memory_.sum);
    if (latest_.updated()) ++memory_.news;
    if (step.number % 5 == 4) return StepStatus::stale;
    Pair& out = out_.loan();
    out.stamp = step.now;
    out.number = memory_.news + (latest_.fresh(step.now) ? 1000 : 0) + (memory_.odd != 0 ? 100 : 0);
    out.value = {delta * memory_.gain, static_cast<double>(queue_.dropped_total() * 1000 + queue_.dropped()),
                 step.random.uniform(), msg::seconds(step.dt)};
    if (step.number % 3 != 0) return StepStatus::ok;
    Pair& some = some_.loan();
    some.stamp = step.now;
    some.number = memory_.news / 8;
    some.value[0] = std::bit_cast<double>(0xFFF8000000000000 | step.number);  // a NaN of some bits
    return StepStatus::ok;
  }

 private:
  struct Memory {
    std::uint64_t sum = 0;
    double gain = 1;  // a parameter in the middle of the state
    std::uint32_t odd = 0, news = 0;
  };
  InQueue<Pair> queue_;
  In<Pair> latest_;
  Out<Pair> out_, some_;
  Memory memory_;
  std::vector<double> ring_;
  std::int64_t size_ = 7;
};

/// Faults for ever from its 20th step on.
class Shaky final : public Module {
 public:
  void declare(Declaration& d) override {
    d.out("out", out_);
    d.state(steps_);
  }
  void reset() override { steps_ = 0; }
  StepStatus step(const Step&) noexcept override {
    out_.loan().number = ++steps_;
    return steps_ < 20 ? StepStatus::ok : StepStatus::fault;
  }

 private:
  Out<Pair> out_;
  std::uint32_t steps_ = 0;
};

class Commander final : public Module {
 public:
  void declare(Declaration& d) override { d.out("out", out_); }
  StepStatus step(const Step& step) noexcept override {
    if (step.number >= 60 && step.number < 75) return StepStatus::stale;  // longer than the lease
    auto& c = out_.loan();
    c.stamp = step.now;
    c.count = 2;
    c.armed = step.number > 10;
    const bool idle = step.number < 20 || (step.number > 245 && step.number < 320);
    c.value[0] = idle ? 0 : step.random.uniform();
    return StepStatus::ok;
  }

 private:
  Out<msg::ActuatorCommand> out_;
};

/// Has state and does not declare it.
class Forgetful final : public Module {
 public:
  void declare(Declaration& d) override { d.out("out", out_); }
  void reset() override { count_ = 0; }
  StepStatus step(const Step&) noexcept override {
    out_.loan().number = ++count_;
    return StepStatus::ok;
  }

 private:
  Out<Pair> out_;
  std::uint32_t count_ = 0;
};

inline ModuleTypes test_types() {
  ModuleTypes types;
  types.add<Sampler>("Sampler");
  types.add<Mixed>("Mixed");
  types.add<Shaky>("Shaky");
  types.add<Commander>("Commander");
  types.add<Forgetful>("Forgetful");
  return types;
}

inline GraphSpec test_spec() {
  const ExecModel exec{ExecModel::Kind::constant, 10us, {}, 1.0};
  const auto module = [&exec](const char* name, const char* type) {
    ModuleSpec m;
    m.name = name;
    m.type = type;
    m.exec = exec;
    return m;
  };
  GraphSpec spec;
  spec.seed = 42;
  spec.modules = {module("sampler", "Sampler"), module("mixed", "Mixed"), module("shaky", "Shaky"),
                  module("commander", "Commander"), module("forgetful", "Forgetful")};
  spec.modules[1].in = {{"queue", {"sampler.out"}}, {"latest", {"shaky.out"}}};
  const auto thread = [&spec](const char* name, int priority, Duration period, std::vector<const char*> order) {
    ThreadSpec t;
    t.name = name;
    t.priority = priority;
    t.period = period;
    for (const char* m : order) t.order.push_back({m, 0});
    spec.threads.push_back(t);
  };
  thread("fast", 20, 1ms, {"sampler", "commander"});
  thread("slow", 10, 4ms, {"shaky", "mixed", "forgetful"});
  ActuatorSpec& a = spec.actuators.emplace_back();
  a.name = "motors";
  a.command = {"commander.out", 0};
  a.channels = 2;
  a.max = 1;
  a.rate_per_s = 950;
  a.lease = 10ms;
  a.safe = ActuatorSpec::Safe::hold;
  const auto failsafe = [](const char* name, const char* topic, FailsafeSpec::Kind kind, Duration time) {
    FailsafeSpec f;
    f.name = name;
    f.topic = {topic, 0};
    f.kind = kind;
    f.time = time;
    f.stop_after = 30ms;
    return f;
  };
  spec.failsafes = {failsafe("silent", "sampler.out", FailsafeSpec::Kind::silent, 50ms),
                    failsafe("stuck", "mixed.some", FailsafeSpec::Kind::stuck, 20ms),
                    failsafe("value", "mixed.out", FailsafeSpec::Kind::value, 3ms)};
  spec.failsafes[2].field = {"value[2]", 0};  // a random number
  spec.failsafes[2].above = 0.6;
  spec.guardian.arming = GuardianSpec::Arming::manual;
  TopicSpec& t = spec.topics.emplace_back();
  t.name = "operator.wish";
  t.external = ExternalSpec{.type = "Pair", .thread = "slow", .exec = exec};
  spec.chains.push_back({"to_motors", {"sampler.out", 0}, {"mixed.out", 0}, 1s});
  return spec;
}

}  // namespace sinew::rt
