#pragma once
#include <nlohmann/json_fwd.hpp>

#include <memory>
#include <string>
#include <vector>

#include "net/dds/match.hpp"
#include "net/dds/participant.hpp"
#include "net/ros2/bridge_spec.hpp"

namespace sinew::net {

/// A robot as a node of a ROS 2 graph: its topics out, others into its external topics, and what makes a node
/// (docs/ros2.md). It is an outsider to the robot, as every program at its socket: it may come before the robot and
/// outlives it.
/// Thread:  owner; the bridge has threads of its own, since a robot may take seconds for an answer.
/// Owner:   ends before the participant that it was started with.
class Ros2Bridge {
 public:
  Ros2Bridge(std::string robot, ros2::BridgeSpec spec);
  ~Ros2Bridge();
  Ros2Bridge(const Ros2Bridge&) = delete;
  Ros2Bridge& operator=(const Ros2Bridge&) = delete;

  /// Makes its endpoints and begins. Errors: false, `why`: an endpoint that DDS refuses.
  bool start(Participant& participant, std::string& why);
  /// The participant's wake_fd() was readable: takes what came.
  void look();
  /// What it writes and reads, after start().
  const std::vector<OwnEndpoint>& endpoints() const;
  /// Adds `ros2`: whether the robot is there, and for each topic its counts and what was wrong last.
  void add_status(nlohmann::json& status) const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace sinew::net
