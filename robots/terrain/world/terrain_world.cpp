#include "robots/terrain/world/terrain_world.hpp"

#include <mujoco/mujoco.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "sim_hil/worlds/json_object.hpp"
#include "sim_hil/worlds/wind.hpp"

namespace sinew::plant {
namespace {

constexpr double kStep_s = 1e-9 * kStepNs;
constexpr double kLeastFlown_m = 30;  // over the terrain
constexpr double kStartAcross_m = 2;  // the way over the ground differs from seed to seed
constexpr double kMostTurned_rad = 0.03;

}  // namespace

void HeightScore::add(double height_m, double speed_mps, double dt_s) {
  constexpr double kSlowest_mps = 0.1;  // slower than that the right height is on the ground
  const double right_m = std::max(speed_mps, kSlowest_mps) / motion_radps_;
  const double off = height_m / right_m - 1;
  smooth_ = seconds_ == 0 ? off : smooth_ + dt_s / kMoment_s * (off - smooth_);
  seconds_ += dt_s;
  within_s_ += std::fabs(off) <= kMostOff ? dt_s : 0;
  off2_sum_ += off * off * dt_s;
  speed_sum_ += speed_mps * dt_s;
  height_sum_ += height_m * dt_s;
  least_m_ = std::min(least_m_, height_m);
  most_ = std::max(most_, std::fabs(smooth_));
}

double HeightScore::off_rms() const { return seconds_ > 0 ? std::sqrt(off2_sum_ / seconds_) : 0; }

struct TerrainWorld::Impl {
  Impl(const TerrainOptions& o, ModelPtr m)
      : options(o),
        model(std::move(m)),
        data(mj_makeData(model.get())),
        wind({o.quad.gust_mps, o.quad.wind_mps, o.quad.wind_toward_rad}, o.quad.seed),
        score(o.motion_radps) {
    math::Random draw(o.quad.seed, 0x74657272);
    QuadOptions quad_options = o.quad;
    quad_options.start_x_m = 0;
    quad_options.start_y_m = lane_m(o.terrain) + draw.uniform(-kStartAcross_m, kStartAcross_m);
    quad_options.start_heading_rad = draw.uniform(-kMostTurned_rad, kMostTurned_rad);
    quad = std::make_unique<Quad>(quad_options, *model, *data, 0, std::span<const Quad* const>(&seen, 1));
    seen = quad.get();
  }
  msg::Time now() const { return {steps * kStepNs}; }
  double height_m() const {
    const msg::Vec3 p = quad->truth().p_world_m;
    return p.z - ground_m(options.terrain, p.x, p.y - lane_m(options.terrain));
  }
  void judge();

