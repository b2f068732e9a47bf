#include "sim_hil/wire/sim_serial_servo.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace sinew::sim_hil {
namespace {

using wire::DxlBuilder;
using wire::DxlError;
using wire::DxlInstruction;
using wire::DxlPacket;
using wire::DxlVersion;
using wire::ServoRegister;

constexpr int kSilenceBytes = 10;  // so many byte times without a byte end a packet that was begun

std::uint16_t le(std::span<const std::uint8_t> p, std::size_t at) {
  return static_cast<std::uint16_t>(p[at] | p[at + 1] << 8);
}

bool overlaps(const ServoRegister& r, std::uint16_t address, std::size_t size) {
  return r && r.address < address + size && address < r.address + r.size;
}

}  // namespace

SimSerialServo::SimSerialServo(SimSerialLine& line, SimJoint& joint, const SimMount& mount,
                               const Parameters& parameters)
    : SimDrive(joint, mount), line_(line), p_(parameters), reader_(parameters.model->version) {
  voltage_v = 12;
  const wire::ServoModel& m = *p_.model;
  set_number(m.model_number, m.number);
  set_number(m.id, p_.id);
  set_number(m.return_delay, p_.return_delay);
  if (m.operating_mode) set_number(m.operating_mode, m.position_mode);
  if (m.effort_limit) set_number(m.effort_limit, m.version == DxlVersion::two ? 1193 : 1023);
  if (m.lock && m.maker == wire::ServoMaker::feetech) set_number(m.lock, 1);
  if (m.version == DxlVersion::one) set_number(m.status_return, m.maker == wire::ServoMaker::feetech ? 1 : 2);
  set_number(m.goal_position, m.centre);
  reset_ram();
  line.attach(*this);
}

std::int32_t SimSerialServo::number(const ServoRegister& reg) const {
  return wire::servo_number(*p_.model, reg, 0, table_).value_or(0);
}
void SimSerialServo::set_number(const ServoRegister& reg, std::int32_t value) {
  wire::put_servo_number(*p_.model, reg, 0, value, table_);
}

std::uint16_t SimSerialServo::ram_begin() const {
  if (p_.model->maker == wire::ServoMaker::feetech) return 40;
  return p_.model->version == DxlVersion::two ? 64 : 24;
}

Duration SimSerialServo::delay() const {
  return Duration{static_cast<std::int64_t>(number(p_.model->return_delay) * p_.model->seconds_per_delay * 1e9)};
}

void SimSerialServo::reset_ram() {
  live_ = false;
  const wire::ServoModel& m = *p_.model;
  set_number(m.torque_enable, 0);
  if (m.hardware_error) set_number(m.hardware_error, 0);
  if (m.bus_watchdog) set_number(m.bus_watchdog, 0);
  if (m.version == DxlVersion::two) set_number(m.status_return, 2);
  if (m.goal_velocity) set_number(m.goal_velocity, 0);
  if (m.goal_effort) set_number(m.goal_effort, 0);
  registered_.reset(), turn_.reset(), part_.reset();
}

void SimSerialServo::on_power() {
  reset_ram();
  reader_.gap();
  error_bits_ = 0;
  boots_until_ = {};
}

void SimSerialServo::reboot(Time now) {
  ++reboots_;
  reset_ram();
  error_bits_ = 0;
  boots_until_ = now + p_.boot;
}

void SimSerialServo::fail(std::uint32_t code) {
  if (code == 0 && p_.model->version == DxlVersion::two) return;
  error_bits_ = static_cast<std::uint8_t>(code);
  if (p_.model->hardware_error) set_number(p_.model->hardware_error, error_bits_);
  if (code == 0) return;
  live_ = false;
  set_number(p_.model->torque_enable, 0);
}

// ---- its loop ----

