#include "apps/learn/landing_flight.hpp"

namespace sinew::learning {
namespace {

constexpr int kNavigateTicks = 5, kPathTicks = 100;  // of 1 ms
constexpr double kAfterDone_s = 3;                   // for coming to rest

bool arrived(msg::Time stamp, std::int64_t delay_ns, msg::Time now) { return stamp.ns + delay_ns <= now.ns; }

}  // namespace

hal::Result<std::unique_ptr<LandingFlight>> LandingFlight::create(const FlightOptions& options) {
  plant::QuadOptions quad;
  quad.seed = options.seed;
  quad.free_flight = true;
  auto world = plant::QuadWorld::create(quad);
  if (!world) return world.error();
  return std::unique_ptr<LandingFlight>(new LandingFlight(options, std::move(*world)));
}

LandingFlight::LandingFlight(const FlightOptions& options, std::unique_ptr<plant::QuadWorld> world)
    : options_(options), world_(std::move(world)), camera_(options.seed) {
  if (!options.brief) return;
  mission_.params.settle_s = 0.6;
  mission_.params.spin_up_s = 0.3;
  mission_.params.look_s = 0.3;
  mission_.params.climb_mps = 1.0;
}

void LandingFlight::take(const plant::Due& due) {
  if (due.imu) estimator_.add_imu(due.imu_sample);
  if (due.range) ranges_.push_back(due.range_sample);
  if (due.baro) baros_.push_back(due.baro_sample);
  if (due.cameras != 0) sightings_.push_back(camera_.look(world_->quad().camera_pose(), world_->now()));
}

bool LandingFlight::hear() {
  const msg::Time now = world_->now();
  while (!ranges_.empty() && arrived(ranges_.front().stamp, plant::kRangeDelayNs, now)) {
    estimator_.add_range(ranges_.front());
    ranges_.pop_front();
  }
  while (!baros_.empty() && arrived(baros_.front().stamp, plant::kBaroDelayNs, now)) {
    estimator_.add_baro(baros_.front());
    baros_.pop_front();
  }
  bool due = false;
  while (!sightings_.empty() && arrived(sightings_.front().stamp, camera_.delay().count(), now)) {
    if (estimator_.started()) {
      if (pilot_.see(sightings_.front(), nav_)) due = true;
      estimator_.add_pad(sightings_.front());
      guided_ = true;
    }
    sightings_.pop_front();
  }
  return due;
}

void LandingFlight::navigate() {
  const math::Vec3 guide = pilot_.velocity_mps();
  mission_.set_guide(guided_ ? &guide : nullptr);
  const double dt_s = 1e-3 * kNavigateTicks;
  mission_.step(world_->now(), nav_, dt_s);
  wanted_ = position_.step(nav_, mission_.setpoint(), dt_s);
}

void LandingFlight::advance() {
  for (int i = 0; i < plant::kImuSteps; ++i) take(world_->step(motors_));
  ++ticks_;
}

bool LandingFlight::next_decision() {
  while (!over_) {
    advance();
    estimator_.set_motors_stopped(!armed_);
    const bool due = hear();
    if (estimator_.started()) {
      nav_ = estimator_.output();
      if (ticks_ % kNavigateTicks == 0) navigate();
      const msg::WrenchSetpoint wrench = attitude_.step(nav_, wanted_, 1e-3);
      armed_ = wrench.armed != 0;
      motors_ = armed_ ? control::allocate(math::Vec3(wrench.torque_nm), wrench.thrust_n, {}).command
                       : std::array<double, 4>{};
    }
    const bool landing = mission_.state().phase == msg::MissionPhase::descend;
    if (landing && !begun_) {
      begun_ = true;
      begun_at_ = world_->now();
    }
    if (begun_ && options_.keep_path && ticks_ % kPathTicks == 0 && !world_->quad().summary().touched_down)
      path_.push_back(math::Vec3(world_->quad().truth().p_world_m));
    if (is_over()) return finish(), false;
    if (due && landing) return true;
  }
  return false;
}

bool LandingFlight::is_over() {
  if (ticks_ % 10 != 0) return false;
  const plant::Quad& quad = world_->quad();
  const msg::MissionPhase phase = mission_.state().phase;
  const double now_s = msg::seconds(world_->now());
  if (now_s > options_.most_s || quad.summary().crashed) return true;
  if (options_.brief) {
    const bool lost = begun_ && (phase == msg::MissionPhase::search || phase == msg::MissionPhase::abort);
    return lost || quad.summary().touched_down || phase == msg::MissionPhase::done;
  }
  if (phase != msg::MissionPhase::done) {
    done_at_ = world_->now();
    return false;
  }
  return quad.still() || msg::seconds(world_->now() - done_at_) > kAfterDone_s;
}

void LandingFlight::finish() {
  over_ = true;
  const plant::Quad& quad = world_->quad();
  const plant::FlightSummary& flight = quad.summary();
  result_.touched = flight.touched_down;
  result_.crashed = flight.crashed;
  result_.lost = !flight.touched_down;
  result_.good = quad.verdict().good;
  result_.error_m = options_.brief ? flight.touchdown_error_m : quad.pad_distance_m();
  result_.speed_mps = flight.touchdown_speed_mps;
  result_.time_s = msg::seconds(flight.touched_down ? flight.touchdown_at : world_->now());
  result_.landing_s =
      begun_ ? msg::seconds((flight.touched_down ? flight.touchdown_at : world_->now()) - begun_at_) : 0;
}

}  // namespace sinew::learning
