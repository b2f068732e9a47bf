#pragma once
#include <array>
#include <cstdint>

#include "msg/sensors.hpp"

namespace sinew::hal {

/// Joins two streams of different timing to IMU samples: at each gyroscope sample the specific force is interpolated
/// between the two accelerometer samples around it.
/// Thread:  owner.   RT: yes.
class IioJoin {
 public:
  /// Calls `on_sample(ImuSample)` for all samples that are complete now.
  template <class OnSample>
  void add_accel(msg::Time stamp, const msg::Vec3& v, OnSample&& on_sample) {
    before_ = after_;
    after_ = {stamp, v};
    if (accels_ < 2) ++accels_;
    work(on_sample);
  }
  template <class OnSample>
  void add_gyro(msg::Time stamp, const msg::Vec3& v, OnSample&& on_sample) {
    if (count_ == waiting_.size()) drop();  // the accelerometer is silent, or much slower
    waiting_[count_++] = {stamp, v};
    work(on_sample);
  }
  /// Gyroscope samples for which no two accelerometer samples were found.
  std::uint64_t dropped() const { return dropped_; }

 private:
  struct Stamped {
    msg::Time stamp;
    msg::Vec3 v;
  };
  void drop() {
    remove_first();
    ++dropped_;
  }
  void remove_first() {
    for (std::size_t i = 1; i < count_; ++i) waiting_[i - 1] = waiting_[i];
    --count_;
  }
  template <class OnSample>
  void work(OnSample&& on_sample) {
    while (count_ > 0 && accels_ == 2) {
      const Stamped& g = waiting_[0];
      if (g.stamp > after_.stamp) return;  // more will come
      if (g.stamp < before_.stamp) {
        drop();
        continue;
      }
      const double span = msg::seconds(after_.stamp - before_.stamp);
      const double share = span > 0 ? msg::seconds(g.stamp - before_.stamp) / span : 1;
      const auto mix = [share](double a, double b) { return a + (b - a) * share; };
      msg::ImuSample out;
      out.stamp = g.stamp;
      out.gyro_radps = g.v;
      out.accel_mps2 = {mix(before_.v.x, after_.v.x), mix(before_.v.y, after_.v.y), mix(before_.v.z, after_.v.z)};
      on_sample(out);
      remove_first();
    }
  }

  std::array<Stamped, 32> waiting_{};
  std::size_t count_ = 0;
  Stamped before_{}, after_{};
  int accels_ = 0;
  std::uint64_t dropped_ = 0;
};

}  // namespace sinew::hal
