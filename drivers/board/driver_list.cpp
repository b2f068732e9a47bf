#include "drivers/board/driver_list.hpp"

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include "drivers/board/kernel_drivers.hpp"
#include "drivers/board/published_driver.hpp"
#include "drivers/board/radio_driver.hpp"
#include "drivers/chips/chip_drivers.hpp"
#include "drivers/game/game_controller.hpp"
#include "drivers/joints/can_servos.hpp"
#include "drivers/serial/serial_drivers.hpp"
#include "drivers/text/text_drivers.hpp"

namespace sinew::drivers {

std::span<const DriverKind> all_drivers() {
  static const std::vector<DriverKind> all = [] {
    std::vector<DriverKind> list;
    for (const auto group : {kernel_drivers(), chip_drivers(), serial_drivers(), text_drivers()})
      list.insert(list.end(), group.begin(), group.end());
    list.push_back(udp_radio_driver());
    list.push_back(dds_radio_driver());
    list.push_back({"can_servos", "actuators, joints", read_can_servos});
    list.push_back({"serial_servos", "actuators, joints", read_serial_servos});
    list.push_back({"joints_of", "joints", read_joints_of});
    list.push_back(game_controller_driver());
    list.push_back(published_driver());
    return list;
  }();
  return all;
}

namespace {

constexpr std::array<std::pair<std::string_view, std::string_view>, 14> kReaders{{{"imu", "drivers::ImuSource"},
                                                                                  {"range", "drivers::RangeSource"},
                                                                                  {"baro", "drivers::BaroSource"},
                                                                                  {"battery", "drivers::BatterySource"},
                                                                                  {"mag", "drivers::MagSource"},
                                                                                  {"gnss", "drivers::GnssSource"},
                                                                                  {"rc", "drivers::RcSource"},
                                                                                  {"joints", "drivers::JointSource"},
                                                                                  {"text", "drivers::TextSource"},
                                                                                  {"soles", "drivers::SoleSource"},
                                                                                  {"referee", "drivers::RefereeSource"},
                                                                                  {"camera", "drivers::CameraSource"},
                                                                                  {"radio", "drivers::RadioSource"},
                                                                                  {"actuators", "[actuator.NAME]"}}};

/// Each of DriverKind::measures, a list: "actuators, joints".
std::vector<std::string_view> measured_by(const DriverKind& driver) {
  std::vector<std::string_view> things;
  for (std::string_view rest = driver.measures; !rest.empty();) {
    const std::size_t end = std::min(rest.find(", "), rest.size());
    things.push_back(rest.substr(0, end));
    rest.remove_prefix(std::min(end + 2, rest.size()));
  }
  return things;
}

/// The keys that a reader declares when its table is empty.
template <class Read>
KeyTable table_of(std::string_view header, std::string_view driver, Read&& read) {
  DeviceSpec spec;
  spec.driver = driver;
  std::vector<rt::Problem> missing;
  DeviceKeys keys(spec, "", missing);
  static_cast<void>(read(keys));
  KeyTable table;
  table.header = header, table.driver = driver, table.rows = keys.rows();
  return table;
}

}  // namespace

std::string_view reader_of(std::string_view measured) {
  const auto it = std::find_if(kReaders.begin(), kReaders.end(), [&](const auto& r) { return r.first == measured; });
  return it == kReaders.end() ? std::string_view{} : it->second;
}

std::vector<KeyTable> key_tables() {
  std::vector<KeyTable> all;
  const DeviceSpecs none;
  for (const DriverKind& driver : all_drivers()) {
    KeyTable table = table_of("[device.NAME]", driver.name, [&](DeviceKeys& keys) { return driver.read(keys, none); });
    table.measures = driver.measures;
    for (const std::string_view thing : measured_by(driver)) table.readers.push_back(reader_of(thing));
    all.push_back(std::move(table));
  }
  for (const std::string_view transport : can_transports())
    all.push_back(table_of("[bus.NAME]", transport, [](DeviceKeys& keys) { return read_can_bus(keys); }));
  all.push_back(table_of("[bus.NAME]", kSerialBus, [](DeviceKeys& keys) { return read_serial_bus(keys); }));
  for (const std::string_view protocol : joint_protocols())
    all.push_back(
        table_of("[[device.NAME.joint]]", protocol, [&](DeviceKeys& keys) { return read_joint(keys, none); }));
  for (const auto& [table, read] : text_tables()) all.push_back(table_of(table, "text", read));
  return all;
}

bool gives(const DriverKind& driver, std::string_view what) {
  const auto things = measured_by(driver);
  return std::find(things.begin(), things.end(), what) != things.end();
}

}  // namespace sinew::drivers