void SimSerialServo::measure() {
  const wire::ServoModel& m = *p_.model;
  const auto counts = [](double value) { return static_cast<std::int32_t>(std::lround(value)); };
  const std::int32_t position = counts(drive_position() / m.rad_per_count()) + m.centre;
  set_number(m.present_position, m.version == DxlVersion::one ? std::clamp(position, m.least, m.most) : position);
  set_number(m.present_velocity, counts(drive_velocity() / m.radps_per_count));
  set_number(m.present_effort, counts(drive_effort() / m.nm_per_count));
  set_number(m.present_voltage, counts(voltage_v / m.volts_per_count));
  set_number(m.present_temperature, counts(temperature_c));
}

double SimSerialServo::control(Time now, Duration) {
  const wire::ServoModel& m = *p_.model;
  if (boots_until_.ns != 0 && now < boots_until_) return 0;
  if (const std::int32_t limit = number(m.bus_watchdog); live_ && limit > 0 && limit < 128) {
    if (now - instructed_ > Duration{static_cast<std::int64_t>(limit * m.seconds_per_watchdog * 1e9)}) {
      set_number(m.bus_watchdog, 0xFF);  // it stops where it is
      measure();
      set_number(m.goal_position, number(m.present_position));
      set_number(m.goal_velocity, 0);
      if (m.goal_effort) set_number(m.goal_effort, 0);
    }
  }
  if (!live_) return 0;
  double most = m.most_nm;
  if (m.effort_limit)
    most = m.version == DxlVersion::two ? std::min(most, number(m.effort_limit) * m.nm_per_count)
                                        : most * std::min(1.0, number(m.effort_limit) / 1000.0);
  const std::int32_t mode = m.operating_mode ? number(m.operating_mode) : m.position_mode;
  double nm = 0;
  if (mode == m.position_mode)
    nm = p_.kp * ((number(m.goal_position) - m.centre) * m.rad_per_count() - drive_position()) -
         p_.kd * drive_velocity();
  else if (mode == m.velocity_mode)
    nm = 4 * p_.kd * (number(m.goal_velocity) * m.radps_per_count - drive_velocity());
  else if (m.has_effort_mode && mode == m.effort_mode)
    nm = number(m.goal_effort) * m.nm_per_count;
  return std::clamp(nm, -most, most);
}

void SimSerialServo::say(Time) {}

// ---- the line ----

void SimSerialServo::hear(std::uint8_t byte, Time now) {
  SimDrive::advance(now);
  const bool booting = boots_until_.ns != 0 && now < boots_until_;
  if (!powered() || booting || chance() < faults.lost) return;
  if (now - heard_ > kSilenceBytes * line_.byte_time()) reader_.gap();
  heard_ = now;
  if (part_) {
    part_->crc = wire::dxl_crc({&byte, 1}, part_->crc);
    if (--part_->before == 0) send_part(now);
  }
  reader_.push(byte, [&](const DxlPacket& packet) { on_packet(packet, now); });
}

void SimSerialServo::on_packet(const DxlPacket& packet, Time now) {
  const bool answer = packet.is(DxlInstruction::status) && p_.model->version == DxlVersion::two;
  // Of 1.0 an answer looks like an instruction.
  if (turn_ && packet.id == turn_->predecessor && (answer || p_.model->version == DxlVersion::one)) {
    const Turn turn = *turn_;
    turn_.reset();
    read(turn.address, turn.size, now);
    return;
  }
  if (answer) return;
  if (p_.model->version == DxlVersion::two) turn_.reset(), part_.reset();  // the host asks something else
  instructed_ = now;
  if (packet.id != id() && packet.id != wire::kDxlBroadcast) return;
  turn_.reset(), part_.reset();
  on_instruction(packet, now);
}

