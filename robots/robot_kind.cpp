#include "robots/robot_kind.hpp"

namespace sinew::robots {

const plant::WorldInfo* find_world(std::string_view name) {
  for (const RobotKind& robot : all_robots())
    if (robot.world.name[0] != '\0' && robot.world.name == name) return &robot.world;
  return nullptr;
}

std::vector<std::string> world_names() {
  std::vector<std::string> names;
  for (const RobotKind& robot : all_robots())
    if (robot.world.name[0] != '\0') names.emplace_back(robot.world.name);
  return names;
}

std::string_view find_phase_words(std::string_view module_type, msg::MissionPhase phase) {
  for (const RobotKind& robot : all_robots())
    for (const PhaseWords& own : robot.phases)
      if (own.module == module_type && own.phase == phase) return own.words;
  return {};
}

}  // namespace sinew::robots
