#pragma once
#include "control/place.hpp"
#include "msg/flight.hpp"
#include "msg/place.hpp"
#include "rt/module.hpp"

namespace sinew::control {

/// A robot in the frame of its team, by the place where it started. Says its pose and the landing pad that it sees, for
/// mates; brings a mate's pad into its own frame.
///
/// Inputs:  state: the own estimate. mate_pad: the pad as a mate says it, in the team's frame.
/// Outputs: pose: TeamPose. pad: the own sighting in the team's frame, while it is known, as unsure as the own place
/// and
///          the sighting together. told_pad: the mate's, in the frame of NavState; its covariance has what is uncertain
///          about the own pose in it.
/// Frames:  team: z up, origin and axes as all robots of the team measured their starts.
/// Thread:  executor, 5 to 200 Hz.   RT: yes.
/// Errors:  stale without a fresh state.
class TeamLocator final : public rt::Module {
 public:
  void declare(rt::Declaration& d) override;
  rt::StepStatus step(const rt::Step& step) noexcept override;

 private:
  UncertainPose start() const;

  rt::In<msg::NavState> state_;
  rt::In<msg::PlaceEstimate> mate_pad_;
  rt::Out<msg::TeamPose> pose_;
  rt::Out<msg::PlaceEstimate> pad_, told_pad_;
  double start_x_m_ = 0, start_y_m_ = 0, start_yaw_deg_ = 0;
  double start_std_m_ = 0.02, start_std_deg_ = 1;
  double pad_std_m_ = 0.1;
};

}  // namespace sinew::control
