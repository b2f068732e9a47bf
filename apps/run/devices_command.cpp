// devices: lists a robot file's devices, and asks which devices answer on its CAN buses and serial lines.
#include "apps/run/devices_command.hpp"

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <cstdio>
#include <ranges>

#include "apps/command/choice_check.hpp"
#include "apps/command/json.hpp"
#include "apps/robot/linux_board.hpp"
#include "apps/run/commands.hpp"
#include "apps/run/run_setup.hpp"
#include "apps/run/serial_devices.hpp"
#include "drivers/joints/can_buses.hpp"
#include "drivers/joints/can_scan.hpp"
#include "drivers/joints/joint_keys.hpp"
#include "drivers/joints/serial_buses.hpp"
#include "hal/linux/devices/connectors.hpp"
#include "hal/platform.hpp"
#include "tap/names.hpp"

namespace sinew::app {
namespace {

using drivers::CanFamily;
using drivers::CanFound;

/// A joint of the robot file, as it is on its bus.
struct Expected {
  std::string name, bus;
  CanFamily family{};
  std::uint32_t id = 0, master = 0;  // master: mit
};

struct Bus {
  std::string name;
  hal::CanSpec spec;
};

/// Each joint as it will be opened; those on serial lines go to `servos`. The devices must have no problems.
std::vector<Expected> joints_of(const drivers::DeviceSpecs& specs, std::vector<ExpectedServo>& servos) {
  constexpr std::pair<const char*, CanFamily> kDrivers[] = {{"cia402", CanFamily::canopen},
                                                            {"mit", CanFamily::mit},
                                                            {"cybergear", CanFamily::cybergear},
                                                            {"dronecan", CanFamily::dronecan}};
  std::vector<Expected> all;
  for (const auto& device : specs.devices)
    for (const auto& joint : device.joints) {
      std::vector<rt::Problem> told;
      drivers::DeviceKeys keys(joint, "", told);
      const drivers::JointConfig config = drivers::read_joint(keys, specs);
      if (config.serial)
        servos.push_back({device.name + "." + joint.name, config.bus, config.make_serial()->model().maker,
                          static_cast<std::uint8_t>(config.servo.node_id)});
      for (const auto& [driver, family] : kDrivers)
        if (config.protocol == driver)
          all.push_back({device.name + "." + joint.name, config.bus, family, config.servo.node_id, config.replies_as});
    }
  return all;
}

std::optional<CanFamily> family_of(const std::string& name) {
  for (const CanFamily family : drivers::kCanFamilies)
    if (name == to_string(family)) return family;
  return std::nullopt;
}

/// "udp:7", "socketcan:can0", "socketcand:HOST:PORT/BUS".
std::optional<Bus> parse_bus(const std::string& whole) {
  const auto colon = whole.find(':');
  if (colon == std::string::npos || colon == 0 || colon + 1 == whole.size()) return std::nullopt;
  return Bus{whole, {whole.substr(0, colon), whole.substr(colon + 1)}};
}

class DevicesCommand {
 public:
  explicit DevicesCommand(const DevicesOptions& options) : o_(options) {}

  int run() {
    for (const std::string& name : o_.ask)
      if (const auto family = family_of(name)) families_.push_back(*family);
    const auto asked = [this](const char* name) { return o_.ask.empty() || std::ranges::count(o_.ask, name) > 0; };
    lines_.dynamixel = asked("dynamixel"), lines_.feetech = asked("feetech");
    lines_.json = o_.json, lines_.with_robot = !o_.robot.empty(), lines_.bit_rates = o_.bit_rates;
    if (o_.ask.empty()) families_.assign(std::begin(drivers::kCanFamilies), std::end(drivers::kCanFamilies));
    if (!o_.robot.empty() && !read_robot()) return kNotBegun;
    for (const std::string& text : o_.buses) {
      const auto bus = parse_bus(text);
      if (!bus)
        return fail("--bus " + text +
                    ": TRANSPORT:ADDRESS: socketcan:can0, udp:7, socketcand:HOST:PORT/BUS, serial:/dev/ttyUSB0");
      if (bus->spec.transport == drivers::kSerialBus)
        lines_.add(bus->spec.address);
      else
        buses_.push_back(*bus);
    }
    if (o_.robot.empty() && o_.buses.empty()) return fail("devices: a robot file or --bus");
    if (!o_.json) print_devices();
    Json all = Json::array();
    bool good = true;
    if (!families_.empty())
      for (const Bus& bus : buses_) good = scan(bus, all) && good;
    if (lines_.dynamixel || lines_.feetech) good = lines_.scan(all) && good;
    if (o_.json) std::printf("%s\n", Json{{"devices", devices_}, {"buses", all}}.dump().c_str());
    return good ? kDone : kFailed;
  }

