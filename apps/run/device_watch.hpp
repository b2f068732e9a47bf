#pragma once
#include <functional>
#include <string>
#include <vector>

#include "hal/clock.hpp"

namespace sinew::app {

/// Follows the complaints of a run's devices: lines to print on a change, and the complaints left at the end.
/// Thread:  owner, below the loops.
class DeviceWatch {
 public:
  /// The complaints at this time, one a line.
  using Ask = std::function<std::vector<std::string>()>;
  /// `told`: complaints that were printed already and are no news.
  explicit DeviceWatch(Ask ask, std::vector<std::string> told = {});

  /// Asks, and returns the changes as lines to print: a new complaint as it is, "over after 2.1 s: ..." for one that
  /// ended. A complaint that comes again within kCalm counts as the same one, so that nothing flickers.
  std::vector<std::string> look(hal::Time now);
  /// Complaints of the last look() that are not over.
  std::vector<std::string> now() const;
  /// All of the run, each once in the order of their coming: "head.tilt (cia402 2 on can0): absent (at the end)".
  std::vector<std::string> all() const;

  static constexpr hal::Duration kCalm = std::chrono::seconds(2);

 private:
  struct Complaint {
    std::string text;
    hal::Time came, seen;  // seen: last
    bool lasts = true;
    unsigned times = 0;
    hal::Duration length{0};  // of the times before this one
  };
  Ask ask_;
  std::vector<std::string> told_;
  std::vector<Complaint> complaints_;
};

}  // namespace sinew::app
