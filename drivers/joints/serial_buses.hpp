#pragma once
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/device_keys.hpp"
#include "drivers/joints/serial_hub.hpp"
#include "hal/connectors.hpp"

namespace sinew::drivers {

/// [bus.NAME] with driver = "serial": a half-duplex line with servos, and how its hub runs.
struct SerialBusConfig {
  hal::SerialSpec spec;
  SerialHubConfig hub;
};
inline constexpr std::string_view kSerialBus = "serial";
SerialBusConfig read_serial_bus(DeviceKeys& keys);
/// tick_hz of a bus of any kind. Its table has no problems.
double bus_tick_hz(const DeviceSpec& bus);

/// The lines of one board with their hubs. A line is opened with its first joint; all start together when all joints
/// are there. Thread:  owner, configure only. hold(): as CanBuses::hold().
class SerialBuses {
 public:
  SerialBuses(const DeviceSpecs& specs, hal::Connectors& connectors, hal::Os& os)
      : specs_(specs), connectors_(connectors), os_(os) {}
  ~SerialBuses();

  struct Bus {
    std::unique_ptr<SerialHub> hub;
    bool started = false;
  };
  /// Errors: those of opening; not_found when there is no such table. `why` has it in words.
  hal::Result<Bus*> open(const std::string& name, std::string& why);
  void hold(std::shared_ptr<void> owner) { held_.push_back(std::move(owner)); }
  /// Errors: bad_argument (more than a line holds, a number twice), and those of starting a thread.
  hal::Status start(std::string& why);

  /// What opening a line warned of although it opened, one a line, e.g. the latency of its adapter.
  const std::vector<std::string>& warnings() const { return warnings_; }
  /// What is wrong with the lines now, one a line. Thread: any, from start() on.
  std::vector<std::string> complaints() const;
  /// What the threads of the lines asked for and did not get, one a line. From start() on.
  std::vector<std::string> shortfalls() const;

 private:
  const DeviceSpecs& specs_;
  hal::Connectors& connectors_;
  hal::Os& os_;
  std::vector<std::shared_ptr<void>> held_;  // outlive the hubs
  std::map<std::string, Bus> opened_;
  std::vector<std::string> warnings_;
};

}  // namespace sinew::drivers
