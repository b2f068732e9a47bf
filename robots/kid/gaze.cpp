#include "robots/kid/gaze.hpp"

#include <algorithm>
#include <string>

#include "motion/kept_numbers.hpp"
#include "robots/kid/devices.hpp"

namespace sinew::kid {

using namespace std::chrono_literals;
using msg::GazeAim;

namespace {

constexpr double kMostHeadJoint_rad = 7, kMostTo_m = 1000;

}  // namespace

Gaze::Gaze(robots::RobotBody robot) : robot_(std::move(robot)) {
  if (robot_.motions) params_ = robot_.motions->gaze;
}

void Gaze::declare(rt::Declaration& d) {
  d.in("gait", gait_, {.max_age = 100ms});
  d.in("motions", motions_, {.max_age = 100ms});
  d.in("joints", joints_, {.max_age = 100ms});
  d.in("command", command_, {.optional = true});
  d.out("head", head_, {.channels = plant::kKidHeadJoints});
  d.out("state", state_);
  d.state(kept_);
  for (const motion::Param<motion::GazeParams>& row : motion::kGazeParams)
    d.param(std::string(row.name), params_.*row.value,
            {.unit = row.unit, .min = row.least, .max = row.most, .doc = row.doc});
}

hal::Status Gaze::configure(rt::Setup& setup) {
  if (!robot_.body) {
    setup.explain("it needs [body] in the robot file (docs/bodies.md)");
    return hal::Error{hal::Errc::bad_argument, "a body"};
  }
  std::string why;
  figure_ = motion::Figure::make(*robot_.body, why);
  if (!figure_) {
    setup.explain(why);
    return hal::Error{hal::Errc::bad_argument, "a body that walks"};
  }
  limbs_ = kinematics::Limbs::of(*robot_.body);
  law_.emplace(*figure_);
  rad_.assign(figure_->joints(), 0);
  targets_.assign(figure_->joints(), 0);
  at_begin_.assign(motion::count_numbers(*law_), 0);
  motion::write_numbers(*law_, at_begin_);
  kept_ = at_begin_;
  return {};
}

void Gaze::reset() { std::ranges::copy(at_begin_, kept_.begin()); }

bool Gaze::aim(const msg::GazeCommand& command, const msg::GaitState& gait) noexcept {
  if (command.aim == GazeAim::rest || command.aim > GazeAim::point) return false;
  const math::Vec3 to(command.to);
  for (int i = 0; i < 3; ++i)
    if (!(math::fabs(to[i]) < kMostTo_m)) return false;
  const math::Quat turned =
      command.frame == msg::GazeFrame::robot ? math::Quat::from_axis_angle({0, 0, 1}, gait.heading_rad) : math::Quat{};
  const math::Vec3 at = command.frame == msg::GazeFrame::robot ? math::Vec3{gait.x_m, gait.y_m, 0} : math::Vec3{};
  if (command.aim == GazeAim::direction)
    law_->look_along(turned.rotate(to));
  else if (command.aim == GazeAim::point)
    law_->look_at(at + turned.rotate(to));
  else
    law_->look_level();
  return true;
}

rt::StepStatus Gaze::step(const rt::Step& step) noexcept {
  const msg::GaitState* gait = gait_.fresh(step.now);
  const msg::ActuatorCommand* motions = motions_.fresh(step.now);
  const msg::JointState* joints = joints_.fresh(step.now);
  if (!gait || !motions || !joints) return rt::StepStatus::stale;
  const std::vector<std::size_t>& head = limbs_.of(kinematics::Limb::head);
  for (std::size_t c = 0; c < head.size() && c < joints->count; ++c) {
    rad_[head[c]] = joints->position_rad[c];
    if (!(math::fabs(rad_[head[c]]) < kMostHeadJoint_rad)) return rt::StepStatus::fault;
    targets_[head[c]] = motions->value[c];
  }
  motion::read_numbers(*law_, kept_);
  law_->params = params_;
  const msg::GazeCommand* command = command_.get();
  const bool looks = command && motions->armed && msg::on_its_feet(gait->mode) && aim(*command, *gait);
  if (looks) {
    const kinematics::Pose torso{{gait->x_m, gait->y_m, gait->height_m}, math::Quat(gait->q_world_torso)};
    law_->step(torso, math::Vec3(gait->gyro_radps), rad_, msg::seconds(step.dt), targets_);
  } else {
    law_->reset();
  }
  motion::write_numbers(*law_, kept_);

  msg::ActuatorCommand& out = head_.loan();
  out = *motions;
  for (std::size_t c = 0; c < head.size(); ++c) out.value[c] = targets_[head[c]];
  msg::GazeState& state = state_.loan();
  state.stamp = joints->stamp;
  const auto target = [&](std::size_t joint) { return joint == kinematics::kNone ? 0 : targets_[joint]; };
  state.pan_rad = target(figure_->head_pan());
  state.tilt_rad = target(figure_->head_tilt());
  state.error_rad = law_->error_rad();
  state.aim = looks ? command->aim : GazeAim::rest;
  state.limited = law_->limited() ? 1 : 0;
  return rt::StepStatus::ok;
}

}  // namespace sinew::kid
