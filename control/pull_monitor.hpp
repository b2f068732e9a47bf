#pragma once
#include <array>

#include "math/linear.hpp"
#include "msg/time.hpp"

namespace sinew::control {

/// Finds GNSS positions that drift away from the receiver's own velocities (Doppler): multipath, or somebody who pulls.
/// A pull of position *and* velocity together cannot be seen without another source of position.
/// Shape:   16 anchors 2 s apart: the drift over up to half a minute.
/// Thread:  owner.   RT: yes.
class PullMonitor {
 public:
  void reset() { *this = PullMonitor{}; }
  /// A position and velocity of one instant, with one sigma each. True while the drift is more than the accuracies
  /// explain: 4 sigma of the two positions and 0.1 m/s, or what the velocities' accuracy adds, over the time between.
  bool add(msg::Time stamp, const math::Vec3& p_m, const math::Vec3& v_mps, double p_sigma_m, double v_sigma_mps) {
    const double dt_s = msg::seconds(stamp - last_);
    if (count_ == 0 || dt_s <= 0 || dt_s > 2) {
      *this = PullMonitor{};
    } else {
      travelled_ += (v_before_ + v_mps) * (0.5 * dt_s);
    }
    last_ = stamp;
    v_before_ = v_mps;
    bool drifts = false, agrees = count_ > 0;
    for (std::uint32_t i = 0; i < count_; ++i) {
      const Anchor& a = anchors_[i];
      const math::Vec3 d = (p_m - a.p_m) - (travelled_ - a.travelled_m);
      const double t = msg::seconds(stamp - a.stamp);
      const double allowed =
          4 * math::sqrt(p_sigma_m * p_sigma_m + a.sigma_m * a.sigma_m) + (0.1 + 0.2 * v_sigma_mps) * t;
      const double off = math::hypot(d.x, d.y);
      drifts = drifts || off > allowed;
      agrees = agrees && off < 0.5 * allowed;
    }
    if (drifts) pulled_ = 1;
    if (agrees && count_ == anchors_.size()) pulled_ = 0;
    if (count_ == 0 || msg::seconds(stamp - anchors_[count_ - 1].stamp) >= 2) {
      if (count_ == anchors_.size()) {
        for (std::size_t i = 1; i < anchors_.size(); ++i) anchors_[i - 1] = anchors_[i];
        --count_;
      }
      anchors_[count_++] = {stamp, p_m, travelled_, p_sigma_m};
    }
    return pulled_ != 0;
  }
  bool pulled() const { return pulled_ != 0; }

 private:
  struct Anchor {
    msg::Time stamp;
    math::Vec3 p_m, travelled_m;
    double sigma_m = 0;
  };
  std::array<Anchor, 16> anchors_{};
  math::Vec3 travelled_, v_before_;
  msg::Time last_;
  std::uint32_t count_ = 0, pulled_ = 0;
};

}  // namespace sinew::control
