#include "drivers/joints/serial_buses.hpp"

#include <algorithm>

#include "drivers/device_place.hpp"
#include "drivers/joints/can_buses.hpp"

namespace sinew::drivers {

SerialBusConfig read_serial_bus(DeviceKeys& keys) {
  constexpr std::string_view kPath = "the path of a serial line, e.g. \"/dev/ttyUSB0\"";
  SerialBusConfig c;
  c.spec.low_latency = true;
  c.spec.bit_rate = 1'000'000;
  if (keys.read("path", c.spec.path, kPath, {.doc = "its serial line", .required = true}) &&
      (c.spec.path.size() < 2 || c.spec.path.front() != '/'))
    keys.problem("path", kPath);
  keys.claim("path", "serial line " + place_of_path(c.spec.path));
  keys.read_integer("bit_rate", c.spec.bit_rate, 9'600, 4'500'000, {.unit = "bit/s", .doc = "as the servos are set"});
  c.hub.name = keys.spec().name;
  SerialLineRate& rate = c.hub.rate;
  rate.bit_rate = c.spec.bit_rate;
  keys.read(
      "tick_hz", rate.tick_hz, 1, 1000,
      {.unit = "Hz", .doc = "setpoints, answers of all, and one slow register; more than the line holds is refused"});
  keys.read("fast_read", rate.fast_read,
            {.doc = "all answer in one packet (protocol 2.0, newer firmwares): shorter, but one lost byte costs it"});
  keys.read_ms("latency_ms", rate.latency, 0.05, 50,
               {.doc = "how late the adapter hands bytes over; of FTDI ones the latency timer, which is set to 1 ms"});
  // As the thread of a CAN bus.
  c.hub.thread.fifo_priority = 90;
  c.hub.thread.stack_bytes = std::size_t{128} * 1024;
  c.hub.thread.name = c.hub.name;
  keys.read_integer("priority", c.hub.thread.fifo_priority, 0, 99,
                    {.doc = "SCHED_FIFO of the line's thread; 0: an ordinary one"});
  return c;
}

double bus_tick_hz(const DeviceSpec& bus) {
  std::vector<rt::Problem> told;
  DeviceKeys keys(bus, "", told);
  return bus.driver == kSerialBus ? read_serial_bus(keys).hub.rate.tick_hz : read_can_bus(keys).hub.tick_hz;
}

SerialBuses::~SerialBuses() {
  for (auto& [name, bus] : opened_) bus.hub->stop();
}

hal::Result<SerialBuses::Bus*> SerialBuses::open(const std::string& name, std::string& why) {
  if (const auto it = opened_.find(name); it != opened_.end()) return &it->second;
  const auto spec =
      std::find_if(specs_.buses.begin(), specs_.buses.end(), [&](const DeviceSpec& s) { return s.name == name; });
  if (spec == specs_.buses.end()) {
    why = "there is no [bus." + name + "]";
    return hal::Error{hal::Errc::not_found, "no [bus.NAME] of this name"};
  }
  std::vector<rt::Problem> problems;  // check_devices() reported them already
  DeviceKeys keys(*spec, "bus." + name, problems);
  const SerialBusConfig config = read_serial_bus(keys);
  std::string said;
  auto line = connectors_.serial(config.spec, said);
  if (!said.empty()) said = "bus '" + name + "': " + said;
  if (!line) {
    why = said;
    return line.error();
  }
  if (!said.empty()) warnings_.push_back(said);
  Bus bus;
  bus.hub = std::make_unique<SerialHub>(
      os_, std::move(*line),
      [spec = config.spec, &connectors = connectors_](std::string& words) { return connectors.serial(spec, words); },
      config.hub);
  return &opened_.emplace(name, std::move(bus)).first->second;
}

hal::Status SerialBuses::start(std::string& why) { return start_hubs(opened_, why); }

std::vector<std::string> SerialBuses::complaints() const {
  std::vector<std::string> all;
  for (const auto& [name, bus] : opened_)
    if (const std::string what = bus.hub->trouble(); !what.empty()) all.push_back("bus '" + name + "': " + what);
  return all;
}

std::vector<std::string> SerialBuses::shortfalls() const { return hub_shortfalls(opened_); }

}  // namespace sinew::drivers
