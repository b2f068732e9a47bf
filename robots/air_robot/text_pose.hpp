#pragma once
#include "msg/flight.hpp"
#include "msg/text_values.hpp"
#include "rt/module.hpp"

namespace sinew::air_robot {

/// The values of a text robot as the state that controllers read: position and attitude as the robot itself gives them
/// (a simulator's ground truth, a drone's own estimate). A parameter is the number of the [[device.NAME.message]], from
/// 0; -1: the robot does not tell it, and it stays 0. The state's stamp is that of the height; with rates, which carry
/// the attitude on from its own instant, that of the yaw.
/// Frames:  as the messages' scales make them: world z up; roll, pitch, yaw about x forward, y left, z up.
/// Thread:  executor.   RT: yes.
/// Errors:  stale without a fresh height: nothing is published. An attitude (a position) of which a told value is old
/// is
///          marked as not valid.
class TextPose final : public rt::Module {
 public:
  void declare(rt::Declaration& d) override;
  rt::StepStatus step(const rt::Step& step) noexcept override;

 private:
  /// The value, if it came within the last max_age of the port; else 0.
  double value(const msg::TextValues& values, std::int64_t index, rt::Time now, bool& fresh) const;

  rt::In<msg::TextValues> values_;
  rt::Out<msg::NavState> state_;
  std::int64_t height_ = 0, x_ = -1, y_ = -1, roll_ = -1, pitch_ = -1, yaw_ = -1, vx_ = -1, vy_ = -1, vz_ = -1;
  std::int64_t roll_rate_ = -1, pitch_rate_ = -1, yaw_rate_ = -1;
  double max_age_s_ = 1;
};

}  // namespace sinew::air_robot
