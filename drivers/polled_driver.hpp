#pragma once
// What the drivers of polled chips and serial lines have in common when they read their keys and open.
#include "drivers/driver.hpp"
#include "drivers/polled_sensor.hpp"

namespace sinew::drivers {

inline bool is_path(std::string_view path) { return path.size() > 1 && path.front() == '/'; }

inline PollOptions read_poll(DeviceKeys& keys, const std::string& path, hal::Duration period) {
  PollOptions poll;
  poll.name = keys.spec().name;
  poll.path = path;
  poll.period = period;
  poll.fifo_priority = 88;  // above the loops that wait for it
  keys.read_integer("priority", poll.fifo_priority, 0, 99, {.doc = "SCHED_FIFO of its thread; 0: an ordinary one"});
  return poll;
}

template <class M>
hal::Result<OpenedDevice> started(DeviceContext& context, std::unique_ptr<PolledDevice<M>> chip,
                                  const PollOptions& poll, std::string& why) {
  auto sensor = PolledSensor<M>::start(context.os, std::move(chip), poll, why);
  if (!sensor) return sensor.error();
  const std::shared_ptr<PolledSensor<M>> shared = std::move(*sensor);
  OpenedDevice device;
  device.owner = shared;
  device.report = shared.get();
  device.sensor(hal::kSensorKind<M>) = static_cast<hal::Sensor<M>*>(shared.get());
  return device;
}

}  // namespace sinew::drivers
