#pragma once
#include <map>
#include <string>

#include "sim_hil/wire/sim_servo.hpp"
#include "wire/cia402.hpp"

namespace sinew::sim_hil {

/// A CiA 402 drive on CANopen: an object dictionary behind an SDO server, mappable PDOs on SYNC, heartbeat both ways,
/// EMCY, the state machine, cyclic synchronous position, velocity and torque, quick stop, homing.
/// Its motor temperature is object 2300h:1, tenths of a degree, 16 bits with sign.
class SimCia402 final : public SimServo {
 public:
  struct Parameters {
    std::uint32_t node_id = 1;
    std::uint32_t vendor = 0x51, product = 0x402, revision = 1, serial = 1001;
    std::string name = "Simulated drive 402";  // longer than a frame: it comes in segments
    double counts_per_turn = 65536, rated_nm = 2;
    double kp = 200, kd = 4;                   // of its position loop, drive side
    double hot_c = 100;                        // over-temperature
    double home_rad = 0;                       // where its switch is, drive side
    std::vector<wire::ObjectAddress> refuses;  // objects that it says it does not have
  };
  SimCia402(hal::CanBus& bus, SimJoint& joint, const SimMount& mount, const Parameters& parameters);

  void fail(std::uint32_t code) override;
  bool live() const override { return state_ == wire::DriveState::operation_enabled || quick_; }
  wire::DriveState state() const { return state_; }
  wire::NmtState nmt() const { return nmt_; }
  /// The value of an object, for tests.
  std::uint32_t object(wire::ObjectAddress object) const;
  /// The cause of a fault stays: a reset is followed by the same fault.
  bool fault_stays = false;
  /// Ignores controlwords.
  bool deaf = false;

 protected:
  void on_frame(const msg::CanFrame& frame, Time now) override;
  void on_power() override;
  double control(Time now, Duration dt) override;
  void say(Time now) override;

 private:
  static constexpr wire::ObjectAddress kTemperature{0x2300, 1};
  struct Value {
    std::uint32_t value = 0;
    std::uint8_t bytes = 4;
    bool writable = false;
  };
  void add(wire::ObjectAddress object, std::uint32_t value, std::uint8_t bytes, bool writable = false);
  void set(wire::ObjectAddress object, std::uint32_t value) { objects_[key(object)].value = value; }
  static std::uint32_t key(wire::ObjectAddress o) { return std::uint32_t{o.index} << 8 | o.sub; }

  void measure();
  void on_nmt(const wire::Nmt& nmt);
  void on_sdo(const wire::Sdo& request);
  void send_name(const wire::Sdo& request);
  std::uint32_t write(const wire::Sdo& request);  // the abort code; 0: written
  void on_rpdo(const msg::CanFrame& frame, std::uint32_t number);
  void send_tpdo(std::uint32_t number);
  void on_sync();
  void on_controlword();
  void enter_fault(std::uint16_t code);
  void watch_master(Time now);
  void lose_connection();
  double position_target() const;
  double home(Time now);

  Parameters p_;
  std::map<std::uint32_t, Value> objects_;
  wire::NmtState nmt_ = wire::NmtState::boot_up;
  wire::DriveState state_ = wire::DriveState::switch_on_disabled;
  bool quick_ = false, homing_ = false;
  std::uint16_t control_before_ = 0, extra_status_ = 0;
  double zero_ = 0;  // drive position where it reads 0
  std::uint32_t stays_code_ = 0;
  Time next_heartbeat_{}, master_heard_{}, now_{};
  bool master_watched_ = false;
  std::uint32_t syncs_ = 0;
  std::size_t name_at_ = 0;
  bool name_toggle_ = false;
};

}  // namespace sinew::sim_hil
