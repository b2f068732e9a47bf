#include "drivers/joints/can_buses.hpp"

#include <algorithm>
#include <array>
#include <charconv>

#include "drivers/device_place.hpp"
#include "drivers/joints/serial_buses.hpp"
#include "hal/self_report.hpp"

namespace sinew::drivers {

namespace {

constexpr std::array<std::string_view, 3> kTransports{"socketcan", "udp", "socketcand"};
constexpr std::array<std::string_view, 4> kBusDrivers{"socketcan", "udp", "socketcand", kSerialBus};

bool is_number(std::string_view text, unsigned most) {
  unsigned number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  return error == std::errc() && end == text.data() + text.size() && number <= most;
}

/// As the kernel names its interfaces (IFNAMSIZ, dev_valid_name()): below 16 characters, none of them / : or a space.
bool is_interface(std::string_view name) {
  return !name.empty() && name.size() < 16 && name != "." && name != ".." &&
         std::none_of(name.begin(), name.end(), [](char c) { return c == '/' || c == ':' || c <= ' '; });
}

/// "7", "239.65.82.7", each with ":INTERFACE".
bool is_udp_bus(std::string_view address) {
  if (const std::size_t colon = address.find(':'); colon != std::string_view::npos) {
    if (!is_interface(address.substr(colon + 1))) return false;
    address = address.substr(0, colon);
  }
  constexpr std::string_view kGroups = "239.65.82.";  // wire/dronecan_udp.hpp
  if (address.starts_with(kGroups)) address.remove_prefix(kGroups.size());
  return is_number(address, 255);
}

/// "HOST:PORT/BUS", "[HOST]:PORT/BUS".
bool is_served_bus(std::string_view address) {
  const std::size_t slash = address.rfind('/');
  const std::size_t colon = address.substr(0, slash).rfind(':');
  if (slash == std::string_view::npos || colon == std::string_view::npos || colon == 0) return false;
  const std::string_view port = address.substr(colon + 1, slash - colon - 1);
  return is_number(port, 65535) && port != "0" && is_interface(address.substr(slash + 1));
}

struct Address {
  std::string_view allowed;
  bool (*is)(std::string_view);
};
Address address_of(std::string_view transport) {
  if (transport == "socketcan") return {"the name of an interface, e.g. \"can0\"", is_interface};
  if (transport == "udp")
    return {"0 to 255 or \"239.65.82.N\"; as a text with \":INTERFACE\" where that is not lo", is_udp_bus};
  return {"\"HOST:PORT/BUS\", e.g. \"localhost:29536/can0\"", is_served_bus};
}

void read_address(DeviceKeys& keys, hal::CanSpec& spec) {
  const Address address = address_of(spec.transport);
  const KeyInfo info{.doc = "which bus", .required = true};
  const bool given = spec.transport == "udp" ? keys.read_text_or_number("address", spec.address, address.allowed, info)
                                             : keys.read("address", spec.address, address.allowed, info);
  if (given && !address.is(spec.address)) keys.problem("address", address.allowed);
}

}  // namespace

std::span<const std::string_view> can_transports() { return kTransports; }

CanBusConfig read_can_bus(DeviceKeys& keys) {
  CanBusConfig c;
  c.spec.transport = keys.spec().driver;
  if (std::find(kTransports.begin(), kTransports.end(), c.spec.transport) == kTransports.end()) {
    keys.refuse_driver(kBusDrivers);
    return c;
  }
  read_address(keys, c.spec);
  keys.claim("address", c.spec.transport + " bus " + place_of_bus(c.spec.transport, c.spec.address));
  // The bit rates that controllers are set to: CiA 301 section 5.5, and the two of SAE J2411 and of older cars.
  keys.read_one_of("bit_rate", c.spec.bit_rate,
                   {10'000, 20'000, 33'333, 50'000, 83'333, 100'000, 125'000, 250'000, 500'000, 800'000, 1'000'000},
                   {.unit = "bit/s", .doc = "for the bus load; the interface itself is set up by the system"});
  keys.read_one_of("data_bit_rate", c.spec.data_bit_rate,
                   {0, 500'000, 1'000'000, 2'000'000, 4'000'000, 5'000'000, 8'000'000},
                   {.unit = "bit/s", .doc = "of CAN FD; 0: classic frames only"});
  c.hub.name = keys.spec().name;
  keys.read("tick_hz", c.hub.tick_hz, 1, 4000,
            {.unit = "Hz", .doc = "setpoints, SYNC and questions; with cia402 one whose period 60C2h holds"});
  double percent = 100 * c.hub.max_load;
  if (keys.read("max_load_percent", percent, 1, 100,
                {.unit = "%", .doc = "of the bit rate, with worst-case stuffing; more does not start"}))
    c.hub.max_load = percent / 100;
  // The thread has the rank of the bus's interrupt: above the loops that wait for it, below the guardian.
  c.hub.thread.fifo_priority = 90;
  c.hub.thread.stack_bytes = std::size_t{64} * 1024;
  c.hub.thread.name = c.hub.name;
  keys.read_integer("priority", c.hub.thread.fifo_priority, 0, 99,
                    {.doc = "SCHED_FIFO of the bus's thread; 0: an ordinary one"});
  keys.read_integer("master_node", c.master_node, 1, 127, {.doc = "CANopen: our own node id"});
  keys.read_ms("master_heartbeat_ms", c.master_heartbeat, 1, 1000, {.doc = "CANopen: our own heartbeat"});
  keys.read_integer("dronecan_node", c.dronecan.node_id, 1, 127, {.doc = "DroneCAN: our own node id"});
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
  std::vector<rt::Problem> problems;  // check_devices() reported them already
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

hal::Status CanBuses::start(std::string& why) { return start_hubs(opened_, why); }

std::vector<std::string> CanBuses::complaints() const {
  std::vector<std::string> all;
  for (const auto& [name, bus] : opened_) {
    const auto* report = dynamic_cast<const hal::SelfReport*>(bus.bus.get());
    std::string what = report ? report->trouble() : std::string();
    const hal::CanStats stats = bus.bus->stats();
    // States that the transport has no words for. The controller's counters move with every frame: they are left out.
    if (what.empty() && stats.state == hal::CanState::bus_off) what = "bus-off: nothing is sent or received";
    if (what.empty() && stats.state == hal::CanState::passive)
      what = "error-passive: nobody acknowledges, or many errors (wiring, termination, bit rate, power of the drives?)";
    if (!what.empty()) all.push_back("bus '" + name + "': " + what);
  }
  return all;
}

std::vector<std::string> CanBuses::shortfalls() const { return hub_shortfalls(opened_); }

}  // namespace sinew::drivers
