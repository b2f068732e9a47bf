#pragma once
#include <algorithm>
#include <deque>

#include "hal/result.hpp"
#include "msg/joints.hpp"
#include "msg/referee.hpp"
#include "msg/sensors.hpp"
#include "sim_hil/worlds/fault.hpp"

namespace sinew::plant {

// scramble(): values without sense. shift(): values that are only not true.
void scramble(msg::ImuSample& s, math::Random& random);
void scramble(msg::RangeSample& s, math::Random& random);
void scramble(msg::BaroSample& s, math::Random& random);
void scramble(msg::BatterySample& s, math::Random& random);
void scramble(msg::SolePressure& s, math::Random& random);
void scramble(msg::JointState& s, math::Random& random);  // modes and faults stay: they are not numbers
void shift(msg::ImuSample& s, double radps);
void shift(msg::RangeSample& s, double m);
void shift(msg::BaroSample& s, double pa);
void shift(msg::BatterySample& s, double v);
void shift(msg::SolePressure& s, double n);
void shift(msg::JointState& s, double rad);

// A referee's words come whole or not at all: why_not() allows neither fault.
inline void scramble(msg::RefereeState&, math::Random&) {}
inline void shift(msg::RefereeState&, double) {}

/// Stands between a sensor and the wire. It never changes stamps. Ready never decreases, so a sample behind a delayed
/// one waits for it, as in a queue. Without faults of its device it passes everything on at once.
/// Thread:  owner.
template <class M>
class SensorFaults {
 public:
  SensorFaults(FaultLog& log, FaultDevice device, std::optional<FaultDevice> bus = std::nullopt)
      : faults_(log, device, bus) {}

  /// One sample from the sensor; `send(sample, ready)` gets the samples that go out at once.
  template <class Send>
  hal::Status offer(const M& measured, hal::Time ready, Send&& send) {
    if (!faults_.any()) return send(measured, ready);
    const FaultEffect effect = faults_.next(measured.stamp);
    M s = measured;
    if (effect.stuck && any_) {
      s = last_;
      s.stamp = measured.stamp;
    } else {
      last_ = s;
      any_ = true;
    }
    if (effect.wrong) shift(s, *effect.wrong);
    if (effect.garbage) scramble(s, faults_.random());
    if (effect.lost) return {};
    last_ready_ = ready = std::max(ready + effect.delay, last_ready_);
    for (int copies = effect.duplicated ? 2 : 1; copies > 0; --copies) {
      if (effect.delay.count() > 0 || !held_.empty())
        held_.push_back({s, ready});
      else if (auto sent = send(s, ready); !sent)
        return sent;
    }
    return {};
  }
  /// Sends the samples that are ready by then. Once before each exchange.
  template <class Send>
  hal::Status release(hal::Time until, Send&& send) {
    for (; !held_.empty() && held_.front().ready <= until; held_.pop_front())
      if (auto sent = send(held_.front().sample, held_.front().ready); !sent) return sent;
    return {};
  }

 private:
  struct Held {
    M sample;
    hal::Time ready;
  };
  DeviceFaults faults_;
  std::deque<Held> held_;
  M last_{};
  bool any_ = false;
  hal::Time last_ready_{0};
};

}  // namespace sinew::plant
