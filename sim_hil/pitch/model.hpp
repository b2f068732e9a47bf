#pragma once
#include <span>
#include <string>

#include "sim_hil/pitch/pitch.hpp"

namespace sinew::plant {

/// A robot as it is in this run: its masses are the true ones.
struct ModelRobot {
  kinematics::Body body;
  double friction = 0.8;
  PitchBody::Kind kind = PitchBody::Kind::legged;
};

/// Names in the model: link, joint and place of robot i have this behind them.
std::string robot_name_end(std::size_t robot);
inline constexpr const char* kBallName = "ball";
inline constexpr const char* kGroundName = "ground";
inline constexpr double kGroundCell_m = 0.04;

/// Field, goals, ball and robots as MuJoCo's XML.
std::string pitch_xml(const PitchOptions& options, std::span<const ModelRobot> robots);

/// Which geoms touch which.
enum ContactBit : int { kSolid = 1, kUneven = 2, kBallOnly = 4 };

}  // namespace sinew::plant
