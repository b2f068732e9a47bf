#pragma once
// A bus with joints, as a group of joints sees it; and the group, as the bus sees it.
#include <string>
#include <vector>

#include "drivers/joints/servo.hpp"
#include "hal/result.hpp"

namespace sinew::drivers {

/// Ticks follow the loop that makes setpoints, in periods: a setpoint that comes after kEarliestTick is sent at once,
/// and the next tick then waits for its own until kLatestTick. A planned load assumes that all ticks come so early.
inline constexpr double kEarliestTick = 0.9, kLatestTick = 1.1;
inline Duration part_of(Duration period, double share) noexcept {
  return Duration{static_cast<std::int64_t>(static_cast<double>(period.count()) * share)};
}

/// One bus and the thread that ticks the servos on it: CanHub, SerialHub.
class JointHub {
 public:
  virtual ~JointHub() = default;
  /// A setpoint has come. RT: yes. Thread: any.
  virtual void poke() noexcept = 0;
  /// Since the start. Thread: any.
  virtual std::uint64_t ticks() const noexcept = 0;
  virtual double tick_hz() const noexcept = 0;
};

/// Gives a servo its commands and hears its feedback; servo_group.hpp implements it.
/// Thread:  the hub's.   RT: yes.
class ServoOwner {
 public:
  virtual ~ServoOwner() = default;
  /// A tick of this hub begins: takes all commands of the tick at one moment.
  virtual void latch(const JointHub& hub) noexcept = 0;
  /// What joint `index` shall do now.
  virtual ServoCommand command(std::size_t index, Time now) noexcept = 0;
  /// After everything that changed the joint, and once a tick.
  virtual void feedback(std::size_t index, const ServoFeedback& feedback) noexcept = 0;
  /// False: all that had come has been read. True: a tick is over.
  virtual void settled(const JointHub& hub, bool tick) noexcept = 0;
};

/// Plans the load of each bus of a map by name, of which each has a `hub`, and starts its thread, once.
/// Errors:  those of configure() and start(); `why` names the bus. Thread: owner.
template <class Buses>
hal::Status start_hubs(Buses& opened, std::string& why) {
  for (auto& [name, bus] : opened) {
    if (bus.started) continue;
    if (auto planned = bus.hub->configure(why); !planned) {
      why = "bus '" + name + "': " + why;
      return planned;
    }
    if (auto started = bus.hub->start(); !started) {
      why = "bus '" + name + "': its thread does not start";
      return started;
    }
    bus.started = true;
  }
  return {};
}

/// What the threads of these buses asked for and did not get, one a line. From start_hubs() on. Thread: any.
template <class Buses>
std::vector<std::string> hub_shortfalls(const Buses& opened) {
  std::vector<std::string> all;
  for (const auto& [name, bus] : opened)
    if (const std::string what = bus.hub->shortfall(); !what.empty())
      all.push_back("thread of bus '" + name + "': " + what);
  return all;
}

}  // namespace sinew::drivers
