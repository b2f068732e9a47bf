#pragma once
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace sinew::app {

/// What a simulator says about a run (its Report), for the summary only; no module ever sees it.
/// Source:  docs/sinew-sim.md lists the keys. A simulator of somebody else may leave out any of them.
struct WorldReport {
  struct Fault {
    std::string text, device;  // docs/faults.md
    std::uint64_t affected = 0;
  };
  /// A figure of the run, with its limit.
  struct Measure {
    std::string key, label, unit;
    double value = 0;
    std::optional<double> at_most{}, at_least{};
  };
  /// The world's verdict on the run.
  struct Verdict {
    std::string outcome;  // in words: "landed on the pad"
    bool good = false;
    bool begun = true;  // something happened that can be judged
    std::vector<Measure> measures{};
  };

  bool valid = false;
  std::string reason;        // why it is not valid
  double imu_gap_max_s = 0;  // real time, by the clock of the plant's machine whatever the rate
  std::uint64_t frames = 0, render_late = 0;
  bool still = true;               // nothing is driven, nothing moves; true if the simulator does not say
  std::optional<Verdict> verdict;  // none: the simulator does not judge
  std::vector<Fault> faults;       // that the plant was asked to play, and played

  bool is_faulty(const std::string& device) const;
  /// A number among the world's other keys; truths are 0 and 1. Missing: 0.
  double number(std::string_view key) const;

  std::map<std::string, double, std::less<>> numbers{};
};

/// Nothing when the text is not a report.
std::optional<WorldReport> parse_report(const std::string& json);

/// "0.043 m   (limit 0.15 m)"
std::string to_string(const WorldReport::Measure& measure);

}  // namespace sinew::app
