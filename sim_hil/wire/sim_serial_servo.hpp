#pragma once
// Dynamixel and Feetech servos as they are on their half-duplex line, with the same codec as the drivers.
#include <array>
#include <optional>

#include "sim_hil/wire/sim_serial_line.hpp"
#include "sim_hil/wire/sim_servo.hpp"
#include "wire/servos/servo_models.hpp"

namespace sinew::sim_hil {

/// One servo: its control table, its loop, and its answers with its return delay. A servo that answers after another
/// one (sync, bulk and fast reads) waits for the other's answer to end; when that does not come, it is silent, and so
/// are all behind it. Worse than real ones where the manual leaves it open: after a reboot the goal registers hold what
/// they held before, so torque without a new goal moves the joint. Thread:  the line's.
class SimSerialServo final : public SimDrive, public SimLineDevice {
 public:
  struct Parameters {
    std::uint8_t id = 1;
    const wire::ServoModel* model = nullptr;
    double kp = 8, kd = 0.5;  // of its loop, N m/rad and N m s/rad at the output shaft
    std::uint8_t return_delay = 250;
    Duration boot{std::chrono::milliseconds(350)};  // after a reboot it is deaf for so long
  };
  SimSerialServo(SimSerialLine& line, SimJoint& joint, const SimMount& mount, const Parameters& parameters);

  void hear(std::uint8_t byte, Time now) override;
  void advance(Time now) override { SimDrive::advance(now); }
  /// Its Hardware Error Status, or the error bits of 1.0; 0: the cause is gone. 2.0 forgets it in a reboot alone.
  void fail(std::uint32_t code) override;
  bool faulty() const { return error_bits_ != 0; }
  bool live() const override { return live_; }
  /// As by the instruction, or by a moment without power: no torque, deaf for Parameters::boot.
  void reboot(Time now);

  /// A register as it is now.
  std::int32_t number(const wire::ServoRegister& reg) const;
  void set_number(const wire::ServoRegister& reg, std::int32_t value);
  std::uint64_t reboots() const { return reboots_; }
  std::uint64_t instructions() const { return instructions_; }  // to it, alone or with others

 protected:
  void on_power() override;
  double control(Time now, Duration dt) override;
  void say(Time now) override;

 private:
  using Data = std::span<const std::uint8_t>;
  void on_packet(const wire::DxlPacket& packet, Time now);
  void on_instruction(const wire::DxlPacket& packet, Time now);
  void on_sync_read(const wire::DxlPacket& packet, Time now, bool fast);
  void on_bulk_read(const wire::DxlPacket& packet, Time now, bool fast);
  void on_sync_write(const wire::DxlPacket& packet, Time now);
  void on_bulk_write(const wire::DxlPacket& packet, Time now);
  std::uint8_t write(std::uint16_t address, Data data, Time now);
  void read(std::uint16_t address, std::uint16_t size, Time now);
  void answer_in_turn(std::size_t index, std::uint8_t predecessor, std::uint16_t address, std::uint16_t size, Time now);
  void answer_in_one(std::size_t index, std::size_t servos, std::size_t before, std::size_t length,
                     std::uint16_t address, std::uint16_t size, Time now);
  void send_part(Time now);
  void status(std::uint8_t error, Data data, Time now);
  void transmit(Data bytes, Time at);
  void measure();
  void reset_ram();
  Data table(std::uint16_t address, std::uint16_t size) const;
  bool is_goal(std::uint16_t address, std::size_t size) const;
  std::uint16_t ram_begin() const;
  std::uint8_t id() const { return static_cast<std::uint8_t>(number(p_.model->id)); }
  Duration delay() const;

  SimSerialLine& line_;
  Parameters p_;
  wire::DxlReader reader_;
  std::array<std::uint8_t, 256> table_{};
  bool live_ = false;
  std::uint8_t error_bits_ = 0;
  Time heard_{}, instructed_{}, boots_until_{};
  std::uint64_t reboots_ = 0, instructions_ = 0;
  struct Turn {  // its answer comes behind this servo's
    std::uint8_t predecessor = 0;
    std::uint16_t address = 0, size = 0;
  };
  std::optional<Turn> turn_;
  struct Part {  // of the one answer to a fast read
    std::size_t before = 0;
    std::uint16_t crc = 0, address = 0, size = 0;
    bool last = false;
  };
  std::optional<Part> part_;
  struct Registered {
    std::uint16_t address = 0;
    std::array<std::uint8_t, 64> data{};
    std::size_t size = 0;
  };
  std::optional<Registered> registered_;
};

}  // namespace sinew::sim_hil
