#include "apps/module_list.hpp"

#include "apps/flight/robot_modules.hpp"
#include "apps/run/ground_truth_source.hpp"
#include "apps/run/run_log.hpp"
#include "msg/flight.hpp"

namespace sinew::app {

rt::ModuleTypes all_modules() {
  rt::ModuleTypes types = robot_modules();
  types.add<RunLog<msg::NavState>>("app::StateLog");
  types.add<RunLog<msg::MotionField>>("app::MotionLog");
  add_ground_truth_type(types);
  return types;
}

}  // namespace sinew::app
