#pragma once
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "hal/can_bus.hpp"
#include "sim_hil/plant/wire_line.hpp"
#include "sim_hil/wire/iio_tree.hpp"
#include "sim_hil/wire/sim_servo.hpp"
#include "sim_hil/worlds/world.hpp"

namespace sinew::plant {

/// The drive of one joint: "cia402:1", "mit:2:ak80_9" (with the type of the motor), "cybergear:3", "dronecan:20" (an
/// actuator; its actuator_id is its place among the joints). The number is its node id on the bus. "xm430_w350:1",
/// "sts3215:3:2": a servo on a serial line, by its model, id, and the line's place among them (1 where it is left out).
/// "@0.2" at the end: the drive reads 0.2 rad more than the joint's position. "none": nothing drives this joint.
struct WireServo {
  enum class Protocol : std::uint8_t { cia402, mit, cybergear, dronecan, serial, none } protocol = Protocol::cia402;
  std::uint32_t id = 1;
  std::string motor;                        // mit
  const wire::ServoModel* model = nullptr;  // serial
  std::size_t line = 0;                     // serial
  double zero_rad = 0;

  bool has_drive() const { return protocol != Protocol::none; }
  bool on_line() const { return protocol == Protocol::serial; }
  /// Both on one bus, or on one line.
  bool shares_bus(const WireServo& other) const {
    return has_drive() && other.has_drive() && on_line() == other.on_line() && line == other.line;
  }
};
/// Whether drives at the wire can have such a fault: off (without power), stuck, garbage.
bool plays(FaultKind kind);
/// Nothing: `why` says what is allowed.
std::optional<WireServo> parse_wire_servo(const std::string& text, std::string& why);

/// Takes the pictures of the world's camera for a robot that has it behind a real driver.
/// Thread:  one; set_plugged() any.   RT: yes.
class WireCamera {
 public:
  virtual ~WireCamera() = default;
  /// Where the next picture is drawn or copied to, in the feed's format and size; until deliver().
  virtual std::span<std::uint8_t> canvas() noexcept = 0;
  /// Frame `number` of the sensor, exposed around `middle` of the host's clock.
  virtual void deliver(hal::Time middle, std::uint32_t number) noexcept = 0;
  virtual void set_plugged(bool plugged) noexcept = 0;
};

/// Parts of a world at the wire, besides its protocol to the runtime: drives on a CAN bus that move its joints, an IMU
/// as the kernel's IIO would show it, a camera as its V4L2 would. The robot reaches them with its real drivers. In real
/// time only.
/// Thread:  one: the world's owner.
class WireDevices {
 public:
  WireDevices();
  ~WireDevices();
  /// `servos`: of the joints in their order; joints without a drive follow the group's command. `bus`: null when none
  /// of them is on CAN.
  void add_servos(std::unique_ptr<hal::CanBus> bus, std::vector<WireServo> servos);
  /// The next serial line.
  void add_line(std::unique_ptr<WireLine> line) { lines_.push_back(std::move(line)); }
  void add_imu(std::unique_ptr<sim_hil::IioTree> tree) { imu_ = std::move(tree); }

  void add_camera(std::unique_ptr<WireCamera> camera) { camera_ = std::move(camera); }
  /// The IMU's rates are off by so much, besides the world's own errors.
  void add_gyro_bias(const msg::Vec3& radps) { gyro_bias_radps_ = radps; }
  /// The camera driver's stamps are late by so much.
  void delay_stamps(hal::Duration late) { late_ = late; }
  hal::Duration stamps_late() const { return late_; }
  /// Unplugs the camera from one moment of plant time to another.
  void unplug_camera(hal::Time from, hal::Time until) { out_from_ = from, out_until_ = until; }
  /// Faults that the drives of all joints play alike; kinds that plays() knows.
  void add_faults(const std::vector<Fault>& faults);
  /// These faults, and how many drives each has struck so far.
  const std::vector<FaultLog::Entry>& faults() const { return faults_; }
  /// Keeps what its buses and lines need alive.
  void keep(std::shared_ptr<void> kept) { kept_.push_back(std::move(kept)); }

  /// Makes the drives on this world's joints, and starts the lines. Errors: bad_argument when it has none, or fewer
  /// than drives; those of starting a thread.
  hal::Status attach(World& world);
  /// After each step of the world, at `now` of the host's clock.
  void step(const World& world, const Due& due, hal::Time now);
  bool has_servos() const { return !servos_.empty(); }
  /// Null: the camera is not at the wire.
  WireCamera* camera() { return camera_.get(); }

 private:
  class Joint;
  void play_faults(hal::Time plant_now);
  std::vector<std::shared_ptr<void>> kept_;
  std::unique_ptr<hal::CanBus> bus_;
  std::vector<WireServo> servos_;
  std::vector<std::unique_ptr<Joint>> joints_;
  std::vector<std::unique_ptr<WireLine>> lines_;
  std::unique_ptr<sim_hil::SimServos> sims_;
  std::vector<sim_hil::SimDrive*> drives_;
  std::vector<FaultLog::Entry> faults_;
  std::unique_ptr<sim_hil::IioTree> imu_;
  std::unique_ptr<WireCamera> camera_;
  hal::Time out_from_ = hal::kNever, out_until_ = hal::kNever;
  bool plugged_ = true;
  hal::Duration late_{0};
  msg::Vec3 gyro_bias_radps_;
};

}  // namespace sinew::plant
