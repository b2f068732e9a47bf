#pragma once
#include "robots/quad/landing_policy.hpp"

namespace sinew::control {

/// Flies a landing policy: when it decides, and what it does where the policy is not asked.
/// Thread:  owner.   RT: yes.
class LandingPilot {
 public:
  struct Params {
    std::int64_t decide_every = 6;  // pictures
    double blind_sink_mps = 0.25;   // below LandingViewParams::blind_below_m
  };
  LandingView view;
  Params params;

  void reset();
  /// One picture. True: the policy decides now; call act() with what it wants. Before that, blind() and known() of the
  /// view say whether its wish counts.
  bool see(const msg::PadSighting& sighting, const msg::NavState& nav);
  /// What is flown until the next decision. Below blind_below_m the sinking is blind_sink_mps and the way aside still
  /// the policy's, on the offset that is carried on by the inertial velocity; a pad that is not known is waited for,
  /// hovering.
  void act(const LandingWish& wish);
  /// World axes.
  math::Vec3 velocity_mps() const { return {velocity_mps_[0], velocity_mps_[1], velocity_mps_[2]}; }

 private:
  std::array<double, 3> velocity_mps_{};
  std::int64_t pictures_ = 0;
};

}  // namespace sinew::control
