#pragma once
#include <deque>
#include <memory>
#include <string>
#include <vector>

#include "apps/learn/pad_camera.hpp"
#include "control/attitude_law.hpp"
#include "control/nav_estimator.hpp"
#include "control/position_law.hpp"
#include "control/rotor_allocation.hpp"
#include "robots/quad/landing_pilot.hpp"
#include "robots/quad/mission_plan.hpp"
#include "robots/quad/world/quad_world.hpp"

namespace sinew::learning {

struct FlightOptions {
  std::uint64_t seed = 1;  // of the world, as `sinew run --seed` has it
  /// For learning: little waiting before the landing begins, and the flight is over at the first touch or when the pad
  /// is lost. Otherwise the flight is that of quad_learned.toml.
  bool brief = false;
  double most_s = 60;  // virtual time
  bool keep_path = false;
};

/// How a flight ended.
struct FlightResult {
  bool good = false;  // as the world's verdict says: on the pad within 0.15 m, slower than 0.5 m/s, not crashed
  bool touched = false, crashed = false, lost = false;  // lost: the pad, or it did not land in time
  double error_m = 0, speed_mps = 0;                    // of a flight that touched down
  double time_s = 0;                                    // of the touch, from the start of the run
  double landing_s = 0;                                 // from the first decision to the touch
};

/// One landing on the simulated plant without pictures, in virtual time and in one thread: the plant in its steps of
/// 0.25 ms, the estimator, mission, position, attitude and mixer of robots/quad with their rates, and the delays of the
/// sensors. What is missing, beside pictures: the schedule's execution times, the guardian, failsafes and the motion
/// field.
/// Thread:  owner.
class LandingFlight {
 public:
  /// Errors:  those of the world.
  static hal::Result<std::unique_ptr<LandingFlight>> create(const FlightOptions& options);

  /// Flies on until the landing needs a decision (true), or the flight is over.
  bool next_decision();
  const control::LandingView& view() const { return pilot_.view; }
  void act(const control::LandingWish& wish) { pilot_.act(wish); }
  const FlightResult& result() const { return result_; }
  msg::Time now() const { return world_->now(); }
  /// True position, ten times a second from the first decision on; with keep_path.
  const std::vector<math::Vec3>& path() const { return path_; }

 private:
  LandingFlight(const FlightOptions& options, std::unique_ptr<plant::QuadWorld> world);
  void advance();  // by 1 ms
  void take(const plant::Due& due);
  bool hear();  // what has arrived by now; true: a decision is due
  void navigate();
  bool is_over();
  void finish();

  FlightOptions options_;
  std::unique_ptr<plant::QuadWorld> world_;
  PadCamera camera_;
  control::NavEstimator estimator_;
  control::MissionPlan mission_;
  control::PositionLaw position_;
  control::AttitudeLaw attitude_;
  control::LandingPilot pilot_;
  msg::NavState nav_;
  msg::AttitudeSetpoint wanted_;
  std::array<double, 4> motors_{};
  bool armed_ = false, begun_ = false, over_ = false, guided_ = false;
  std::deque<msg::RangeSample> ranges_;
  std::deque<msg::BaroSample> baros_;
  std::deque<msg::PadSighting> sightings_;
  std::int64_t ticks_ = 0;
  msg::Time begun_at_, done_at_;
  FlightResult result_;
  std::vector<math::Vec3> path_;
};

}  // namespace sinew::learning
