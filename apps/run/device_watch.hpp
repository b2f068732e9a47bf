#pragma once
#include <functional>
#include <string>
#include <vector>

#include "hal/clock.hpp"

namespace sinew::app {

/// Follows what the devices of a run complain about: what to say when it changes, and what is left to say at the end.
/// Thread:  owner, below the loops.
class DeviceWatch {
 public:
  /// Complaints of now, one a line.
  using Ask = std::function<std::vector<std::string>()>;
  /// `told`: what has been said already and shall not be said as news.
  explicit DeviceWatch(Ask ask, std::vector<std::string> told = {});

  /// Asks. What changed, in lines to be said: a new complaint as it is, "over after 2.1 s: ..." of one that went. What
  /// comes and goes within kCalm counts as one, so that nothing flickers.
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
