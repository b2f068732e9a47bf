#pragma once
// The modules of the matrix's robot that the project does not have.
#include <cmath>

#include "drivers/sources/camera_source.hpp"
#include "drivers/sources/sensor_source.hpp"
#include "robot.hpp"

namespace sinew::test {

/// The largest age of a sample of each kind on arrival: the delay of its filter or receiver, and of polling.
template <class M>
Time oldest(const M& sample) {
  return sample.stamp;
}
inline Time oldest(const msg::JointState& sample) {
  Time t = hal::kNever;  // samples of a ready joint must be fresh
  for (std::size_t i = 0; i < sample.count; ++i)
    if (sample.ready >> i & 1) t = std::min(t, sample.measured[i]);
  return t == hal::kNever ? sample.stamp + 1h : t;
}

/// The state of joints comes each tick, with the instants at which each was measured.
template <class M>
inline constexpr bool kEachIsNew = true;
template <>
inline constexpr bool kEachIsNew<msg::JointState> = false;

template <class M>
void note(Seen&, const M&) {}
inline void note(Seen& seen, const msg::JointState& sample) { seen.joints = sample; }

/// Reads every sample of the source.
template <class M>
class Watch final : public rt::Module {
 public:
  explicit Watch(Seen& seen) : seen_(seen) {}
  void declare(rt::Declaration& d) override { d.in("in", in_, {.depth = sizeof(M) > 100'000 ? 4u : 32u}); }
  rt::StepStatus step(const rt::Step& step) noexcept override {
    for (const M& sample : in_) {
      ++seen_.samples;
      if (kEachIsNew<M> && sample.stamp == last_) ++seen_.same_stamp;
      if (step.now - oldest(sample) > 300ms) ++seen_.old;
      last_ = sample.stamp;
      seen_.last = step.now;
      if (seen_.first.ns == 0) seen_.first = step.now;
      note(seen_, sample);
    }
    return rt::StepStatus::ok;
  }

 private:
  rt::InQueue<M> in_;
  Seen& seen_;
  Time last_{};
};

/// Moves all channels slowly up and down while it is permitted; idle before, and when the permission ends.
class Controller final : public rt::Module {
 public:
  explicit Controller(double& setpoint) : setpoint_(setpoint) {}
  void declare(rt::Declaration& d) override {
    d.in("safety", safety_, {.optional = true, .supervises = true});
    d.out("out", out_);
  }
  rt::StepStatus step(const rt::Step& step) noexcept override {
    const msg::SafetyState* s = safety_.get();
    const bool goes = s && s->permitted;
    if (!goes) begun_ = step.now;
    setpoint_ = goes ? 0.9 * std::sin(2 * msg::seconds(step.now - begun_)) : 0;
    msg::ActuatorCommand& c = out_.loan();
    c.stamp = step.now;
    c.count = 2;
    c.armed = 1;
    c.value[0] = c.value[1] = setpoint_;
    return rt::StepStatus::ok;
  }

 private:
  rt::In<msg::SafetyState> safety_;
  rt::Out<msg::ActuatorCommand> out_;
  double& setpoint_;
  Time begun_{};
};

}  // namespace sinew::test
