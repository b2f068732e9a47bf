#pragma once
// What a cycle of a half-duplex serial line takes, known before anything is opened: the check of a robot file and the
// hub of the open line call the same functions.
#include <span>
#include <string>

#include "drivers/joints/serial_servo.hpp"

namespace sinew::drivers {

struct SerialLineRate {
  std::uint32_t bit_rate = 1'000'000;
  double tick_hz = 100;
  bool fast_read = false;  // one answer for all (2.0)
  /// How late bytes come in at the most that the line has carried: a USB adapter's latency timer and packets.
  Duration latency{std::chrono::milliseconds(1)};
};

/// One cycle: goals, answers of all, and one question to one servo.
struct SerialPlan {
  std::size_t servos = 0;
  SerialLineRate rate;
  Duration goals{}, answers{}, slow{}, adapter{};  // adapter: the latency after each question
  bool may_read_fast = false;                      // it does not, and its servos could

  Duration sum() const { return goals + answers + slow + adapter; }
  bool fits() const { return msg::seconds(sum()) * rate.tick_hz <= 1; }
};
SerialPlan plan_serial(std::span<const SerialServo* const> servos, const SerialLineRate& rate);
/// "20 servos at 200 Hz need 8 of 5 ms: goals 1.14, answers 4.54, one slow register 0.32, the adapter 2".
std::string sum_text(const SerialPlan& plan);
/// The same with what helps: "...: fewer servos on the line, a lower tick_hz, or a higher bit_rate, or fast_read".
std::string to_string(const SerialPlan& plan);

/// How the servos of a line are read in each cycle: all at once, or one by one.
enum class CycleRead : std::uint8_t { sync, fast, bulk, single };
CycleRead cycle_read(const wire::ServoModel& model, bool fast);

/// Servos that cannot share a line: numbers that are there twice, packets of 1.0 and 2.0. Empty: fine. `why` names both
/// joints; `second` is the place of the later one.
struct SerialClash {
  std::size_t second = 0;
  std::string key, why;
};
std::vector<SerialClash> find_serial_clashes(std::span<const SerialServo* const> servos);

}  // namespace sinew::drivers
