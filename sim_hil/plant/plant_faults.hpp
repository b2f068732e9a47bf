#pragma once
#include <deque>

#include "sim_hil/plant/actuator_faults.hpp"
#include "sim_hil/plant/camera_feed.hpp"
#include "sim_hil/plant/frame_faults.hpp"
#include "sim_hil/plant/radio_faults.hpp"
#include "sim_hil/worlds/sensor_faults.hpp"
#include "sim_hil/worlds/world.hpp"

namespace sinew::plant {

/// All faults of one run, device by device.
struct PlantFaults {
  PlantFaults(const std::vector<Fault>& list, std::uint64_t seed, const CameraOptions& view, const WorldInfo& world)
      : log(list, seed) {
    for (const WorldDevice& device : world.devices) {
      if (device.part == Part::camera) frames.emplace_back(log, view.format, view.width, view.height);
      if (device.part == Part::actuators) actuators.emplace_back(log, device);
      if (device.part == Part::joints) joints.emplace_back(log, FaultDevice::joints, device.bus);
    }
  }
  PlantFaults(const PlantFaults&) = delete;

  /// A fault closes the connection at or before t.
  bool line_closes_by(hal::Time t);

  FaultLog log;
  SensorFaults<msg::ImuSample> imu{log, FaultDevice::imu};
  SensorFaults<msg::RangeSample> range{log, FaultDevice::range};
  SensorFaults<msg::BaroSample> baro{log, FaultDevice::baro};
  SensorFaults<msg::BatterySample> battery{log, FaultDevice::battery};
  SensorFaults<msg::SolePressure> soles{log, FaultDevice::soles};
  SensorFaults<msg::RefereeState> referee{log, FaultDevice::referee};
  RadioFaults radio{log};
  // Of each camera and each group; a fault strikes all that have its device.
  std::deque<FrameFaults> frames;
  std::deque<ActuatorFaults> actuators;
  std::deque<SensorFaults<msg::JointState>> joints;
};

inline bool PlantFaults::line_closes_by(hal::Time t) {
  for (FaultLog::Entry& e : log.entries()) {
    if (e.fault.kind != FaultKind::closed || e.fault.from_ns > t.ns) continue;
    if (e.affected == 0) e.strike(t);
    return true;
  }
  return false;
}

}  // namespace sinew::plant
