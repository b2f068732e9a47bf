#include "hal/device.hpp"

namespace sinew::hal {

const char* to_string(SensorKind kind) {
  switch (kind) {
    case SensorKind::imu:
      return "imu";
    case SensorKind::range:
      return "range finder";
    case SensorKind::baro:
      return "barometer";
    case SensorKind::battery:
      return "battery";
    case SensorKind::mag:
      return "magnetometer";
    case SensorKind::gnss:
      return "GNSS receiver";
    case SensorKind::rc:
      return "radio-control receiver";
    case SensorKind::joints:
      return "joints";
    case SensorKind::text:
      return "text robot";
    case SensorKind::soles:
      return "soles";
    case SensorKind::referee:
      return "referee";
  }
  return "?";
}

}  // namespace sinew::hal
