#include "robots/robot_kind.hpp"
#include "robots/spark/devices.hpp"

namespace sinew::robots {

RobotKind describe_spark();
RobotKind describe_spark() {
  plant::WorldInfo world{"simspark", plant::kSparkDevices, plant::spark_options()};
  world.has_bodies = true;
  return {nullptr, world};
}

}  // namespace sinew::robots
