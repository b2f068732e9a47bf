#pragma once
#include <memory>
#include <string>

#include "net/bridge/ros2_bridge.hpp"
#include "net/part.hpp"

namespace sinew::net {

/// The bridge to ROS 2 as a part of the program beside the robot.
class Ros2Part final : public Part {
 public:
  Ros2Part(std::string robot, ros2::BridgeSpec spec) : robot_(std::move(robot)), spec_(std::move(spec)) {}
  bool start(Participant& participant, std::string& why) override;
  std::vector<OwnEndpoint> endpoints() const override;
  void look(hal::Time now) override;
  void add_status(nlohmann::json& status) const override;

 private:
  const std::string robot_;
  const ros2::BridgeSpec spec_;
  std::unique_ptr<Ros2Bridge> bridge_;  // null: not started
};

}  // namespace sinew::net
