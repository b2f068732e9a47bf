#include "apps/module_list.hpp"

#include "apps/ground_truth.hpp"
#include "apps/robot_modules.hpp"
#include "apps/run_log.hpp"
#include "msg/flight.hpp"

namespace sinew::app {

rt::ModuleTypes all_modules() {
  rt::ModuleTypes types = robot_modules();
  types.add<RunLog<msg::NavState>>("app::StateLog");
  types.add<RunLog<msg::MotionField>>("app::MotionLog");
  types.add<GroundTruth>("app::GroundTruth");
  return types;
}

}  // namespace sinew::app
