#pragma once
// A body with its motions, and the errors of the plant that it is tried on.
#include "kinematics/body.hpp"
#include "motion/motion_book.hpp"
#include "sim_hil/worlds/body_errors.hpp"

namespace sinew::gait {

struct GaitSetup {
  kinematics::Body body;
  motion::MotionBook book{};
  plant::BodyErrors errors{};
  plant::GroundErrors ground{};
};

}  // namespace sinew::gait