 private:
  bool read_robot() {
    LoadedRobot loaded = load_robot(o_.robot);
    auto& problems = loaded.problems;
    for (const std::string& setting : o_.set) {
      if (const std::string why = apply_only_device_setting(loaded.robot.devices, setting); !why.empty()) {
        fail(why);
        return false;
      }
    }
    if (problems.empty())
      for (auto& p : check_linux_devices(loaded.robot)) problems.push_back(std::move(p));
    for (const auto& p : problems) std::fprintf(stderr, "%s\n", to_string(p, loaded.robot).c_str());
    if (!problems.empty()) return false;
    for (const auto& bus : loaded.robot.devices.buses) {
      drivers::DeviceKeys keys(bus, "bus." + bus.name, problems);
      if (bus.driver == drivers::kSerialBus) {
        lines_.add(bus.name, drivers::read_serial_bus(keys));
        continue;
      }
      buses_.push_back({bus.name, drivers::read_can_bus(keys).spec});
    }
    for (const auto& device : loaded.robot.devices.devices)
      devices_.push_back({{"name", device.name}, {"driver", device.driver}});
    joints_ = joints_of(loaded.robot.devices, lines_.joints);
    return not_while_it_runs(loaded.robot.graph.robot);
  }

  /// False after printing that the robot runs: the question to MIT motors takes their torque, and a running robot's bus
  /// would get answers that it did not ask for.
  bool not_while_it_runs(const std::string& robot) {
    std::string why;
    const auto running = tap::running(why);
    if (!running || std::ranges::none_of(*running, [&](const auto& r) { return r.robot == robot; })) return true;
    fail(robot + " runs: its buses are not asked meanwhile (sinew status says how its devices are)");
    return false;
  }

  void print_devices() const {
    for (const Json& device : devices_)
      std::printf("device %-12s %s\n", device["name"].get<std::string>().c_str(),
                  device["driver"].get<std::string>().c_str());
  }

  const Expected* joint(const Bus& bus, CanFamily family, std::uint32_t id) const {
    const auto it = std::ranges::find_if(
        joints_, [&](const Expected& e) { return e.bus == bus.name && e.family == family && e.id == id; });
    return it == joints_.end() ? nullptr : &*it;
  }

  bool scan(const Bus& bus, Json& all) {
    std::string why;
    hal::Os& os = hal::system_os();
    const auto connectors = hal::LinuxConnectors::unwatched(os);
    auto opened = connectors->can(bus.spec, why);
    const std::string name = bus.name == bus.spec.transport + ":" + bus.spec.address
                                 ? bus.name
                                 : fmt::format("{} ({} {})", bus.name, bus.spec.transport, bus.spec.address);
    if (!opened) {
      fail("bus " + name + ": " + why);
      return false;
    }
    drivers::CanScan::Options options{.families = families_};
    for (const Expected& e : joints_)
      if (e.bus == bus.name && e.family == CanFamily::mit) options.masters.push_back(e.master);
    drivers::CanScan scan(**opened, options);
    while (!scan.done()) {
      const auto next = scan.step(os.now());
      if (!next) {
        fail(fmt::format("bus {}: {}{}: no device takes a frame there", name, to_string(next.error().code),
                         why.empty() ? "" : ": " + why),
             kFailed);
        return false;
      }
      os.sleep_until(*next);
    }
    return tell(bus, name, scan.found(), all);
  }

