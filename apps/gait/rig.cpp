#include "apps/gait/rig.hpp"

#include <algorithm>

namespace sinew::gait {
namespace {

constexpr double kCarpet_m = 20;  // beyond the lines: no course of a minute leaves it over its edge

}  // namespace

std::unique_ptr<Rig> Rig::create(const GaitSetup& setup, std::uint64_t seed, std::string& why,
                                 const plant::PitchPlace& start, bool has_ball) {
  const auto figure = motion::Figure::make(setup.body, why);
  if (!figure) return nullptr;
  std::unique_ptr<Rig> rig(new Rig(setup, *figure));
  plant::PitchBody robot{
      .body = setup.body, .start = start, .errors = setup.errors, .gain_per_rad = setup.book.walk.servo_gain_per_rad};
  if (robot.start.joints_rad.empty()) {  // as it stands before it walks
    motion::Walk walk = rig->make_walk();
    motion::Sensed upright;
    std::vector<double> zero(figure->joints());
    upright.joints_rad = zero;
    upright.accel_mps2 = {0, 0, 9.81};
    walk.reset(upright);
    walk.step({}, upright, kControl_s, rig->targets());
    robot.start.joints_rad.assign(rig->targets().begin(), rig->targets().end());
  }
  plant::FieldSize field;
  field.border_m = kCarpet_m;
  auto pitch = plant::Pitch::create(
      {.ground = setup.ground, .field = field, .has_ball = has_ball, .ball_at = {.x_m = -2}}, {&robot, 1}, seed, &why);
  if (!pitch) {
    if (why.empty()) why = "the pitch cannot be made";
    return nullptr;
  }
  rig->pitch_ = std::move(*pitch);
  std::copy(robot.start.joints_rad.begin(), robot.start.joints_rad.end(), rig->targets_rad_.begin());
  return rig;
}

motion::Walk Rig::make_walk() const {
  motion::Walk walk(figure_, setup_->book.rest_rad);
  walk.params = setup_->book.walk;
  walk.kick_forward = setup_->book.step_kick_forward;
  walk.kick_outward = setup_->book.step_kick_outward;
  return walk;
}

motion::Sensed Rig::sense() {
  const plant::BodySensors& s = pitch_->sensors(0);
  for (std::size_t j = 0; j < figure_.joints(); ++j) measured_rad_[j] = s.joint[j].position_rad;
  return {std::span(measured_rad_).first(figure_.joints()), s.gyro_radps, s.accel_mps2, s.cell_n};
}

void Rig::act(std::span<const double> targets_rad) {
  pitch_->command(0, targets_rad);
  for (int i = 0; i < kPlantSteps; ++i) pitch_->step();
}

}  // namespace sinew::gait
