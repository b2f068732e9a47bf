#pragma once
// The joints of an actuator group in a recording: what was commanded, and what they measured.
#include <optional>
#include <string>
#include <vector>

#include "identify/base_parameters.hpp"
#include "identify/servo_fit.hpp"
#include "record/reader.hpp"

namespace sinew::app {

struct RecordedJoints {
  std::string group;                                         // the actuator group of the robot file
  std::vector<std::string> names;                            // as its device names them, or "joint 0", ...
  std::vector<identify::CommandLine> commands;               // of each joint; positions as they went out, NaN: none
  std::vector<std::vector<double>> time_s;                   // of each joint's measurements
  std::vector<std::vector<double>> position_rad, effort_nm;  // effort empty: not measured
  std::size_t joints() const { return commands.size(); }

  /// The longest time in which this joint moved and no other did, cut out. Nothing: there is none of 5 s.
  std::optional<identify::ServoRecord> alone(std::size_t joint) const;
  /// All joints at common times, for a body whose joints have these names. Nothing, with `why`: some are missing, or
  /// measure no efforts.
  std::optional<identify::ChainRecord> together(const kinematics::Body& body, std::string& why) const;
};

/// Reads the group's commands from the guardian's topic and the joints from a topic of JointState; empty names: the
/// only ones of their kind. Errors:  nothing, with `why`: a topic is missing, there are several, or it was recorded by
/// another version.
std::optional<RecordedJoints> read_joints(record::Reader& reader, const std::string& group, const std::string& joints,
                                          std::string& why);

}  // namespace sinew::app
