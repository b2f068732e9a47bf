#include "drivers/can_buses.hpp"

#include <algorithm>

#include "hal/self_report.hpp"

namespace sinew::drivers {

CanBusConfig read_can_bus(DeviceKeys& keys) {
  CanBusConfig c;
  c.spec.transport = keys.spec().driver;
  const auto address = keys.spec().keys.find("address");
  std::uint32_t number = 0;  // of a bus over UDP, as a number or as a text
  if (address != keys.spec().keys.end() && std::holds_alternative<std::int64_t>(address->second.value)) {
    if (keys.read_integer("address", number, 0, 255)) c.spec.address = std::to_string(number);
  } else {
    keys.require("address", c.spec.address,
                 "an interface (socketcan), a bus number or 239.65.82.B (udp), or HOST:PORT/BUS (socketcand)");
  }
  keys.claim("address", c.spec.transport + " bus " + c.spec.address);
  keys.read_integer("bit_rate", c.spec.bit_rate, 10'000, 1'000'000);
  keys.read_integer("data_bit_rate", c.spec.data_bit_rate, 0, 8'000'000);
  c.hub.name = keys.spec().name;
  keys.read("tick_hz", c.hub.tick_hz, 1, 4000);
  double percent = 100 * c.hub.max_load;
  if (keys.read("max_load_percent", percent, 1, 100)) c.hub.max_load = percent / 100;
  // Its thread is what the bus's interrupt would be: above the loops that wait for it, below the guardian.
  c.hub.thread.fifo_priority = 90;
  c.hub.thread.stack_bytes = std::size_t{64} * 1024;
  c.hub.thread.name = c.hub.name;
  keys.read_integer("priority", c.hub.thread.fifo_priority, 0, 99);
  keys.read_integer("master_node", c.master_node, 1, 127);
  double heartbeat_ms = 10;
  if (keys.read("master_heartbeat_ms", heartbeat_ms, 1, 1000))
    c.master_heartbeat = hal::Duration{static_cast<std::int64_t>(heartbeat_ms * 1e6)};
  keys.read_integer("dronecan_node", c.dronecan.node_id, 1, 127);
  return c;
}

CanBuses::CanBuses(const DeviceSpecs& specs, hal::Connectors& connectors, hal::Os& os)
    : specs_(specs), connectors_(connectors), os_(os) {}

CanBuses::~CanBuses() {
  for (auto& [name, bus] : opened_)
    if (bus.hub) bus.hub->stop();
}

hal::Result<CanBuses::Bus*> CanBuses::open(const std::string& name, std::string& why) {
  if (const auto it = opened_.find(name); it != opened_.end()) return &it->second;
  const auto spec =
      std::find_if(specs_.buses.begin(), specs_.buses.end(), [&](const DeviceSpec& s) { return s.name == name; });
  if (spec == specs_.buses.end()) {
    why = "there is no [bus." + name + "]";
    return hal::Error{hal::Errc::not_found, "no [bus.NAME] of this name"};
  }
  std::vector<rt::Problem> problems;  // have been told
  DeviceKeys keys(*spec, "bus." + name, problems);
  Bus bus;
  bus.config = read_can_bus(keys);
  std::string said;
  auto opened = connectors_.can(bus.config.spec, said);
  if (!said.empty()) said = "bus '" + name + "': " + said;
  if (!opened) {
    why = said;
    return opened.error();
  }
  if (!said.empty()) warnings_.push_back(said);
  bus.bus = std::move(*opened);
  bus.hub = std::make_unique<CanHub>(os_, *bus.bus, bus.config.hub);
  bus.add = [hub = bus.hub.get()](std::unique_ptr<BusService> service) { hub->add(std::move(service)); };
  return &opened_.emplace(name, std::move(bus)).first->second;
}

hal::Status CanBuses::start(std::string& why) {
  for (auto& [name, bus] : opened_) {
    if (bus.started) continue;
    if (auto planned = bus.hub->configure(why); !planned) {
      why = "bus '" + name + "': " + why;
      return planned;
    }
    if (auto started = bus.hub->start(); !started) {
      why = "bus '" + name + "': its thread does not start";
      return started;
    }
    bus.started = true;
  }
  return {};
}

std::vector<std::string> CanBuses::complaints() const {
  std::vector<std::string> all;
  for (const auto& [name, bus] : opened_) {
    const auto* report = dynamic_cast<const hal::SelfReport*>(bus.bus.get());
    std::string what = report ? report->trouble() : std::string();
    const hal::CanStats stats = bus.bus->stats();
    // What the transport has no words for; the controller's own counters move with every frame and are left out.
    if (what.empty() && stats.state == hal::CanState::bus_off) what = "bus-off: nothing is sent or received";
    if (what.empty() && stats.state == hal::CanState::passive)
      what = "error-passive: nobody acknowledges, or many errors (wiring, termination, bit rate, power of the drives?)";
    if (!what.empty()) all.push_back("bus '" + name + "': " + what);
  }
  return all;
}

std::vector<std::string> CanBuses::shortfalls() const {
  std::vector<std::string> all;
  for (const auto& [name, bus] : opened_)
    if (const std::string what = bus.hub->shortfall(); !what.empty())
      all.push_back("thread of bus '" + name + "': " + what);
  return all;
}

}  // namespace sinew::drivers