void SimSerialServo::on_instruction(const DxlPacket& packet, Time now) {
  const bool two = p_.model->version == DxlVersion::two, alone = packet.id == id();
  const std::size_t place = two ? 2 : 1;
  const Data p = packet.parameters;
  const auto address = [&](std::size_t at) { return two ? le(p, at) : std::uint16_t{p[at]}; };
  const bool sure = number(p_.model->status_return) >= (p_.model->maker == wire::ServoMaker::feetech ? 1 : 2);
  const auto done = [&](std::uint8_t error) {
    if (alone && sure) status(error, {}, now);
  };
  const auto wrong = [&] { done(two ? static_cast<std::uint8_t>(DxlError::data_length) : wire::kDxl1Range); };
  ++instructions_;
  switch (static_cast<DxlInstruction>(packet.code)) {
    case DxlInstruction::ping: {
      const Data known = table(p_.model->model_number.address, 2), firmware = table(p_.model->firmware.address, 1);
      const std::array<std::uint8_t, 3> identity{known[0], known[1], firmware[0]};
      // All answer a broadcast, each in the slot of its id.
      const Duration slot = alone ? Duration{0} : (14 * line_.byte_time() + delay()) * id();
      if (two || alone) status(0, two ? Data(identity) : Data(), now + slot);
      return;
    }
    case DxlInstruction::read:
      if (p.size() < 2 * place) return wrong();
      if (alone) read(address(0), address(place), now);
      return;
    case DxlInstruction::write:
      if (p.size() <= place) return wrong();
      return done(write(address(0), p.subspan(place), now));
    case DxlInstruction::reg_write:
      if (p.size() <= place || p.size() - place > 64) return wrong();
      registered_ = Registered{};
      registered_->address = address(0);
      registered_->size = p.size() - place;
      std::copy(p.begin() + static_cast<std::ptrdiff_t>(place), p.end(), registered_->data.begin());
      return done(0);
    case DxlInstruction::action: {
      if (!registered_) return done(two ? static_cast<std::uint8_t>(DxlError::instruction) : wire::kDxl1Instruction);
      const Registered r = *registered_;
      registered_.reset();
      return done(write(r.address, {r.data.data(), r.size}, now));
    }
    case DxlInstruction::reboot:
      if (!two && p_.model->maker == wire::ServoMaker::robotis) break;
      done(0);
      return reboot(now);
    case DxlInstruction::clear:
      if (!two) break;
      return done(0);  // this model counts no turns
    case DxlInstruction::sync_read:
    case DxlInstruction::fast_sync_read: {
      const bool fast = packet.is(DxlInstruction::fast_sync_read);
      if (!(fast ? p_.model->fast_read : p_.model->sync_read)) break;
      return on_sync_read(packet, now, fast);
    }
    case DxlInstruction::bulk_read:
    case DxlInstruction::fast_bulk_read: {
      const bool fast = packet.is(DxlInstruction::fast_bulk_read);
      if (!(fast ? p_.model->fast_read : p_.model->bulk_read)) break;
      return on_bulk_read(packet, now, fast);
    }
    case DxlInstruction::sync_write:
      return on_sync_write(packet, now);
    case DxlInstruction::bulk_write:
      if (two) return on_bulk_write(packet, now);
      break;
    case DxlInstruction::factory_reset:
    case DxlInstruction::status:
      break;
  }
  done(two ? static_cast<std::uint8_t>(DxlError::instruction) : wire::kDxl1Instruction);
}

void SimSerialServo::on_sync_read(const DxlPacket& packet, Time now, bool fast) {
  const bool two = p_.model->version == DxlVersion::two;
  const std::size_t head = two ? 4 : 2;
  const Data p = packet.parameters;
  if (p.size() <= head) return;
  const std::uint16_t address = two ? le(p, 0) : p[0], size = two ? le(p, 2) : p[1];
  const Data ids = p.subspan(head);
  for (std::size_t i = 0; i < ids.size(); ++i) {
    if (ids[i] != id()) continue;
    if (!fast) return answer_in_turn(i, i > 0 ? ids[i - 1] : ids[i], address, size, now);
    const std::size_t each = size + 4u;
    return answer_in_one(i, ids.size(), 8 + i * each, 1 + ids.size() * each, address, size, now);
  }
}

