#include "sim_hil/wire/sim_serial_line.hpp"

#include <algorithm>
#include <memory>

namespace sinew::sim_hil {

using hal::Duration;
using hal::Time;

class SimSerialLine::Port final : public hal::Serial {
 public:
  explicit Port(SimSerialLine& line) : line_(line) {}
  hal::Result<std::size_t> read_now(std::span<std::uint8_t> into) noexcept override {
    const std::lock_guard lock(line_.mutex_);
    if (!line_.connected_) return hal::Error{hal::Errc::closed, "serial: the line is gone"};
    const std::size_t n = std::min(into.size(), line_.host_.size());
    for (std::size_t i = 0; i < n; ++i) {
      into[i] = line_.host_.front();
      line_.host_.pop_front();
    }
    return n;
  }
  hal::Result<std::size_t> write_now(std::span<const std::uint8_t> bytes) noexcept override {
    const std::lock_guard lock(line_.mutex_);
    if (!line_.connected_) return hal::Error{hal::Errc::closed, "serial: the line is gone"};
    line_.put(nullptr, bytes, line_.clock_.now());
    return bytes.size();
  }
  hal::Status set_bit_rate(std::uint32_t bits_per_s) noexcept override {
    if (bits_per_s == line_.options_.bit_rate) return {};
    return hal::Error{hal::Errc::not_supported, "serial: the simulated line has one bit rate", line_.options_.bit_rate};
  }
  /// Virtual time does not go on in here: says what there is now.
  hal::Result<bool> wait_readable(Time) noexcept override {
    const std::lock_guard lock(line_.mutex_);
    if (!line_.connected_) return hal::Error{hal::Errc::closed, "serial: the line is gone"};
    return !line_.host_.empty();
  }

 private:
  SimSerialLine& line_;
};

SimSerialLine::SimSerialLine(const SimLineOptions& options, const hal::Clock& clock)
    : options_(options),
      clock_(clock),
      byte_time_(Duration{10'000'000'000 / static_cast<std::int64_t>(options.bit_rate)}),
      port_(std::make_unique<Port>(*this)) {}
SimSerialLine::~SimSerialLine() = default;

hal::Serial& SimSerialLine::host() { return *port_; }

void SimSerialLine::connect(bool connected) {
  const std::lock_guard lock(mutex_);
  connected_ = connected;
  if (!connected) adapter_.clear(), host_.clear();
}

void SimSerialLine::set_latency(Duration latency) {
  const std::lock_guard lock(mutex_);
  options_.latency = latency;
}

void SimSerialLine::set_echo(bool echo) {
  const std::lock_guard lock(mutex_);
  options_.echo = echo;
}

void SimSerialLine::send(const SimLineDevice& from, std::span<const std::uint8_t> bytes, Time at) {
  const std::lock_guard lock(mutex_);
  put(&from, bytes, at);
}

void SimSerialLine::put(const void* from, std::span<const std::uint8_t> bytes, Time at) {
  // A sender's own bytes wait in its queue; others' are not waited for.
  Time begin = from == nullptr ? std::max(at, host_until_) : at;
  for (const Sent& s : sending_)
    if (s.from == from) begin = std::max(begin, s.end);
  for (const std::uint8_t byte : bytes) {
    Sent sent{begin, begin + byte_time_, from, byte, false};
    for (Sent& other : sending_) {
      if (other.from == from || other.end <= sent.begin || other.begin >= sent.end) continue;
      other.destroyed = sent.destroyed = true;
    }
    const auto place = std::upper_bound(sending_.begin(), sending_.end(), sent.end,
                                        [](Time end, const Sent& s) { return end < s.end; });
    sending_.insert(place, sent);
    begin = sent.end;
  }
  if (from == nullptr) host_until_ = begin;
}

void SimSerialLine::deliver(const Sent& sent) {
  ++bytes_;
  std::uint8_t byte = sent.byte;
  if (sent.destroyed) {
    ++collisions_;
    byte = static_cast<std::uint8_t>(~byte);
  } else if (tamper_) {
    const auto kept = tamper_(byte);
    if (!kept) return;
    byte = *kept;
  }
  for (SimLineDevice* device : devices_)
    if (device != sent.from) device->hear(byte, sent.end);
  if (sent.from == nullptr && !options_.echo) return;
  if (!connected_) return;
  if (adapter_.empty()) adapter_since_ = sent.end;
  adapter_.push_back(byte);
}

void SimSerialLine::hand_over(Time now) {
  if (adapter_.empty() || (adapter_.size() < kAdapter && now < adapter_since_ + options_.latency)) return;
  host_.insert(host_.end(), adapter_.begin(), adapter_.end());
  adapter_.clear();
}

Time SimSerialLine::next_locked() const {
  Time next = sending_.empty() ? hal::kNever : sending_.front().end;
  if (!adapter_.empty()) next = std::min(next, adapter_since_ + options_.latency);
  return next;
}

Time SimSerialLine::next() const {
  const std::lock_guard lock(mutex_);
  return next_locked();
}

void SimSerialLine::advance(Time now) {
  const std::lock_guard lock(mutex_);
  for (Time next = next_locked(); next <= now; next = next_locked()) {
    hand_over(next);
    if (sending_.empty() || sending_.front().end > next) continue;
    const Sent sent = sending_.front();
    sending_.erase(sending_.begin());
    deliver(sent);
    hand_over(sent.end);
  }
  for (SimLineDevice* device : devices_) device->advance(now);
}

}  // namespace sinew::sim_hil
