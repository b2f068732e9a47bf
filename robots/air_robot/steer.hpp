#pragma once
#include <array>

#include "msg/actuators.hpp"
#include "msg/motion.hpp"
#include "rt/module.hpp"

namespace sinew::air_robot {

/// A velocity of the whole robot as the drives of one that speaks text: which channel each part goes to, and how much
/// of it. With `joint_count`, setpoints of joints (those of its camera) are the channels behind these. A skid-steered
/// vehicle has left = forward - turn * width / 2: two channels with `turn` of different signs. Frames:  base: x
/// forward, y left, z up, a turn to the left is positive. Thread:  executor.   RT: yes. Errors:  stale without a
/// command, or setpoints of joints, that are young enough: nothing is published, and the lease
///          ends it; fault when the joints are of another number, or there are more channels than a group has.
class Steer final : public rt::Module {
 public:
  void declare(rt::Declaration& d) override;
  rt::StepStatus step(const rt::Step& step) noexcept override;

 private:
  static constexpr std::size_t kParts = 4;
  rt::In<msg::VelocityCommand> velocity_;
  rt::In<msg::ActuatorCommand> joints_;
  rt::Out<msg::ActuatorCommand> drives_;
  std::int64_t channels_ = 4, joint_count_ = 0;
  std::array<std::array<double, kParts>, msg::kMaxChannels> gain_{};  // by channel: forward, left, up, turn
};

}  // namespace sinew::air_robot
