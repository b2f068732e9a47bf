#pragma once
// Faults that the plant plays on request: of which device, which kind, from when to when. docs/faults.md.
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "hal/clock.hpp"
#include "math/random.hpp"

namespace sinew::plant {

enum class FaultDevice : std::uint8_t {
  imu,
  range,
  baro,
  battery,
  camera,
  motors,
  link,
  joints,
  head,
  radio,
  soles,
  left_arm,
  right_arm,
  left_leg,
  right_leg,
  referee,
  gripper
};
enum class FaultKind : std::uint8_t {
  off,           // nothing comes any more
  stuck,         // the same values again, with new stamps
  garbage,       // numbers or pixels without sense: NaN, infinite, huge, random
  wrong,         // plausible but not true; amount: by how much (docs/faults.md)
  slow,          // one of `amount` comes
  delayed,       // ready later by `amount` seconds
  intermittent,  // silent for bursts of `amount` seconds on average, with pauses of as long
  duplicated,    // everything twice
  closed,        // the connection goes away for good
};
inline constexpr FaultDevice kFaultDevices[] = {
    FaultDevice::imu,       FaultDevice::range,    FaultDevice::baro,      FaultDevice::battery, FaultDevice::camera,
    FaultDevice::joints,    FaultDevice::soles,    FaultDevice::motors,    FaultDevice::head,    FaultDevice::left_arm,
    FaultDevice::right_arm, FaultDevice::left_leg, FaultDevice::right_leg, FaultDevice::gripper, FaultDevice::radio,
    FaultDevice::referee,   FaultDevice::link};
inline constexpr FaultKind kFaultKinds[] = {FaultKind::off,          FaultKind::stuck,      FaultKind::garbage,
                                            FaultKind::wrong,        FaultKind::slow,       FaultKind::delayed,
                                            FaultKind::intermittent, FaultKind::duplicated, FaultKind::closed};

std::string_view to_string(FaultDevice device);
/// It takes commands.
constexpr bool is_actuator(FaultDevice device) {
  return device == FaultDevice::motors || device == FaultDevice::head || device == FaultDevice::gripper ||
         (device >= FaultDevice::left_arm && device <= FaultDevice::right_leg);
}
std::string_view to_string(FaultKind kind);

/// Null when this device can have this fault, else the reason why not.
const char* why_not(FaultDevice device, FaultKind kind);

inline constexpr std::int64_t kNoEnd = std::numeric_limits<std::int64_t>::max();

struct Fault {
  FaultDevice device{};
  FaultKind kind{};
  std::int64_t from_ns = 0, until_ns = kNoEnd;  // plant time of the measurement or the command: from <= t < until
  double amount = 0;                            // see FaultKind; the default of device and kind when none was given
  std::size_t robot = 0;                        // whose device it is, in a world with several robots

  bool acts_at(hal::Time t) const { return t.ns >= from_ns && t.ns < until_ns; }
};

/// "imu:stuck@5+0.5", "camera:delayed(80ms)@3..6", "range:off@4": DEVICE:KIND[(AMOUNT)]@FROM[+LENGTH|..UNTIL].
/// Times are seconds unless they end with ms, us or s.
/// Errors:  nothing is returned; `why` says what is wrong and what is allowed.
std::optional<Fault> parse_fault(std::string_view text, std::string& why);
/// parse_fault() reads it back.
std::string to_string(const Fault& fault);

/// The faults of one run and how often each has struck.
/// Thread:  owner.
class FaultLog {
 public:
  struct Entry {
    Fault fault;
    std::uint64_t affected = 0;  // samples, frames or commands
    hal::Time first{};           // of them, plant time; only while affected is not 0

    void strike(hal::Time t, std::uint64_t count = 1) {
      if (affected == 0) first = t;
      affected += count;
    }
  };
  FaultLog() = default;
  FaultLog(const std::vector<Fault>& faults, std::uint64_t seed);
  std::vector<Entry>& entries() { return entries_; }
  const std::vector<Entry>& entries() const { return entries_; }
  std::uint64_t seed() const { return seed_; }

 private:
  std::vector<Entry> entries_;
  std::uint64_t seed_ = 0;
};

/// The effect of a fault on one sample, frame or command.
struct FaultEffect {
  bool lost = false, stuck = false, garbage = false, duplicated = false;
  std::optional<double> wrong;
  hal::Duration delay{0};
};

/// The faults of one device, those of the connection included. Randomness comes from the run's seed and the fault's
/// place in the list, so bursts of a connection hit all devices at the same times.
/// Thread:  owner.
class DeviceFaults {
 public:
  /// `log` outlives this. `bus`: another device whose faults, but for `wrong`, strike here too: the bus that both
  /// share.
  DeviceFaults(FaultLog& log, FaultDevice device, std::optional<FaultDevice> bus = std::nullopt);
  bool any() const { return !faults_.empty(); }
  /// Once for each sample, with its stamp; stamps never decrease.
  FaultEffect next(hal::Time stamp);
  math::Random& random() { return random_; }

 private:
  struct Running {
    FaultLog::Entry* entry = nullptr;
    std::uint64_t seen = 0;      // by slow
    math::Random random;         // for the bursts
    std::int64_t toggle_ns = 0;  // next begin or end of a burst
    bool silent = false;
  };
  static bool silent(Running& r, hal::Time t);
  static void apply(Running& r, hal::Time t, FaultEffect& effect);
  std::vector<Running> faults_;
  math::Random random_;
};

}  // namespace sinew::plant
