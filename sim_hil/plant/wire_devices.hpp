#pragma once
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "hal/can_bus.hpp"
#include "sim_hil/plant/world.hpp"
#include "sim_hil/wire/iio_tree.hpp"
#include "sim_hil/wire/sim_servo.hpp"

namespace sinew::plant {

/// The drive of one joint: "cia402:1", "mit:2:ak80_9" (with the type of the motor), "cybergear:3", "dronecan:20" (an
/// actuator; its actuator_id is its place among the joints). The number is its node id on the bus.
struct WireServo {
  enum class Protocol : std::uint8_t { cia402, mit, cybergear, dronecan } protocol = Protocol::cia402;
  std::uint32_t id = 1;
  std::string motor;  // mit
};
/// Nothing: `why` says what is allowed.
std::optional<WireServo> parse_wire_servo(const std::string& text, std::string& why);

/// Parts of a world at the wire, besides its protocol to the runtime: drives on a CAN bus that move its joints, and an
/// IMU as the kernel's IIO would show it. The robot reaches them with its real drivers. In real time only.
/// Thread:  one: the world's owner.
class WireDevices {
 public:
  WireDevices();
  ~WireDevices();
  /// `servos`: of the joints in their order; fewer leave the others to the group's command.
  void add_servos(std::unique_ptr<hal::CanBus> bus, std::vector<WireServo> servos);
  void add_imu(std::unique_ptr<sim_hil::IioTree> tree) { imu_ = std::move(tree); }

  /// What the bus needs to be there.
  void keep(std::shared_ptr<void> server) { kept_ = std::move(server); }

  /// Makes the drives on this world's joints. Errors: bad_argument when it has none, or fewer than drives.
  hal::Status attach(World& world);
  /// After each step of the world, at `now` of the host's clock.
  void step(const World& world, const Due& due, hal::Time now);
  bool has_servos() const { return !servos_.empty(); }

 private:
  class Joint;
  std::shared_ptr<void> kept_;
  std::unique_ptr<hal::CanBus> bus_;
  std::vector<WireServo> servos_;
  std::vector<std::unique_ptr<Joint>> joints_;
  std::unique_ptr<sim_hil::SimServos> sims_;
  std::unique_ptr<sim_hil::IioTree> imu_;
};

}  // namespace sinew::plant
