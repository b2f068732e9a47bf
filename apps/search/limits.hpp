#pragma once
// Limits that hold in every case, and what a case's faults excuse.
#include "apps/search/case.hpp"
#include "rt/graph_spec.hpp"

namespace sinew::search {

/// Source:  docs/search.md derives each.
struct Limits {
  double tilt_rad = 0.8;              // airborne; the position controller asks for 0.35 at most
  double tilt_error_rad = 0.10;       // estimate against truth while it says that it is valid
  double height_error_m = 0.30;       // likewise
  double landing_error_m = 0.15;      // as `sinew run` wants it
  double touchdown_speed_mps = 0.50;  // likewise
  double fall_mps2 = 6.0;             // a body without a command falls at least so fast
  Duration spin_down{300'000'000};    // motors are out by then: twelve times their lag
  Duration recovery{1'000'000'000};   // after a fault has ended, its effects may still be seen for so long
  Duration run{180'000'000'000};      // of virtual time: twice the mission's own time-out
};

/// What a case may do that an undisturbed flight may not.
struct Excuses {
  bool elsewhere = false;  // lands, but not on the pad, or never arms
  bool failsafe = false;   // the guardian may stop the motors in the air
};

/// From the robot's point of view: a loss that the filter, the mission, the lease and the robot file's failsafes bridge
/// excuses nothing. A longer loss of a sensor that only the position needs excuses the pad. A longer loss of a device
/// that holds the attitude excuses the flight.
Excuses excuses(const Case& c, const std::vector<rt::FailsafeSpec>& failsafes);

}  // namespace sinew::search
