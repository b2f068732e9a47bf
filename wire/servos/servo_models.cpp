#include "wire/servos/servo_models.hpp"

#include <algorithm>
#include <array>

#include "msg/joints.hpp"

namespace sinew::wire {
namespace {

constexpr double kRadpsPerRpm = 0.10471975511965977;

// "Hardware Error Status(70)", "Shutdown(63)" of the X series.
constexpr std::array<ServoFaultBit, 5> kXFaults{{{0, msg::kJointUnderVoltage | msg::kJointOverVoltage},
                                                 {2, msg::kJointOverTemperature},
                                                 {3, msg::kJointEncoder},
                                                 {4, msg::kJointOther},
                                                 {5, msg::kJointOverload}}};
// The error byte of protocol 1.0. Angle limit, range, checksum and instruction are errors of a packet, not the servo's.
constexpr std::array<ServoFaultBit, 3> kOneFaults{
    {{0, msg::kJointUnderVoltage | msg::kJointOverVoltage}, {2, msg::kJointOverTemperature}, {5, msg::kJointOverload}}};
// Feetech's status: voltage, sensor, temperature, current, (angle), overload.
constexpr std::array<ServoFaultBit, 5> kFeetechFaults{{{0, msg::kJointUnderVoltage | msg::kJointOverVoltage},
                                                       {1, msg::kJointEncoder},
                                                       {2, msg::kJointOverTemperature},
                                                       {3, msg::kJointOverCurrent},
                                                       {5, msg::kJointOverload}}};

// "Baud Rate(8)" of the X series.
constexpr std::array<ServoRate, 8> kXRates{{{9'600, 0},
                                            {57'600, 1},
                                            {115'200, 2},
                                            {1'000'000, 3},
                                            {2'000'000, 4},
                                            {3'000'000, 5},
                                            {4'000'000, 6},
                                            {4'500'000, 7}}};
// "Baud Rate (4)" of MX and AX with protocol 1.0: 2000000 / (code + 1), near enough.
constexpr std::array<ServoRate, 9> kOneRates{{{9'600, 207},
                                              {19'200, 103},
                                              {57'600, 34},
                                              {115'200, 16},
                                              {200'000, 9},
                                              {250'000, 7},
                                              {400'000, 4},
                                              {500'000, 3},
                                              {1'000'000, 1}}};
constexpr std::array<ServoRate, 8> kFeetechRates{
    {{38'400, 7}, {57'600, 6}, {76'800, 5}, {115'200, 4}, {128'000, 3}, {250'000, 2}, {500'000, 1}, {1'000'000, 0}}};

constexpr ServoModel x_series() {
  ServoModel m;
  m.version = DxlVersion::two;
  m.maker = ServoMaker::robotis;
  m.sync_read = m.fast_read = m.bulk_read = true;
  m.model_number = {0, 2}, m.firmware = {6, 1}, m.id = {7, 1}, m.bit_rate = {8, 1}, m.return_delay = {9, 1};
  m.operating_mode = {11, 1}, m.status_return = {68, 1};
  m.torque_enable = {64, 1}, m.hardware_error = {70, 1}, m.bus_watchdog = {98, 1};
  m.goal_velocity = {104, 4}, m.goal_position = {116, 4};
  m.present_effort = {126, 2}, m.present_velocity = {128, 4}, m.present_position = {132, 4};
  m.present_voltage = {144, 2}, m.present_temperature = {146, 1};
  m.radps_per_count = 0.229 * kRadpsPerRpm;
  m.faults = kXFaults;
  m.rates = kXRates;
  return m;
}

/// Current in steps of 2.69 mA.
constexpr ServoModel xm430(std::string_view name, std::string_view title, std::string_view source, std::uint16_t number,
                           double stall_nm, double stall_a, double rpm) {
  ServoModel m = x_series();
  m.name = name, m.title = title, m.source = source, m.number = number;
  m.goal_effort = {102, 2}, m.effort_limit = {38, 2};
  m.has_effort_mode = true;
  m.nm_per_count = 2.69e-3 * stall_nm / stall_a;
  m.most_nm = stall_nm, m.most_radps = rpm * kRadpsPerRpm;
  return m;
}

/// No current is measured: the load is a share of the most torque, 0.1 % a count.
constexpr ServoModel xl430() {
  ServoModel m = x_series();
  m.name = "xl430_w250", m.title = "XL430-W250", m.number = 1060;
  m.source = "https://emanual.robotis.com/docs/en/dxl/x/xl430-w250/";
  m.nm_per_count = 1e-3 * 1.4;
  m.most_nm = 1.4, m.most_radps = 57 * kRadpsPerRpm;  // at 11.1 V
  return m;
}

/// Protocol 1.0: magnitudes with the direction in bit 10, set: clockwise.
constexpr ServoModel one_series(double stall_nm, double rpm) {
  ServoModel m;
  m.version = DxlVersion::one;
  m.maker = ServoMaker::robotis;
  m.model_number = {0, 2}, m.firmware = {2, 1}, m.id = {3, 1}, m.bit_rate = {4, 1}, m.return_delay = {5, 1},
  m.status_return = {16, 1};
  m.torque_enable = {24, 1}, m.lock = {47, 1};
  m.goal_position = {30, 2}, m.goal_velocity = {32, 2, 10}, m.effort_limit = {34, 2};
  m.present_position = {36, 2}, m.present_velocity = {38, 2, 10}, m.present_effort = {40, 2, 10};
  m.present_voltage = {42, 1}, m.present_temperature = {43, 1};
  m.nm_per_count = 1e-3 * stall_nm;
  m.most_nm = stall_nm, m.most_radps = rpm * kRadpsPerRpm;
  m.faults = kOneFaults;
  m.rates = kOneRates;
  return m;
}

constexpr ServoModel mx28() {
  ServoModel m = one_series(2.5, 55);  // at 12 V
  m.name = "mx28", m.title = "MX-28 (protocol 1.0)", m.number = 29;
  m.source = "https://emanual.robotis.com/docs/en/dxl/mx/mx-28/";
  m.bulk_read = true;
  m.radps_per_count = 0.114 * kRadpsPerRpm;
  return m;
}

constexpr ServoModel ax12() {
  ServoModel m = one_series(1.5, 59);  // at 12 V
  m.name = "ax12", m.title = "AX-12A", m.number = 12;
  m.source = "https://emanual.robotis.com/docs/en/dxl/ax/ax-12a/";
  m.counts_per_turn = 1024 * 360 / 300.0;  // 1024 counts are 300 degrees
  m.centre = 512, m.most = 1023;
  m.radps_per_count = 0.111 * kRadpsPerRpm;
  return m;
}

constexpr ServoModel feetech(double stall_nm, double rpm) {
  ServoModel m;
  m.version = DxlVersion::one;
  m.maker = ServoMaker::feetech;
  m.model_number = {3, 2}, m.firmware = {0, 2}, m.id = {5, 1}, m.bit_rate = {6, 1}, m.return_delay = {7, 1},
  m.status_return = {8, 1};
  m.torque_enable = {40, 1}, m.hardware_error = {65, 1};
  m.present_voltage = {62, 1}, m.present_temperature = {63, 1};
  m.nm_per_count = 1e-3 * stall_nm;
  m.most_nm = stall_nm, m.most_radps = rpm * kRadpsPerRpm;
  m.faults = kFeetechFaults;
  m.rates = kFeetechRates;
  return m;
}

constexpr ServoModel sts3215() {
  // 19.5 kg cm and 0.192 s for 60 degrees at 7.4 V (DFRobot SER0069, "ST3215"). The 12 V variant of this name: 30 kg
  // cm.
  ServoModel m = feetech(19.5 * 0.0980665, 52);
  m.name = "sts3215", m.title = "STS3215", m.number = 777;
  m.source = "Feetech, memory table of magnetic encoder servos (SMS/STS), and SMS_STS.h of its SCServo library";
  m.sync_read = true;
  m.operating_mode = {33, 1}, m.lock = {55, 1}, m.effort_limit = {48, 2};
  m.position_mode = 0, m.velocity_mode = 1;
  m.goal_position = {42, 2, 15}, m.goal_velocity = {46, 2, 15};
  m.present_position = {56, 2, 15}, m.present_velocity = {58, 2, 15}, m.present_effort = {60, 2, 10};
  m.radps_per_count = 6.283185307179586 / 4096;  // steps a second
  return m;
}

constexpr ServoModel scs0009() {
  // 2.3 kg cm and 0.1 s for 60 degrees at 6 V: a seller's figures, for which no page of the maker was found.
  ServoModel m = feetech(2.3 * 0.0980665, 100);
  m.name = "scs0009", m.title = "SCS0009", m.number = 1284;
  m.source = "Feetech, memory table of SCS servos, and SCSCL.h of its SCServo library";
  m.big_endian = true;
  m.lock = {48, 1};
  m.goal_position = {42, 2}, m.goal_velocity = {46, 2};
  m.present_position = {56, 2}, m.present_velocity = {58, 2, 15}, m.present_effort = {60, 2, 10};
  m.counts_per_turn = 1024 * 360 / 300.0;  // 1024 counts are 300 degrees
  m.centre = 512, m.most = 1023;
  m.radps_per_count = 6.283185307179586 / m.counts_per_turn;  // steps a second
  return m;
}

constexpr std::array<ServoModel, 7> kServoModels{
    xm430("xm430_w350", "XM430-W350", "https://emanual.robotis.com/docs/en/dxl/x/xm430-w350/", 1020, 3.8, 2.1, 43),
    xm430("xm430_w210", "XM430-W210", "https://emanual.robotis.com/docs/en/dxl/x/xm430-w210/", 1030, 2.7, 2.1, 70),
    xl430(),
    mx28(),
    ax12(),
    sts3215(),
    scs0009()};

bool lies_within(const ServoRegister& reg, std::uint16_t first, std::size_t size) {
  return reg && reg.address >= first && static_cast<std::size_t>(reg.address - first) + reg.size <= size;
}

}  // namespace

ServoRegister ServoModel::cycle() const noexcept {
  std::uint16_t first = 0xFFFF, end = 0;
  for (const ServoRegister& r : {present_effort, present_velocity, present_position}) {
    if (!r) continue;
    first = std::min(first, r.address);
    end = std::max(end, static_cast<std::uint16_t>(r.address + r.size));
  }
  return {first, static_cast<std::uint8_t>(end - first), 0};
}

std::span<const ServoModel> servo_models() { return kServoModels; }

const ServoModel* servo_model(std::string_view name) {
  for (const ServoModel& m : kServoModels)
    if (m.name == name) return &m;
  return nullptr;
}

const ServoModel* servo_model(DxlVersion version, std::uint16_t number) {
  for (const ServoModel& m : kServoModels)
    if (m.version == version && m.number == number) return &m;
  return nullptr;
}

std::optional<std::int32_t> servo_number(const ServoModel& model, const ServoRegister& reg, std::uint16_t first,
                                         std::span<const std::uint8_t> table) noexcept {
  if (!lies_within(reg, first, table.size())) return std::nullopt;
  const std::size_t at = static_cast<std::size_t>(reg.address - first);
  std::uint32_t raw = 0;
  for (std::size_t i = 0; i < reg.size; ++i) {
    const std::size_t k = model.big_endian ? i : reg.size - 1u - i;
    raw = raw << 8 | table[at + k];
  }
  if (reg.sign_bit != 0) {
    const std::uint32_t sign = 1u << reg.sign_bit;
    const auto magnitude = static_cast<std::int32_t>(raw & (sign - 1));
    return (raw & sign) != 0 ? -magnitude : magnitude;
  }
  if (reg.size == 1) return static_cast<std::int32_t>(raw);  // none of them is negative
  if (reg.size == 2 && model.version == DxlVersion::two) return static_cast<std::int16_t>(raw);
  return static_cast<std::int32_t>(raw);
}

bool put_servo_number(const ServoModel& model, const ServoRegister& reg, std::uint16_t first, std::int32_t value,
                      std::span<std::uint8_t> table) noexcept {
  if (!lies_within(reg, first, table.size())) return false;
  std::uint32_t raw = 0;
  if (reg.sign_bit != 0) {
    const std::int32_t most = (1 << reg.sign_bit) - 1;
    const std::int32_t pulled = std::clamp(value, -most, most);
    raw = pulled < 0 ? static_cast<std::uint32_t>(-pulled) | 1u << reg.sign_bit : static_cast<std::uint32_t>(pulled);
  } else if (reg.size == 1) {
    raw = static_cast<std::uint32_t>(std::clamp(value, 0, 0xFF));
  } else if (reg.size == 2) {
    const bool is_signed = model.version == DxlVersion::two;
    raw = static_cast<std::uint32_t>(std::clamp(value, is_signed ? -0x8000 : 0, is_signed ? 0x7FFF : 0xFFFF));
  } else {
    raw = static_cast<std::uint32_t>(value);
  }
  const std::size_t at = static_cast<std::size_t>(reg.address - first);
  for (std::size_t i = 0; i < reg.size; ++i) {
    const std::size_t k = model.big_endian ? reg.size - 1u - i : i;
    table[at + k] = static_cast<std::uint8_t>(raw >> (8 * i));
  }
  return true;
}

ServoBytes servo_bytes(const ServoModel& model, const ServoRegister& reg, std::int32_t value) noexcept {
  ServoBytes bytes;
  bytes.size = reg.size;
  put_servo_number(model, reg, reg.address, value, {bytes.data.data(), bytes.size});
  return bytes;
}

std::optional<std::uint8_t> servo_rate_code(const ServoModel& model, std::uint32_t bit_rate) noexcept {
  for (const ServoRate& rate : model.rates)
    if (rate.bit_rate == bit_rate) return rate.code;
  return std::nullopt;
}

std::string servo_rates_text(const ServoModel& model) {
  std::string all;
  for (const ServoRate& rate : model.rates) all += (all.empty() ? "" : ", ") + std::to_string(rate.bit_rate);
  return all;
}

std::uint32_t servo_faults(const ServoModel& model, std::uint8_t bits) noexcept {
  std::uint32_t faults = 0;
  for (const ServoFaultBit& f : model.faults)
    if ((bits >> f.bit & 1) != 0) faults |= f.faults;
  return faults;
}

std::uint8_t servo_fault_bits(const ServoModel& model, std::uint32_t faults) noexcept {
  unsigned bits = 0;
  for (const ServoFaultBit& f : model.faults)
    if ((f.faults & faults) != 0) bits |= 1u << f.bit;
  return static_cast<std::uint8_t>(bits);
}

}  // namespace sinew::wire
