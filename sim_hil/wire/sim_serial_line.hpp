#pragma once
// A half-duplex serial line in memory, with the time that its bytes take.
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

#include "hal/buses.hpp"
#include "hal/clock.hpp"

namespace sinew::sim_hil {

class SimSerialLine;

/// A device on the line. The line calls it in the order of time.
class SimLineDevice {
 public:
  virtual ~SimLineDevice() = default;
  /// A byte has come in whole; of another device or the host.
  virtual void hear(std::uint8_t byte, hal::Time now) = 0;
  /// Time has reached `now`; at least after each byte.
  virtual void advance(hal::Time now) = 0;
};

struct SimLineOptions {
  std::uint32_t bit_rate = 1'000'000;
  bool echo = false;  // the host hears what it sends, as behind a single wire without a switch
  /// Of a USB adapter: bytes lie in it until so much time has gone since the first of them, or it is full (FTDI: 62
  /// bytes, latency timer 16 ms unless it was set). 0: each byte is there at once.
  hal::Duration latency{0};
};

/// The line between a host and devices: 8N1, one byte after the other, at the bit rate. Two that send at once destroy
/// each other's bytes. Time goes on by advance() alone.
/// Thread:  any (a lock); the devices run in advance().
class SimSerialLine {
 public:
  SimSerialLine(const SimLineOptions& options, const hal::Clock& clock);
  ~SimSerialLine();
  SimSerialLine(const SimSerialLine&) = delete;
  SimSerialLine& operator=(const SimSerialLine&) = delete;

  /// Before bytes go. The device outlives the line's last advance().
  void attach(SimLineDevice& device) { devices_.push_back(&device); }
  /// The host's end.
  hal::Serial& host();
  /// Everything that happens up to `now`.
  void advance(hal::Time now);
  /// When a byte is next complete, or the adapter hands bytes over; kNever: nothing is on its way.
  hal::Time next() const;

  /// What becomes of each byte on the line: a changed one, or nothing (lost for everyone). Called in advance().
  void set_tamper(std::function<std::optional<std::uint8_t>(std::uint8_t)> tamper) { tamper_ = std::move(tamper); }
  /// False: the host's end is gone (unplugged).
  void connect(bool connected);
  void set_latency(hal::Duration latency);
  void set_echo(bool echo);

  /// For devices, in hear() and advance(): sends from `at` on.
  void send(const SimLineDevice& from, std::span<const std::uint8_t> bytes, hal::Time at);

  hal::Duration byte_time() const { return byte_time_; }
  std::uint64_t bytes() const { return bytes_; }            // complete on the line
  std::uint64_t collisions() const { return collisions_; }  // bytes destroyed

 private:
  class Port;
  struct Sent {
    hal::Time begin, end;
    const void* from = nullptr;  // null: the host
    std::uint8_t byte = 0;
    bool destroyed = false;
  };
  void put(const void* from, std::span<const std::uint8_t> bytes, hal::Time at);
  void deliver(const Sent& sent);
  void hand_over(hal::Time now);
  hal::Time next_locked() const;

  static constexpr std::size_t kAdapter = 62;  // of 64 bytes in a USB packet two are status

  SimLineOptions options_;
  const hal::Clock& clock_;
  const hal::Duration byte_time_;
  mutable std::recursive_mutex mutex_;
  std::vector<SimLineDevice*> devices_;
  std::vector<Sent> sending_;  // by their end
  std::function<std::optional<std::uint8_t>(std::uint8_t)> tamper_;
  std::deque<std::uint8_t> adapter_, host_;  // received: still in the adapter; readable
  hal::Time adapter_since_{}, host_until_{};
  bool connected_ = true;
  std::uint64_t bytes_ = 0, collisions_ = 0;
  std::unique_ptr<Port> port_;
};

}  // namespace sinew::sim_hil
