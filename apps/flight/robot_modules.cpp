#include "apps/flight/robot_modules.hpp"

#include "control/attitude_controller.hpp"
#include "control/error_state_filter.hpp"
#include "control/excitation.hpp"
#include "control/head_follower.hpp"
#include "control/mixer.hpp"
#include "control/motion_altitude.hpp"
#include "control/position_controller.hpp"
#include "control/team_locator.hpp"
#include "drivers/sources/camera_source.hpp"
#include "drivers/sources/sensor_source.hpp"
#include "robots/robot_kind.hpp"
#include "vision/ball_detector.hpp"
#include "vision/ground_motion.hpp"
#include "vision/motion_field.hpp"
#include "vision/pad_detector.hpp"

namespace sinew::app {

rt::ModuleTypes robot_modules() {
  rt::ModuleTypes types;
  types.add<drivers::ImuSource>("drivers::ImuSource");
  types.add<drivers::RangeSource>("drivers::RangeSource");
  types.add<drivers::BaroSource>("drivers::BaroSource");
  types.add<drivers::BatterySource>("drivers::BatterySource");
  types.add<drivers::MagSource>("drivers::MagSource");
  types.add<drivers::GnssSource>("drivers::GnssSource");
  types.add<drivers::RcSource>("drivers::RcSource");
  types.add<drivers::JointSource>("drivers::JointSource");
  types.add<drivers::TextSource>("drivers::TextSource");
  types.add<drivers::SoleSource>("drivers::SoleSource");
  types.add<drivers::RefereeSource>("drivers::RefereeSource");
  types.add<drivers::CameraSource>("drivers::CameraSource");
  types.add<drivers::RadioSource>("drivers::RadioSource");
  types.add<control::ErrorStateFilter>("control::ErrorStateFilter");
  types.add<control::HeadFollower>("control::HeadFollower");
  types.add<control::Excitation>("control::Excitation");
  types.add<control::AttitudeController>("control::AttitudeController");
  types.add<control::PositionController>("control::PositionController");
  types.add<control::MotionAltitude>("control::MotionAltitude");
  types.add<control::TeamLocator>("control::TeamLocator");
  types.add<control::Mixer>("control::Mixer");
  types.add<vision::BallDetector>("vision::BallDetector");
  types.add<vision::PadDetector>("vision::PadDetector");
  types.add<vision::MotionField>("vision::MotionField");
  types.add<vision::GroundMotion>("vision::GroundMotion");
  for (const robots::RobotKind& robot : robots::all_robots())
    if (robot.add_modules) robot.add_modules(types);
  return types;
}

}  // namespace sinew::app
