#pragma once
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/device_keys.hpp"
#include "drivers/joints/can_hub.hpp"
#include "drivers/joints/dronecan_node.hpp"
#include "hal/connectors.hpp"

namespace sinew::drivers {

/// [bus.NAME]: a CAN bus and how its hub runs.
struct CanBusConfig {
  hal::CanSpec spec;
  CanHubConfig hub;
  std::uint32_t master_node = 126;  // CANopen: our own node id
  hal::Duration master_heartbeat{std::chrono::milliseconds(10)};
  DronecanNodeConfig dronecan;  // our node there
};
/// What a bus's `driver` may be: socketcan, udp, socketcand.
std::span<const std::string_view> can_transports();
CanBusConfig read_can_bus(DeviceKeys& keys);

/// The bus that a servo is made for, open or only planned, and the services that its servos share.
struct BusPlace {
  CanBusConfig config;
  bool has_canopen_master = false;
  DronecanNode* dronecan = nullptr;  // one of the added services; null: no servo needs it
  std::function<void(std::unique_ptr<BusService>)> add;
};

/// The CAN buses of one board with their hubs. A bus is opened with its first joint; all start together when all joints
/// are there.
/// Thread:  owner, configure only. hold() keeps the groups that the hubs serve (ServoGroup) alive until the hubs are
///          gone.
class CanBuses {
 public:
  CanBuses(const DeviceSpecs& specs, hal::Connectors& connectors, hal::Os& os);
  ~CanBuses();

  struct Bus : BusPlace {
    std::unique_ptr<hal::CanBus> bus;
    std::unique_ptr<CanHub> hub;
    bool started = false;
  };
  /// Errors: those of opening; not_found when there is no such table. `why` has it in words.
  hal::Result<Bus*> open(const std::string& name, std::string& why);
  void hold(std::shared_ptr<void> owner) { held_.push_back(std::move(owner)); }
  /// Plans the load of every bus and starts its thread. Errors: bad_argument (more than a bus carries, a number twice),
  /// and those of starting a thread.
  hal::Status start(std::string& why);

  const std::map<std::string, Bus>& opened() const { return opened_; }
  /// What opening a bus warned of although it opened, one a line, e.g. that its interface is down.
  const std::vector<std::string>& warnings() const { return warnings_; }
  /// What is wrong with the buses now, one a line. Thread: any, from start() on.
  std::vector<std::string> complaints() const;
  /// What the threads of the buses asked for and did not get, one a line. From start() on.
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
