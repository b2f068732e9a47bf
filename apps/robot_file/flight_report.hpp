#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace sinew::app {

/// What the plant of a head says about its following.
struct FollowReport {
  bool acquired = false;  // had the ball in the middle of its picture once; all below counts from there
  double in_view_share = 0;
  double angle_rms_deg = 0;  // between the optical axis and the ball
  double level_rms_deg = 0;  // of that, in elevation
  double roll_rms_deg = 0, base_tilt_rms_deg = 0;
  double longest_loss_s = 0;
};

/// What the plant says about a run (its Report), for the summary only; no module ever sees it.
struct FlightReport {
  struct Fault {
    std::string text, device;  // docs/faults.md
    std::uint64_t affected = 0;
  };

  bool valid = false;
  std::string reason;  // why it is not valid
  bool touched_down = false, crashed = false;
  double landing_error_m = 0;  // from the pad's centre, horizontally, at rest
  double touchdown_speed_mps = 0;
  double touchdown_s = 0;    // plant time
  double imu_gap_max_s = 0;  // real time, by the clock of the plant's machine whatever the rate
  std::uint64_t frames = 0, render_late = 0;
  bool still = true;                   // at rest with stopped motors; of plants that do not say, taken as true
  std::optional<FollowReport> follow;  // of a world in which something is followed
  std::vector<Fault> faults;           // that the plant was told to play, and has

  bool is_faulty(const std::string& device) const;
};

inline constexpr double kGoodLandingError_m = 0.15, kGoodTouchdownSpeed_mps = 0.5;

inline constexpr double kGoodInViewShare = 0.95, kGoodAngle_deg = 3;

/// Nothing when the text is not a report.
std::optional<FlightReport> parse_report(const std::string& json);

bool soft_landing(const FlightReport& report);  // wherever
bool good_landing(const FlightReport& report);  // and on the pad
bool good_following(const FollowReport& report);

}  // namespace sinew::app
