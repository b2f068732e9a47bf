#pragma once
// The control tables of serial servos as data: where a register is, and what one count of it is worth.
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "wire/servos/dynamixel.hpp"

namespace sinew::wire {

/// Numbers in a control table: two's complement, or a magnitude with a sign bit (bit `sign_bit`, 0: two's complement).
struct ServoRegister {
  std::uint16_t address = 0;
  std::uint8_t size = 0;  // bytes, 1 to 4; 0: the servo has no such register
  std::uint8_t sign_bit = 0;

  explicit operator bool() const { return size != 0; }
};

enum class ServoMaker : std::uint8_t { robotis, feetech };

/// What a fault bit of a servo means: msg::JointFault.
struct ServoFaultBit {
  std::uint8_t bit = 0;
  std::uint32_t faults = 0;
};

/// A bit rate, and what its register holds for it.
struct ServoRate {
  std::uint32_t bit_rate = 0;
  std::uint8_t code = 0;
};

/// One model. Angles are the output shaft's; counts go up counter-clockwise, seen at the horn.
struct ServoModel {
  std::string_view name;     // "xm430_w350", as a robot file has it
  std::string_view title;    // "XM430-W350"
  std::string_view source;   // the page of its table
  std::uint16_t number = 0;  // its Model Number register
  DxlVersion version{};      // of its packets
  ServoMaker maker{};
  bool big_endian = false;  // numbers of more than a byte: Feetech's SCS
  bool sync_read = false, fast_read = false, bulk_read = false;

  ServoRegister model_number{}, firmware{}, id{}, bit_rate{}, return_delay{}, operating_mode{}, status_return{}, lock{};
  ServoRegister torque_enable{}, hardware_error{}, bus_watchdog{};
  ServoRegister goal_effort{}, goal_velocity{}, goal_position{}, effort_limit{};
  ServoRegister present_effort{}, present_velocity{}, present_position{}, present_voltage{}, present_temperature{};

  std::span<const ServoRate> rates{};

  double counts_per_turn = 4096;
  std::int32_t centre = 2048;           // the count in the middle of its range: 0 rad
  std::int32_t least = 0, most = 4095;  // of a goal position
  double radps_per_count = 0;           // of velocities
  /// Of present_effort. From current and the stall torque and current of the maker's table, or from the share of the
  /// stall torque: a rough figure, without friction.
  double nm_per_count = 0;
  double most_nm = 0, most_radps = 0;  // stall torque and no-load speed, at the voltage of the maker's first figure
  double volts_per_count = 0.1;
  double seconds_per_delay = 2e-6;                                     // of return_delay
  double seconds_per_watchdog = 0.02;                                  // of bus_watchdog, at most 127
  std::uint8_t position_mode = 3, velocity_mode = 1, effort_mode = 0;  // of operating_mode
  bool has_effort_mode = false;
  std::span<const ServoFaultBit> faults{};  // of hardware_error; without that register of the error byte

  /// The registers that are read in each cycle: from the first to the last byte of effort, velocity and position.
  ServoRegister cycle() const noexcept;
  /// The unit of a position, rad.
  double rad_per_count() const noexcept { return 6.283185307179586 / counts_per_turn; }
};

std::span<const ServoModel> servo_models();
/// Null: none of that name, or number.
const ServoModel* servo_model(std::string_view name);
const ServoModel* servo_model(DxlVersion version, std::uint16_t number);

/// The register's number in `table`, which begins at address `first`. Nothing: it does not lie within.
/// RT: yes.
std::optional<std::int32_t> servo_number(const ServoModel& model, const ServoRegister& reg, std::uint16_t first,
                                         std::span<const std::uint8_t> table) noexcept;
/// Writes `value` into the register's place of `table`; values that the register cannot hold are pulled in. False: it
/// does not lie within.
bool put_servo_number(const ServoModel& model, const ServoRegister& reg, std::uint16_t first, std::int32_t value,
                      std::span<std::uint8_t> table) noexcept;
/// The same as up to four bytes.
struct ServoBytes {
  std::array<std::uint8_t, 4> data{};
  std::size_t size = 0;
  operator std::span<const std::uint8_t>() const { return {data.data(), size}; }
};
ServoBytes servo_bytes(const ServoModel& model, const ServoRegister& reg, std::int32_t value) noexcept;

/// What goes into the register bit_rate for this bit rate. Nothing: the model cannot do it.
std::optional<std::uint8_t> servo_rate_code(const ServoModel& model, std::uint32_t bit_rate) noexcept;
/// "9600, 57600, ...".
std::string servo_rates_text(const ServoModel& model);

/// The msg::JointFault bits of a servo's error byte or register.
std::uint32_t servo_faults(const ServoModel& model, std::uint8_t bits) noexcept;
/// The other way round: the bits that say any of these faults.
std::uint8_t servo_fault_bits(const ServoModel& model, std::uint32_t faults) noexcept;

}  // namespace sinew::wire
