#include "robots/air_robot/steer.hpp"

namespace sinew::air_robot {

using namespace std::chrono_literals;

void Steer::declare(rt::Declaration& d) {
  static constexpr const char* kNames[msg::kMaxChannels][kParts] = {
      {"forward_1", "left_1", "up_1", "turn_1"}, {"forward_2", "left_2", "up_2", "turn_2"},
      {"forward_3", "left_3", "up_3", "turn_3"}, {"forward_4", "left_4", "up_4", "turn_4"},
      {"forward_5", "left_5", "up_5", "turn_5"}, {"forward_6", "left_6", "up_6", "turn_6"},
      {"forward_7", "left_7", "up_7", "turn_7"}, {"forward_8", "left_8", "up_8", "turn_8"}};
  d.in("velocity", velocity_, {.max_age = 500ms});
  d.in("joints", joints_, {.max_age = 500ms, .optional = true});
  d.out("drives", drives_);
  d.param("channels", channels_,
          {.min = 1, .max = static_cast<double>(msg::kMaxChannels), .doc = "drives of the robot"});
  d.param("joint_count", joint_count_,
          {.min = 0, .max = static_cast<double>(msg::kMaxChannels) - 1, .doc = "channels behind them: the joints'"});
  for (std::size_t c = 0; c < msg::kMaxChannels; ++c)
    for (std::size_t p = 0; p < kParts; ++p)
      d.param(kNames[c][p], gain_[c][p],
              {.min = -1e6, .max = 1e6, .doc = p == 3 ? "setpoint for each rad/s" : "setpoint for each m/s"});
}

rt::StepStatus Steer::step(const rt::Step& step) noexcept {
  const msg::VelocityCommand* velocity = velocity_.fresh(step.now);
  const msg::ActuatorCommand* joints = joints_.fresh(step.now);
  const auto channels = static_cast<std::size_t>(channels_), count = static_cast<std::size_t>(joint_count_);
  if (!velocity || (count > 0 && !joints)) return rt::StepStatus::stale;
  if (channels + count > msg::kMaxChannels || (count > 0 && joints->count != count)) return rt::StepStatus::fault;
  const std::array<double, kParts> parts{velocity->linear_mps.x, velocity->linear_mps.y, velocity->linear_mps.z,
                                         velocity->angular_radps.z};
  msg::ActuatorCommand& out = drives_.loan();
  out.stamp = velocity->stamp;
  out.count = static_cast<std::uint32_t>(channels + count);
  out.armed = 1;
  for (std::size_t c = 0; c < channels; ++c)
    for (std::size_t p = 0; p < kParts; ++p) out.value[c] += gain_[c][p] * parts[p];
  for (std::size_t i = 0; i < count; ++i) out.value[channels + i] = joints->value[i];
  if (count > 0 && joints->armed == 0) out.armed = 0;
  return rt::StepStatus::ok;
}

}  // namespace sinew::air_robot