void SimSerialServo::on_bulk_read(const DxlPacket& packet, Time now, bool fast) {
  const bool two = p_.model->version == DxlVersion::two;
  const std::size_t head = two ? 0 : 1, each = two ? 5 : 3;
  const Data p = packet.parameters;
  if (p.size() < head + each) return;
  const std::size_t servos = (p.size() - head) / each;
  std::uint8_t before = id();
  std::size_t bytes_before = 8, all = 1;
  const auto size_of = [&](std::size_t at) { return two ? le(p, at + 3) : std::uint16_t{p[at]}; };
  for (std::size_t i = 0; i < servos; ++i) all += size_of(head + i * each) + 4u;
  for (std::size_t i = 0; i < servos; ++i) {
    const std::size_t at = head + i * each;
    const std::uint8_t of = two ? p[at] : p[at + 1];
    const std::uint16_t address = two ? le(p, at + 1) : std::uint16_t{p[at + 2]};
    if (of == id()) {
      if (!fast) return answer_in_turn(i, before, address, size_of(at), now);
      return answer_in_one(i, servos, bytes_before, all, address, size_of(at), now);
    }
    before = of;
    bytes_before += size_of(at) + 4u;
  }
}

void SimSerialServo::answer_in_turn(std::size_t index, std::uint8_t predecessor, std::uint16_t address,
                                    std::uint16_t size, Time now) {
  if (index == 0)
    read(address, size, now);
  else
    turn_ = Turn{predecessor, address, size};
}

void SimSerialServo::answer_in_one(std::size_t index, std::size_t servos, std::size_t before, std::size_t length,
                                   std::uint16_t address, std::uint16_t size, Time now) {
  part_ = Part{before, 0, address, size, index + 1 == servos};
  if (index > 0) return;
  const std::array<std::uint8_t, 8> head{0xFF,
                                         0xFF,
                                         0xFD,
                                         0,
                                         wire::kDxlBroadcast,
                                         static_cast<std::uint8_t>(length),
                                         static_cast<std::uint8_t>(length >> 8),
                                         static_cast<std::uint8_t>(DxlInstruction::status)};
  part_->crc = wire::dxl_crc(head);
  transmit(head, now + delay());
  send_part(now + delay());
}

void SimSerialServo::send_part(Time now) {
  const Part part = *part_;
  part_.reset();
  measure();
  std::vector<std::uint8_t> bytes{static_cast<std::uint8_t>(error_bits_ != 0 ? wire::kDxlAlert : 0), id()};
  const Data data = table(part.address, part.size);
  bytes.insert(bytes.end(), data.begin(), data.end());
  const std::uint16_t crc = wire::dxl_crc(bytes, part.crc);
  bytes.push_back(static_cast<std::uint8_t>(crc));
  bytes.push_back(static_cast<std::uint8_t>(crc >> 8));
  transmit(bytes, now);
}

SimSerialServo::Data SimSerialServo::table(std::uint16_t address, std::uint16_t size) const {
  if (static_cast<std::size_t>(address) + size > table_.size()) return {};
  return {table_.data() + address, size};
}

void SimSerialServo::read(std::uint16_t address, std::uint16_t size, Time now) {
  if (number(p_.model->status_return) < 1 && p_.model->maker == wire::ServoMaker::robotis) return;
  measure();
  const Data data = table(address, size);
  const bool two = p_.model->version == DxlVersion::two;
  if (data.empty()) return status(two ? static_cast<std::uint8_t>(DxlError::access) : wire::kDxl1Range, {}, now);
  status(0, data, now);
}

bool SimSerialServo::is_goal(std::uint16_t address, std::size_t size) const {
  const wire::ServoModel& m = *p_.model;
  return overlaps(m.goal_position, address, size) || overlaps(m.goal_velocity, address, size) ||
         overlaps(m.goal_effort, address, size);
}

