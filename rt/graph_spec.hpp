#pragma once
// One robot as plain data: what a robot file says, before anything is checked. Filled by apps (from TOML) or by hand.
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "msg/image.hpp"
#include "msg/safety.hpp"
#include "rt/declaration.hpp"

namespace sinew::rt {

class Module;

/// A value with the line of the robot file that gave it. 0: no line (built by code, or a default). Below 0: a number
/// that the maker of the spec gave to another source (an option of the command line).
template <class T>
struct Located {
  T value{};
  int line = 0;
};

/// How long a step takes in virtual time. `none` is an error there, never zero.
struct ExecModel {
  enum class Kind : std::uint8_t { none, constant, trace, measured, quantiles } kind = Kind::none;
  struct Quantile {
    double share;   // of all steps, 0..1
    Duration exec;  // that take at most this long
  };
  Duration constant{};
  std::vector<Duration> trace{};      // one entry a step, repeated from the start
  double factor = 1.0;                // measured, quantiles: times this
  std::vector<Quantile> quantiles{};  // both rise, the last share is 1; drawn anew for each step, linear in between
};

struct ModuleSpec {
  std::string name{};
  std::string type{};                                // "control::RateController"
  std::map<std::string, Located<std::string>> in{};  // port -> topic ("imu.raw")
  std::map<std::string, Located<ParamValue>> params{};
  ExecModel exec{};
  bool enabled = true;
  int line = 0;
  /// Per port of `in`, for inputs that hold the newest message: an older one is not there, as before the first.
  std::map<std::string, Duration> max_age{};
  /// Makes the module, in place of ModuleTypes: its ports come from the robot file.
  std::function<std::unique_ptr<Module>()> make{};
};

/// What releases a thread.
struct ThreadSpec {
  enum class Trigger : std::uint8_t { period, topics, device };
  enum class Overrun : std::uint8_t { skip, catch_up };
  std::string name{};
  int priority = 0;  // 1..98, SCHED_FIFO; 0: ordinary priority, best-effort modules allowed
  Trigger trigger = Trigger::period;
  Duration period{};                           // trigger period
  Duration phase{};                            // first release after the start; trigger period
  std::vector<Located<std::string>> topics{};  // trigger topics
  std::string device_module{};                 // trigger device: a module of `order` whose device() wakes the thread
  Duration timeout{};  // topics, device: releases the thread after this time without a release; 0: never
  Overrun overrun = Overrun::skip;
  std::uint32_t catch_up_max = 1;  // releases that may wait, with catch_up
  std::vector<int> cpus{};         // empty: any
  std::uint32_t stack_kib = 256;
  bool precise = false;                       // sleep until shortly before the release, then look at the clock
  std::vector<Located<std::string>> order{};  // modules, in the order in which they run
  int line = 0;
};

/// "imu.raw" as module and port; without a dot the second part is empty.
std::pair<std::string_view, std::string_view> split_topic(std::string_view name);
/// The topic of an output: "imu.raw" of module imu and port raw. A port with a '/' in its name names a remote topic as
/// a whole: "robot2/ball.model".
std::string topic_name(std::string_view module, std::string_view port);
/// A topic of a mate, or of all mates.
inline bool is_remote(std::string_view topic) { return topic.find('/') != std::string_view::npos; }

/// The periods that a thread may have.
inline constexpr Duration kShortestPeriod = std::chrono::microseconds(10), kLongestPeriod = std::chrono::hours(1);

/// A topic that is written from outside, by the mailbox. The part of its name before the dot names the module that
/// publishes it.
struct ExternalSpec {
  std::string type{};                                                  // of the message, "OperatorLink"
  std::string thread{};                                                // at whose cycles it comes in
  ExecModel exec{ExecModel::Kind::constant, Duration{1000}, {}, 1.0};  // of the module's step; its first topic's counts
};

struct TopicSpec {
  std::string name{};             // "camera.raw"
  std::uint32_t image_bytes = 0;  // capacity behind an image header
  std::uint32_t history = 0;      // messages kept for the tap; 0: as GraphSpec::tap_history says
  int line = 0;
  std::optional<ExternalSpec> external{};  // `writer = "external"`
  std::uint32_t image_pixels = 0;          // at most in an image; 0: as many as bytes
  bool wake_outsiders = false;             // the committing thread may wake a program that asks for it
};

struct ActuatorSpec {
  enum class Safe : std::uint8_t { stop, hold, damp, torque_off };
  struct Range {
    double min = 0, max = 0;
    bool holds(double v) const { return v >= min && v <= max; }
  };
  std::string name{};              // device name on the board ("motors")
  Located<std::string> command{};  // topic of ActuatorCommand ("mixer.motors")
  std::uint32_t channels = 0;
  double min = 0, max = 0;  // limits of every channel without its own
  double rate_per_s = 0;    // largest change; 0: no limit
  Duration lease{};
  Safe safe = Safe::stop;
  int line = 0;
  int channels_line = 0, limit_line = 0;  // 0: as `line`
  std::vector<Range> channel_limits{};    // one for each channel, or none