  TerrainOptions options;
  ModelPtr model;
  DataPtr data;
  Wind wind;
  const Quad* seen = nullptr;
  std::unique_ptr<Quad> quad;
  HeightScore score;
  double flown_m = 0;  // over the terrain
  std::int64_t steps = 0;
};

void TerrainWorld::Impl::judge() {
  const FlightSummary& flight = quad->summary();
  if (steps % kTruthSteps != 0 || !flight.flew || flight.touched_down) return;
  const TruthState truth = quad->truth();
  if (truth.p_world_m.x < kCourseBegin_m || truth.p_world_m.x > kCourseEnd_m) return;
  flown_m = std::max(flown_m, truth.p_world_m.x - kCourseBegin_m);
  const msg::Vec3& v = truth.v_world_mps;
  score.add(height_m(), std::sqrt(v.x * v.x + v.y * v.y), kTruthSteps * kStep_s);
}

TerrainWorld::TerrainWorld(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
TerrainWorld::~TerrainWorld() = default;

hal::Result<std::unique_ptr<TerrainWorld>> TerrainWorld::create(const TerrainOptions& options) {
  auto model = load_room(terrain_room(), RoomUse::physics);
  if (!model) return model.error();
  auto impl = std::make_unique<Impl>(options, std::move(*model));
  if (!impl->quad->start()) return hal::Error{hal::Errc::bad_argument, "no room to start"};
  mj_forward(impl->model.get(), impl->data.get());
  return std::unique_ptr<TerrainWorld>(new TerrainWorld(std::move(impl)));
}

void TerrainWorld::advance(std::span<const RobotCommand> commands) {
  Impl& w = *impl_;
  w.quad->apply_forces(commands[0], w.wind.step(kStep_s));
  mj_forwardSkip(w.model.get(), w.data.get(), mjSTAGE_NONE, 1);
  w.quad->integrate();
  ++w.steps;
  w.quad->watch_contacts(w.now());
  w.quad->sample(w.steps);
  w.judge();
}

msg::Time TerrainWorld::now() const { return impl_->now(); }
const Due& TerrainWorld::due() const { return impl_->quad->due(); }
WorldTruth TerrainWorld::ground_truth() const { return impl_->quad->ground_truth(); }
Scene TerrainWorld::scene(std::size_t camera) const { return impl_->quad->scene(camera); }
bool TerrainWorld::still() const { return impl_->quad->still(); }
Quad& TerrainWorld::quad() { return *impl_->quad; }
const HeightScore& TerrainWorld::score() const { return impl_->score; }
double TerrainWorld::height_m() const { return impl_->height_m(); }

void TerrainWorld::add_to(JsonObject& j) const {
  const FlightSummary& flight = impl_->quad->summary();
  j.boolean("flew", flight.flew);
  j.boolean("touched_ground", flight.touched_down);
  j.number("flown_m", impl_->flown_m);
  j.number("height_m", height_m());
  j.number("height_mean_m", impl_->score.mean_height_m());
  j.number("speed_mean_mps", impl_->score.mean_speed_mps());
  j.number("off_rms", impl_->score.off_rms());
  j.boolean("at_rest", impl_->quad->at_rest());
  j.boolean("motors_stopped", impl_->quad->motors_stopped());
}

Verdict TerrainWorld::verdict() const {
  const FlightSummary& flight = impl_->quad->summary();
  const HeightScore& score = impl_->score;
  Verdict verdict;
  verdict.begun = flight.flew;
  const bool there = score.seconds() > 0, far = impl_->flown_m >= kLeastFlown_m;
  const bool held = there && score.off_most() <= HeightScore::kMostOff;
  verdict.measures = {{"flown_m", "flown over the terrain", "m", impl_->flown_m, kLeastFlown_m, true}};
  if (there) {
    verdict.measures.push_back({"height_off_percent", "height off the right one, at most for a second", "%",
                                100 * score.off_most(), 100 * HeightScore::kMostOff});
    verdict.measures.push_back({"height_off_rms_percent", "RMS of that at any instant", "%", 100 * score.off_rms()});
    verdict.measures.push_back(
        {"within_percent", "time within 25 % of the right height", "%", 100 * score.share_within()});
    verdict.measures.push_back({"clearance_m", "least height over the ground", "m", score.least_m()});
    verdict.measures.push_back({"height_mean_m", "mean height over the ground", "m", score.mean_height_m()});
    verdict.measures.push_back({"speed_mean_mps", "mean speed over the ground", "m/s", score.mean_speed_mps()});
  }
  verdict.conditions = {{"wind_max_mps", "strongest wind", "m/s", flight.wind_max_mps, 1.0}};
  if (!flight.flew)
    verdict.outcome = "did not fly";
  else if (flight.touched_down)
    verdict.outcome = "touched the ground";
  else if (!far)
    verdict.outcome = "did not get over the terrain";
  else if (!held)
    verdict.outcome = "flew over the terrain at a wrong height";
  else
    verdict.outcome = "held its height over the terrain";
  verdict.good = flight.flew && !flight.touched_down && far && held;
  return verdict;
}

std::string TerrainWorld::outcome() const {
  const FlightSummary& flight = impl_->quad->summary();
  char text[160];
  std::snprintf(text, sizeof text, "%s after %.1f m over the terrain; height %.2f m, off by %.0f %% RMS",
                flight.touched_down ? "touched the ground"
                : flight.flew       ? "in the air"
                                    : "did not fly",
                impl_->flown_m, height_m(), 100 * impl_->score.off_rms());
  return text;
}

}  // namespace sinew::plant
