#include "robots/air_robot/text_pose.hpp"

#include "math/linear.hpp"

namespace sinew::air_robot {

void TextPose::declare(rt::Declaration& d) {
  d.in("values", values_);
  d.out("state", state_);
  const auto index = [&](const char* name, std::int64_t& value, const char* doc) {
    d.param(name, value, {.min = -1, .max = static_cast<double>(msg::kMaxTextValues) - 1, .doc = doc});
  };
  index("height", height_, "number of the message with the height above the ground, m");
  index("x", x_, "position, m");
  index("y", y_, "position, m");
  index("roll", roll_, "rad");
  index("pitch", pitch_, "rad");
  index("yaw", yaw_, "rad, to the left");
  index("vx", vx_, "velocity in the axes that the robot gives it in, m/s");
  index("vy", vy_, "velocity, m/s");
  index("vz", vz_, "velocity, m/s");
  index("roll_rate", roll_rate_, "of these angles, rad/s");
  index("pitch_rate", pitch_rate_, "rad/s");
  index("yaw_rate", yaw_rate_, "rad/s, to the left");
  d.param("max_age_s", max_age_s_, {.unit = "s", .min = 0.01, .max = 60, .doc = "older values are none"});
}

double TextPose::value(const msg::TextValues& values, std::int64_t index, rt::Time now, bool& fresh) const {
  const auto i = static_cast<std::size_t>(index);
  fresh = index >= 0 && i < values.count && i < msg::kMaxTextValues && values.measured[i].ns != 0 &&
          msg::seconds(now - values.measured[i]) <= max_age_s_;
  return fresh ? values.value[i] : 0;
}

rt::StepStatus TextPose::step(const rt::Step& step) noexcept {
  const msg::TextValues* values = values_.get();
  if (!values) return rt::StepStatus::stale;
  bool fresh = false, other = false;
  const double height_m = value(*values, height_, step.now, fresh);
  if (!fresh) return rt::StepStatus::stale;
  bool known = true;  // each of a group that the robot tells is fresh
  const auto number = [&](std::int64_t index) {
    const double v = value(*values, index, step.now, other);
    known = known && (other || index < 0);
    return v;
  };
  msg::NavState& out = state_.loan();
  out.stamp = values->measured[static_cast<std::size_t>(yaw_rate_ >= 0 && yaw_ >= 0 ? yaw_ : height_)];
  out.height_m = height_m;
  out.height_valid = 1;
  const double roll_rad = number(roll_), pitch_rad = number(pitch_), yaw_rad = number(yaw_);
  out.q_world_base = math::Quat::from_yaw_pitch_roll({yaw_rad, pitch_rad, roll_rad}).to<msg::Quat>();
  out.attitude_valid = known && yaw_ >= 0 ? 1 : 0;
  // Rates of the angles, as rates about the base's axes.
  const double roll_radps = number(roll_rate_), pitch_radps = number(pitch_rate_), yaw_radps = number(yaw_rate_);
  const math::SinCos r = math::sincos(roll_rad), p = math::sincos(pitch_rad);
  out.gyro_radps = {roll_radps - yaw_radps * p.sin, pitch_radps * r.cos + yaw_radps * r.sin * p.cos,
                    yaw_radps * r.cos * p.cos - pitch_radps * r.sin};
  out.v_world_mps = {number(vx_), number(vy_), number(vz_)};
  known = true;
  const double x_m = number(x_), y_m = number(y_);
  out.p_world_m = {x_m, y_m, height_m};
  out.position_valid = known && x_ >= 0 && y_ >= 0 ? 1 : 0;
  return rt::StepStatus::ok;
}

}  // namespace sinew::air_robot