std::uint8_t SimSerialServo::write(std::uint16_t address, Data data, Time) {
  const wire::ServoModel& m = *p_.model;
  const bool two = m.version == DxlVersion::two;
  const auto refuse = [two](DxlError in_two, std::uint8_t in_one) {
    return two ? static_cast<std::uint8_t>(in_two) : in_one;
  };
  if (static_cast<std::size_t>(address) + data.size() > table_.size() || overlaps(m.model_number, address, data.size()))
    return refuse(DxlError::access, wire::kDxl1Range);
  for (const ServoRegister& r :
       {m.present_position, m.present_velocity, m.present_effort, m.present_voltage, m.present_temperature})
    if (overlaps(r, address, data.size())) return refuse(DxlError::access, wire::kDxl1Range);
  if (address < ram_begin()) {
    if (two && live_) return static_cast<std::uint8_t>(DxlError::access);
    if (m.maker == wire::ServoMaker::feetech && number(m.lock) != 0) return 0;  // not kept, and not used
  }
  if (number(m.bus_watchdog) == 0xFF && is_goal(address, data.size()))
    return refuse(DxlError::data_range, wire::kDxl1Range);
  const auto goal = wire::servo_number(m, m.goal_position, address, data);
  if (goal && (*goal < m.least || *goal > m.most)) return refuse(DxlError::data_limit, wire::kDxl1AngleLimit);
  std::copy(data.begin(), data.end(), table_.begin() + address);
  if (const auto torque = wire::servo_number(m, m.torque_enable, address, data)) {
    if (*torque != 0 && error_bits_ != 0) {
      set_number(m.torque_enable, 0);
      return refuse(DxlError::result_fail, 0);
    }
    live_ = *torque != 0;
  }
  return 0;
}

void SimSerialServo::on_sync_write(const DxlPacket& packet, Time now) {
  const bool two = p_.model->version == DxlVersion::two;
  const std::size_t head = two ? 4 : 2;
  const Data p = packet.parameters;
  if (p.size() < head) return;
  const std::uint16_t address = two ? le(p, 0) : p[0], size = two ? le(p, 2) : p[1];
  for (std::size_t at = head; at + 1 + size <= p.size(); at += 1u + size)
    if (p[at] == id()) static_cast<void>(write(address, p.subspan(at + 1, size), now));
}

void SimSerialServo::on_bulk_write(const DxlPacket& packet, Time now) {
  const Data p = packet.parameters;
  for (std::size_t at = 0; at + 5 <= p.size();) {
    const std::size_t size = le(p, at + 3);
    if (at + 5 + size > p.size()) return;
    if (p[at] == id()) static_cast<void>(write(le(p, at + 1), p.subspan(at + 5, size), now));
    at += 5 + size;
  }
}

void SimSerialServo::status(std::uint8_t error, Data data, Time now) {
  const bool two = p_.model->version == DxlVersion::two;
  if (two && error_bits_ != 0) error = static_cast<std::uint8_t>(error | wire::kDxlAlert);
  if (!two) error = static_cast<std::uint8_t>(error | error_bits_);
  DxlBuilder packet = DxlBuilder::status(p_.model->version, id(), error);
  transmit(packet.bytes(data).finish(), now + delay());
}

void SimSerialServo::transmit(Data bytes, Time at) {
  if (faults.silent || !powered()) return;
  std::vector<std::uint8_t> sent(bytes.begin(), bytes.end());
  if (faults.garbage)
    for (std::uint8_t& b : sent) b = static_cast<std::uint8_t>(chance() * 256);
  if (faults.lost > 0) std::erase_if(sent, [this](std::uint8_t) { return chance() < faults.lost; });
  line_.send(*this, sent, at);
}

}  // namespace sinew::sim_hil
