#pragma once
// Poses in which a humanoid stood still before a board, out of a recording.
#include <optional>
#include <string>
#include <vector>

#include "apps/calibrate/recorded_boards.hpp"
#include "apps/robot_file/robot_file.hpp"
#include "identify/stand_fit.hpp"

namespace sinew::app {

struct RecordedStand {
  std::vector<identify::StandPose> poses;
  std::size_t still = 0, not_flat = 0;  // poses that were found; of them those in which a sole lay not flat
};

/// The board, angles and acceleration of each pose are means over the time in which the pictures stood still. Joints
/// are those of the topics that a module of the robot file reads at its ports head_joints, left_leg_joints and
/// right_leg_joints; soles and IMU are the only topics of their types.
/// Nothing, with `why`: such a module, topic or body is missing.
std::optional<RecordedStand> read_stand(record::Reader& reader, const RobotFile& robot, const RecordedBoards& boards,
                                        double square_m, std::uint32_t columns, std::string& why);

}  // namespace sinew::app
