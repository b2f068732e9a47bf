#include "apps/module_list.hpp"

#include "drivers/camera_source.hpp"
#include "drivers/sensor_source.hpp"

namespace sinew::app {

rt::ModuleTypes all_modules() {
  rt::ModuleTypes types;
  types.add<drivers::ImuSource>("drivers::ImuSource");
  types.add<drivers::RangeSource>("drivers::RangeSource");
  types.add<drivers::BaroSource>("drivers::BaroSource");
  types.add<drivers::CameraSource>("drivers::CameraSource");
  return types;
}

}  // namespace sinew::app
