#pragma once
#include <optional>

#include "apps/search/limits.hpp"
#include "apps/search/verdict.hpp"
#include "msg/flight.hpp"
#include "sim_hil/protocol.hpp"

namespace sinew::search {

/// The largest values of a flight, for the figures of a search.
struct Worst {
  double tilt_rad = 0, tilt_error_rad = 0, height_error_m = 0;
};

/// Checks the true motion. Invariants:
///   tilt      airborne it leans less than the limit, unless the guardian stopped the motors and was excused
///   thrust    airborne, without a command for longer than the motors need to run down, it falls
///   failsafe  the guardian finds no fault that the case does not excuse
///   estimate  attitude and height are true while the estimator calls them valid and no fault disturbs it
/// Thread:  owner.
class FlightCheck {
 public:
  FlightCheck(const Case& c, const Excuses& excused, const Limits& limits, Verdict& verdict);
  void truth(msg::Time at, const sim_hil::Truth& truth, msg::Time command_valid_until);
  void estimate(const msg::NavState& state);
  void guardian(msg::Time now, std::uint32_t faults);

  bool flew() const { return flew_; }
  bool airborne() const { return airborne_; }
  /// The guardian stopped the motors in the air, and was excused.
  bool fell() const { return fell_; }
  /// The guardian has stopped the motors for a fault: from then on it is no flight any more.
  bool failsafe_acted() const { return failsafe_acted_; }
  const Worst& worst() const { return worst_; }

 private:
  void check_fall(msg::Time at, const sim_hil::Truth& truth, msg::Time command_valid_until);

  const Case& case_;
  const Limits& limits_;
  const Excuses excuses_;
  Verdict& verdict_;
  sim_hil::Truth last_{};
  msg::Time last_at_{-1}, free_since_{-1};
  double free_from_mps_ = 0;
  bool flew_ = false, airborne_ = false, fell_ = false, failsafe_acted_ = false;
  Worst worst_;
};

}  // namespace sinew::search
