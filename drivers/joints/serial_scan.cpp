#include "drivers/joints/serial_scan.hpp"

#include <algorithm>
#include <cstdio>

#include "drivers/joints/joint_words.hpp"

namespace sinew::drivers {
namespace {

using namespace std::chrono_literals;
using hal::Duration;
using hal::Time;
using wire::DxlBuilder;
using wire::DxlInstruction;
using wire::DxlPacket;
using wire::DxlVersion;
using wire::ServoMaker;
using wire::ServoModel;
using wire::ServoRegister;

constexpr Duration kServoDelay = 700us;  // the factory's return delay of 500 us, and a servo's own time
constexpr std::size_t kHead = 9;         // registers of 1.0 and Feetech that tell who it is
constexpr std::size_t kPingData = 3;     // of 2.0: model number and firmware

/// From voltage to temperature; Feetech also has its errors behind them.
ServoRegister power_registers(const ServoModel& m) {
  std::uint16_t end = static_cast<std::uint16_t>(m.present_temperature.address + m.present_temperature.size);
  if (m.maker == ServoMaker::feetech) end = static_cast<std::uint16_t>(m.hardware_error.address + 1);
  return {m.present_voltage.address, static_cast<std::uint8_t>(end - m.present_voltage.address)};
}

}  // namespace

Duration SerialDialogue::patience(DxlVersion version, std::size_t sent, std::size_t data, std::uint32_t bit_rate,
                                  Duration latency) {
  const auto bytes = static_cast<std::int64_t>(sent + wire::dxl_status_bytes(version, data));
  return Duration{bytes * 10'000'000'000 / static_cast<std::int64_t>(bit_rate)} + kServoDelay + latency;
}

hal::Status SerialDialogue::ask(DxlVersion version, std::uint8_t id, wire::DxlBuilder& packet, std::size_t data,
                                std::uint32_t bit_rate, hal::Time now) {
  std::array<std::uint8_t, 256> old;
  for (auto n = line_.read_now(old); n && *n > 0; n = line_.read_now(old)) {  // late answers
  }
  one_.gap(), two_.gap();
  version_ = version, id_ = id, expected_ = data;
  answered_ = bytes_came_ = false;
  const auto bytes = packet.finish();
  sent_size_ = std::min(bytes.size(), sent_.size()), echo_at_ = 0;
  std::copy_n(bytes.begin(), sent_size_, sent_.begin());
  deadline_ = now + patience(version, bytes.size(), data, bit_rate, latency_);
  const auto sent = line_.write_now(bytes);
  return sent ? hal::Status{} : hal::Status{sent.error()};
}

hal::Result<SerialDialogue::Heard> SerialDialogue::listen(hal::Time now) {
  std::array<std::uint8_t, 256> bytes;
  for (int i = 0; i < 16; ++i) {
    const auto n = line_.read_now(bytes);
    if (!n) return n.error();
    for (std::size_t k = 0; k < *n; ++k) hear(bytes[k]);
    if (*n < bytes.size()) break;
  }
  if (answered_) return Heard::answer;
  if (now < deadline_) return Heard::nothing;
  return bytes_came_ ? Heard::broken : Heard::silence;
}

/// An echo is what we sent, from its first byte on. Answers differ from it: a status of 2.0 by its instruction, the
/// answers of 1.0 by their length.
void SerialDialogue::hear(std::uint8_t byte) {
  if (echo_at_ < sent_size_) {
    if (byte == sent_[echo_at_]) {
      if (++echo_at_ == sent_size_) sent_size_ = echo_at_ = 0;
      return;
    }
    const std::size_t held = echo_at_;
    sent_size_ = echo_at_ = 0;
    for (std::size_t i = 0; i < held; ++i) take(sent_[i]);
  }
  take(byte);
}

void SerialDialogue::take(std::uint8_t byte) {
  bytes_came_ = true;
  const bool two = version_ == DxlVersion::two;
  (two ? two_ : one_).push(byte, [&](const DxlPacket& packet) {
    if (answered_ || packet.id != id_ || (two && !packet.is(DxlInstruction::status))) return;
    if (packet.parameters.size() != expected_ || expected_ > data_.size()) return;
    answered_ = true;
    error_ = packet.error;
    size_ = expected_;
    std::copy(packet.parameters.begin(), packet.parameters.end(), data_.begin());
  });
}

const char* to_string(ServoMaker maker) { return maker == ServoMaker::robotis ? "dynamixel" : "feetech"; }

std::string describe(const SerialFound& f) {
  if (f.broken)
    return "answers that are not whole: two servos with this id? Connect them one by one, and change the id of one";
  std::string all;
  char text[64];
  const auto add = [&](const char* format, auto value) {
    std::snprintf(text, sizeof text, format, value);
    all += text;
  };
  if (f.model)
    all = std::string(f.model->title) + " (" + std::string(f.model->name) + ")";
  else
    add("model number %d, which is not known here", static_cast<int>(f.number));
  if (!f.firmware.empty()) all += ", firmware " + f.firmware;
  if (f.voltage_v) add(", %.1f V", *f.voltage_v);
  if (f.temperature_c) add(", %.0f C", *f.temperature_c);
  if (f.error == 0) return all;
  const std::string words = fault_words(f.faults);
  all += ", fault: " + (words.empty() ? "" : words + " ");
  add("(code 0x%02x)", static_cast<unsigned>(f.error));
  return all;
}

SerialScan::SerialScan(hal::Serial& line, const Options& options)
    : line_(line), options_(options), dialogue_(line, options.latency), id_(options.least_id) {
  done_ = options_.bit_rates.empty() || options_.versions.empty();
}

Duration SerialScan::longest() const {
  Duration all{};
  for (const std::uint32_t rate : options_.bit_rates)
    for (const DxlVersion v : options_.versions) {
      const bool two = v == DxlVersion::two;
      const std::size_t sent = wire::dxl_instruction_bytes(v, two ? 0 : 2);
      all += SerialDialogue::patience(v, sent, two ? kPingData : kHead, rate, options_.latency) *
             (most_id(v) + 1 - options_.least_id);
    }
  return all;
}

hal::Result<Time> SerialScan::step(Time now) {
  if (done_) return now;
  if (!begun_) {
    begun_ = true;
    if (set_rate()) ask(Ask::who, now);
  }
  if (!done_ && !failed_) {
    const auto heard = dialogue_.listen(now);
    if (!heard) return heard.error();
    if (*heard == SerialDialogue::Heard::answer)
      answered(now);
    else if (*heard != SerialDialogue::Heard::nothing)
      unanswered(*heard == SerialDialogue::Heard::broken, now);
  }
  if (failed_) return *failed_;
  return done_ ? now : dialogue_.deadline();
}

hal::Status SerialScan::run(hal::Os& os) {
  while (!done_) {
    const auto next = step(os.now());
    if (!next) return next.error();
    if (done_) break;
    if (const auto ready = line_.wait_readable(*next); !ready) return ready.error();
  }
  return {};
}

/// Sets the first bit rate, from rate_ on, that the line can do. False: there is none left, or the line failed.
bool SerialScan::set_rate() {
  for (; rate_ < options_.bit_rates.size(); ++rate_) {
    const hal::Status set = line_.set_bit_rate(bit_rate());
    if (set) return true;
    if (set.error().code != hal::Errc::not_supported) {
      failed_ = set.error();
      break;
    }
    skipped_.push_back(bit_rate());
  }
  done_ = true;
  return false;
}

/// The next id, packets or bit rate. False: that was all.
bool SerialScan::next_place() {
  if (id_ < most_id(version())) {
    ++id_;
    return true;
  }
  id_ = options_.least_id;
  if (++version_ < options_.versions.size()) return true;
  version_ = 0;
  ++rate_;
  return set_rate();
}

void SerialScan::ask(Ask what, Time now) {
  what_ = what;
  const DxlVersion v = version();
  const bool two = v == DxlVersion::two;
  DxlBuilder packet = two ? wire::dxl_ping(v, id_) : wire::dxl_read(v, id_, 0, kHead);
  std::size_t expected = two ? kPingData : kHead;
  if (what != Ask::who) {
    const ServoModel& m = *found_.back().model;
    const ServoRegister reg = what == Ask::error ? m.hardware_error : power_registers(m);
    packet = wire::dxl_read(v, id_, reg.address, reg.size);
    expected = reg.size;
  }
  ++asked_;
  if (const hal::Status sent = dialogue_.ask(v, id_, packet, expected, bit_rate(), now); !sent) failed_ = sent.error();
}

void SerialScan::answered(Time now) {
  const bool two = version() == DxlVersion::two;
  again_ = false;
  if (what_ == Ask::who) {
    identify();
    if (!found_.back().model) return go_on(now);
    return ask(two ? Ask::error : Ask::power, now);
  }
  SerialFound& f = found_.back();
  const ServoModel& m = *f.model;
  const std::uint16_t first = what_ == Ask::error ? m.hardware_error.address : power_registers(m).address;
  const auto is = [&](const ServoRegister& r) { return wire::servo_number(m, r, first, dialogue_.data()); };
  if (const auto error = is(m.hardware_error)) f.error = static_cast<std::uint8_t>(*error);
  if (const auto v = is(m.present_voltage)) f.voltage_v = *v * m.volts_per_count;
  if (const auto t = is(m.present_temperature)) f.temperature_c = *t;
  f.faults = wire::servo_faults(m, f.error);
  if (what_ == Ask::error) return ask(Ask::power, now);
  go_on(now);
}

void SerialScan::identify() {
  SerialFound f;
  f.version = version(), f.bit_rate = bit_rate(), f.id = id_;
  const std::span<const std::uint8_t> d = dialogue_.data();
  const auto word = [&](std::size_t at) { return static_cast<std::uint16_t>(d[at] | d[at + 1] << 8); };
  if (f.version == DxlVersion::two) {
    f.number = word(0);
    f.firmware = std::to_string(d[2]);
    f.model = wire::servo_model(f.version, f.number);
  } else {
    // The two makers keep number and id at different places: a model that fits at its own places decides.
    for (const ServoModel& m : wire::servo_models())
      if (!f.model && m.version == f.version && d[m.id.address] == id_ &&
          wire::servo_number(m, m.model_number, 0, d) == m.number)
        f.model = &m;
    const bool is_feetech = f.model ? f.model->maker == ServoMaker::feetech : d[3] != id_ && d[5] == id_;
    f.maker = is_feetech ? ServoMaker::feetech : ServoMaker::robotis;
    f.number = f.model ? f.model->number : word(is_feetech ? 3 : 0);
    f.firmware = is_feetech ? std::to_string(d[0]) + "." + std::to_string(d[1]) : std::to_string(d[2]);
    f.error = dialogue_.error();
    if (f.model) f.faults = wire::servo_faults(*f.model, f.error);
  }
  found_.push_back(std::move(f));
}

void SerialScan::unanswered(bool broken, Time now) {
  if (broken && !again_) {
    again_ = true;
    return ask(what_, now);
  }
  again_ = false;
  if (what_ == Ask::error) return ask(Ask::power, now);
  if (what_ == Ask::who && broken) {
    SerialFound f;
    f.version = version(), f.bit_rate = bit_rate(), f.id = id_, f.broken = true;
    found_.push_back(std::move(f));
  }
  go_on(now);
}

void SerialScan::go_on(Time now) {
  if (next_place()) ask(Ask::who, now);
}

}  // namespace sinew::drivers
