#include "motion/servo_lead.hpp"

#include <algorithm>

namespace sinew::motion {
namespace {
constexpr double kRigid_nm = 1e9;       // a joint whose servo is not known
constexpr double kPlayTorque_nm = 0.3;  // from this torque on a gear lies fully on one side of its play
}  // namespace

void ServoLead::step(const ServoLeadParams& params, const std::array<LegLoad, 2>& loads, double dt_s,
                     std::span<double> angles_rad) {
  pose_.set(angles_rad);
  for (const Side side : kSides) {
    const LegLoad& load = loads[index(side)];
    for (const std::size_t link : figure_->leg(side).leg.links()) {
      const std::size_t joint = link - 1;
      const double wanted = angles_rad[joint];
      const double rate = begun_ && dt_s > 0 ? (wanted - before_[joint]) / dt_s : 0;
      before_[joint] = wanted;
      const math::Vec3 axis = pose_.link(link).q.rotate(figure_->body().links[link].axis);
      const double torque_nm = -dot(axis, cross(load.at_m - pose_.link(link).p_m, load.push_n));
      const kinematics::Link& servo = figure_->body().links[link];
      const double stall_nm =
          servo.servo < figure_->body().servos.size() ? figure_->body().servos[servo.servo].stall_nm : kRigid_nm;
      angles_rad[joint] = wanted + params.lead_s * rate +
                          params.weight_ahead * torque_nm / (params.gain_per_rad * stall_nm) +
                          0.5 * params.play_rad * std::clamp(torque_nm / kPlayTorque_nm, -1.0, 1.0);
    }
  }
  begun_ = true;
}

}  // namespace sinew::motion
