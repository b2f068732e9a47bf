#include "robots/kid/calibration_stand.hpp"
#include "robots/kid/camera_pose.hpp"
#include "robots/kid/devices.hpp"
#include "robots/kid/figure_walk.hpp"
#include "robots/kid/gaze.hpp"
#include "robots/kid/kick_plan.hpp"
#include "robots/kid/mover.hpp"
#include "robots/robot_kind.hpp"
#include "soccer/baseline/player.hpp"
#include "soccer/play/player.hpp"
#include "soccer/sight/sight.hpp"
#include "soccer/world/locate.hpp"
#include "soccer/world/team.hpp"
#include "soccer/world/track_ball.hpp"
#include "soccer/world/track_obstacles.hpp"

namespace sinew::robots {
namespace {

void add_kid_modules(rt::ModuleTypes& types) {
  types.add<kid::Mover>("kid::Mover");
  types.add<kid::CameraPose>("kid::CameraPose");
  types.add<kid::Gaze>("kid::Gaze");
  types.add<kid::FigureWalk>("kid::FigureWalk");
  types.add<kid::KickPlan>("kid::KickPlan");
  types.add<kid::CalibrationStand>("kid::CalibrationStand");
  types.add<soccer::Sight>("soccer::Sight");
  types.add<soccer::Locate>("soccer::Locate");
  types.add<soccer::TrackBall>("soccer::TrackBall");
  types.add<soccer::PlaySoccer>("soccer::PlaySoccer");
  types.add<soccer::PlayBaseline>("soccer::PlayBaseline");
  types.add<soccer::TrackObstacles>("soccer::TrackObstacles");
  types.add<soccer::Team>("soccer::Team");
}

constexpr BodyModule kKidModules[] = {
    {"kid::CameraPose",
     [](const RobotBody& body) -> std::unique_ptr<rt::Module> { return std::make_unique<kid::CameraPose>(body); }},
    {"kid::CalibrationStand",
     [](const RobotBody& body) -> std::unique_ptr<rt::Module> {
       return std::make_unique<kid::CalibrationStand>(body);
     }},
    {"kid::Mover",
     [](const RobotBody& body) -> std::unique_ptr<rt::Module> { return std::make_unique<kid::Mover>(body); }},
    {"kid::Gaze",
     [](const RobotBody& body) -> std::unique_ptr<rt::Module> { return std::make_unique<kid::Gaze>(body); }},
};

constexpr PhaseWords kKidPhases[] = {
    {"kid::FigureWalk", msg::MissionPhase::wait, "standing"},
    {"kid::FigureWalk", msg::MissionPhase::approach, "walking the figure"},
    {"kid::FigureWalk", msg::MissionPhase::hold, "coming to a stand"},
    {"kid::KickPlan", msg::MissionPhase::wait, "getting on its feet"},
    {"kid::KickPlan", msg::MissionPhase::approach, "waiting until it is time"},
    {"kid::CalibrationStand", msg::MissionPhase::hold, "standing in poses"},
    {"kid::KickPlan", msg::MissionPhase::hold, "kicking or stopping the ball"},
};

}  // namespace

RobotKind describe_kid();
RobotKind describe_kid() {
  plant::WorldInfo world{"soccer", plant::kKidDevices, plant::soccer_options(), plant::kMostRobots};
  world.has_bodies = true;
  return {add_kid_modules, world, kKidPhases, kKidModules};
}

}  // namespace sinew::robots