  bool tell(const Bus& bus, const std::string& name, const std::vector<CanFound>& found, Json& all) const {
    Json list = Json::array(), missing = Json::array();
    std::string lines;
    for (const CanFound& f : found) {
      const Expected* known = joint(bus, f.family, f.id);
      lines += fmt::format("  {:<10}{:>3}  {}", to_string(f.family), f.id, describe(f));
      if (known)
        lines += "; " + known->name;
      else if (!o_.robot.empty())
        lines += "; not in the robot file";
      lines += '\n';
      Json one{{"family", to_string(f.family)}, {"id", f.id}, {"joint", known ? Json(known->name) : Json(nullptr)}};
      if (f.device_type) one["device_type"] = *f.device_type;
      if (f.vendor) one["vendor"] = *f.vendor;
      if (f.product) one["product"] = *f.product;
      if (f.family == CanFamily::mit) one["replies_as"] = f.replies_as;
      if (f.family == CanFamily::cybergear) one["serial"] = fmt::format("{:016x}", f.serial);
      if (f.family == CanFamily::dronecan) one["health"] = f.health, one["mode"] = f.mode;
      list.push_back(std::move(one));
    }
    for (const Expected& e : joints_) {
      const bool asked = e.bus == bus.name && std::ranges::count(families_, e.family) > 0;
      if (!asked || std::ranges::any_of(found, [&](const CanFound& f) { return f.family == e.family && f.id == e.id; }))
        continue;
      missing.push_back({{"joint", e.name}, {"family", to_string(e.family)}, {"id", e.id}});
      lines += fmt::format("  {:<10}{:>3}  no answer; {}\n", to_string(e.family), e.id, e.name);
    }
    if (!o_.json)
      std::printf("bus %s: %zu device%s\n%s", name.c_str(), found.size(), found.size() == 1 ? "" : "s", lines.c_str());
    const bool complete = missing.empty();
    all.push_back({{"bus", bus.name},
                   {"driver", bus.spec.transport},
                   {"address", bus.spec.address},
                   {"found", std::move(list)},
                   {"missing", std::move(missing)}});
    return complete;
  }

  const DevicesOptions& o_;
  std::vector<CanFamily> families_;
  std::vector<Bus> buses_;
  std::vector<Expected> joints_;
  SerialDevices lines_;
  Json devices_ = Json::array();
};

}  // namespace

int devices_command(const DevicesOptions& options) { return DevicesCommand(options).run(); }

void add_devices_command(CLI::App& app, CommandContext& context) {
  const auto o = std::make_shared<DevicesOptions>();
  CLI::App& devices =
      *app.add_subcommand("devices", "a robot's devices, and which devices answer on its CAN buses and serial lines");
  devices.add_option("robot", o->robot, "robot file: its [bus.NAME] are asked")->type_name(kRobotFileHint);
  devices
      .add_option("--bus", o->buses,
                  "another bus: socketcan:can0, udp:7, socketcand:HOST:PORT/BUS, serial:/dev/ttyUSB0; may be repeated")
      ->allow_extra_args(false)
      ->type_name("TRANSPORT:ADDRESS");
  devices
      .add_option("--ask", o->ask,
                  "only these, e.g. canopen,dynamixel. mit takes the torque of a motor that is live; nothing else does "
                  "anything")
      ->delimiter(',')
      ->type_name("{canopen,mit,cybergear,dronecan,dynamixel,feetech}")
      ->check(one_of({"canopen", "mit", "cybergear", "dronecan", "dynamixel", "feetech"}));
  devices
      .add_option(
          "--bit-rate", o->bit_rates,
          "of serial lines, e.g. 1000000,57600; default: the robot file's, else those that servos come with and "
          "are usually set to")
      ->delimiter(',')
      ->check(CLI::Range(9'600u, 4'500'000u))
      ->type_name("BIT/S");
  devices.add_option("--set", o->set, "bus.NAME.KEY=VALUE or device.NAME.KEY=VALUE for this time; may be repeated")
      ->allow_extra_args(false);
  devices.add_flag("--json", o->json, "as one JSON object");
  devices.callback([&context, o] { context.action = [o] { return devices_command(*o); }; });
}

}  // namespace sinew::app
