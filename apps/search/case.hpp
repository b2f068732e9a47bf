#pragma once
// One case of the search: a world, the jitter of every module and a few faults, written as one line of text.
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "msg/time.hpp"

namespace sinew::search {

using msg::Duration;
using msg::Time;

inline constexpr std::int64_t kMsNs = 1'000'000;  // nanoseconds of a millisecond

/// A fault that the plant plays on one device for a while; docs/faults.md says what each does.
struct Fault {
  std::string device, kind;
  double amount = 0;  // delayed, intermittent: milliseconds; else as docs/faults.md says; 0: the kind's usual one
  Time from;          // whole milliseconds
  Duration length{};
  Time until() const { return from + length; }
  bool lies() const { return kind == "stuck" || kind == "wrong"; }
  bool operator==(const Fault&) const = default;
};

/// A module whose steps take longer than measured.
struct Stress {
  std::string module;
  double factor = 1.0;
  bool operator==(const Stress&) const = default;
};

struct Case {
  std::uint64_t world = 1;   // seed of the plant: start, wind, spread, noise
  std::uint64_t jitter = 1;  // seed of the graph: every draw of an execution time
  double gust_mps = 0;
  bool nominal = false;  // the robot file's own execution times instead of the measured distributions
  std::vector<Stress> stress;
  std::vector<Fault> faults;
  bool operator==(const Case&) const = default;

  double stress_of(std::string_view module) const;
  /// Some fault acts at `t`, or did within `after` before it.
  bool disturbed(Time t, Duration after) const;
  /// Some device gave values that were plausible but false, at `t` or before: estimates based on them are wrong for
  /// long.
  bool lied_to(Time t) const;
};

/// "world=77 jitter=12 gust=1.5 stress=pad*2.5 fault=imu:off@5.003+0.001": what is not written has its default.
std::string to_string(const Case& c);
/// Errors:  nothing, with the wrong word and what is allowed in `why`. The plant itself checks a fault's device, kind
///          and amount.
std::optional<Case> parse_case(std::string_view text, std::string& why);
/// A fault as the plant reads it: "imu:delayed(3ms)@5.003+0.002".
std::string to_string(const Fault& fault);

}  // namespace sinew::search
