#pragma once
#include <array>

#include "math/linear.hpp"
#include "msg/time.hpp"

namespace sinew::control {

/// Which of up to three IMUs is believed. Each has an estimator of its own, which all get the same other sensors.
/// Three vote: one that differs from the middle of the three for a tenth of a second is out until it has agreed for two
/// seconds. Two cannot vote: the estimator whose forecasts fit the other sensors better is taken, once it has been
/// better by half for a second. A silent IMU is out at once. Thread:  owner.   RT: yes.
class ImuSelector {
 public:
  static constexpr std::uint32_t kMost = 3;
  struct Params {
    double silent_s = 0.02;                       // without a usable sample
    double gyro_radps = 0.2, accel_mps2 = 2.0;    // from the middle of three, low-passed
    double out_after_s = 0.1, back_after_s = 2;   // of a vote
    double better_share = 0.5, better_for_s = 1;  // of the other's test ratio
  };
  Params params;

  void reset() {
    const Params keep = params;
    *this = ImuSelector{};
    params = keep;
  }
  /// A usable sample of IMU `i`. Readings of different places and times: the vote looks at low-passed values only.
  void add_sample(std::uint32_t i, msg::Time now, const math::Vec3& gyro_radps, const math::Vec3& accel_mps2);
  /// How well the forecasts of estimator `i` fit: mean of the test ratios of its newest measurements.
  void add_fit(std::uint32_t i, double test_ratio, double dt_s);
  /// Decides, once a step. `count` IMUs are bound.
  std::uint32_t choose(std::uint32_t count, msg::Time now);
  std::uint32_t chosen() const { return chosen_; }
  bool voted_out(std::uint32_t i) const { return lanes_[i].out != 0; }

 private:
  struct Lane {
    msg::Time last, apart_since, close_since;
    math::Vec3 gyro, accel;  // low-passed
    double fit = 0;
    std::uint32_t seen = 0, out = 0;
  };
  bool usable(std::uint32_t i, msg::Time now) const;
  void vote(msg::Time now);
  std::array<Lane, kMost> lanes_{};
  msg::Time better_since_;
  std::uint32_t chosen_ = 0, rival_ = 0;
};

}  // namespace sinew::control