  Range limit(std::uint32_t channel) const {
    return channel < channel_limits.size() ? channel_limits[channel] : Range{min, max};
  }
};

struct ChainSpec {
  std::string name{};                 // "imu_to_motors"
  Located<std::string> from{}, to{};  // topics
  Duration budget{};
  int line = 0;
  double allowed_misses = 0;  // share of the messages that may be older
};

/// A condition on a topic that the guardian watches, and what it does about it.
struct FailsafeSpec {
  enum class Kind : std::uint8_t {
    silent,  // no message for `time`
    stuck,   // messages for `time` that differ in nothing but their stamp
    value,   // `field` below or above its limit, or not finite, for `time`
  };
  std::string name{};
  Located<std::string> topic{};
  Kind kind = Kind::silent;
  Duration time{};
  Located<std::string> field{};            // "voltage_v", "gyro_radps.x", "value[2]", "value[*]"
  std::optional<double> below{}, above{};  // at least one, of kind value
  msg::FailsafeAction action = msg::FailsafeAction::land;
  std::optional<Duration> stop_after{};  // a landing that takes longer becomes a stop
  int line = 0;
};

struct GuardianSpec {
  enum class Arming : std::uint8_t { automatic, manual };
  int priority = 99;
  Arming arming = Arming::automatic;
  std::vector<int> cpus{};
  ExecModel exec{ExecModel::Kind::constant, Duration{5000}, {}, 1.0};
  int line = 0;
};

struct GraphSpec {
  std::string robot{};
  std::string board{};                                          // "linux", "sim", "dataset"
  std::map<std::string, Located<std::string>> device_boards{};  // per device, where it differs
  std::uint64_t seed = 1;
  std::uint32_t virtual_cores = 1;  // N of the discrete-event executor
  /// Topics without a `history` keep the messages of this time for outsiders and for the time after a fault, if periods
  /// give their writer's rate; without a known rate they keep 50 messages, images 5. Zero: only the newest.
  Duration tap_history = std::chrono::milliseconds(500);
  std::vector<ThreadSpec> threads{};
  std::vector<ModuleSpec> modules{};
  std::vector<TopicSpec> topics{};
  std::vector<ActuatorSpec> actuators{};
  std::vector<ChainSpec> chains{};
  GuardianSpec guardian{};
  std::vector<FailsafeSpec> failsafes{};
  int board_line = 0;
};

/// One thing that is wrong with a robot file.
struct Problem {
  int line = 0;           // as of Located
  std::string key{};      // "thread.control.priority"
  std::string value{};    // as written
  std::string allowed{};  // what would be right
};

/// `file:line: key: value: what is allowed`; without a line `file: key: ...`.
std::string to_string(const Problem& problem, std::string_view file);

}  // namespace sinew::rt
