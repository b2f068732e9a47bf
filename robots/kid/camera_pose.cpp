#include "robots/kid/camera_pose.hpp"

#include <algorithm>

namespace sinew::kid {

using namespace std::chrono_literals;

namespace {

constexpr rt::Duration kPatience = 100ms;
/// What moves the camera against the ground.
constexpr std::array kOfTheChain{kinematics::Limb::head, kinematics::Limb::left_leg, kinematics::Limb::right_leg};

}  // namespace

void CameraPose::declare(rt::Declaration& d) {
  d.in("image", image_);
  d.in("gait", gait_, {.max_age = 100ms});
  for (const kinematics::Limb limb : kOfTheChain)
    d.in(std::string(to_string(limb)) + "_joints", joints_[static_cast<std::size_t>(limb)], {.max_age = 100ms});
  d.out("pose", out_);
  d.param("place", place_, {.doc = "name of the camera among the body's places"});
  d.state(rad_, history_, seen_, waits_);
}

hal::Status CameraPose::configure(rt::Setup& setup) {
  if (!robot_.body) {
    setup.explain("it needs [body] in the robot file (docs/bodies.md)");
    return hal::Error{hal::Errc::bad_argument, "a body"};
  }
  std::string why;
  figure_ = motion::Figure::make(*robot_.body, why);
  if (!figure_) {
    setup.explain(why);
    return hal::Error{hal::Errc::bad_argument, "a body with two legs"};
  }
  const kinematics::Place* place = robot_.body->find_place(place_);
  if (!place) {
    std::string known;
    for (const kinematics::Place& p : robot_.body->places) known += " " + p.name;
    setup.explain("the body has no place '" + place_ + "'; known:" + known);
    return hal::Error{hal::Errc::bad_argument, "a place"};
  }
  limbs_ = kinematics::Limbs::of(*robot_.body);
  chain_.emplace(*figure_, *place);
  rad_.assign(robot_.body->joints(), 0);
  return {};
}

void CameraPose::reset() {
  std::ranges::fill(rad_, 0);
  history_ = {};
  seen_ = waits_ = {};
}

rt::StepStatus CameraPose::step(const rt::Step& step) noexcept {
  for (const kinematics::Limb limb : kOfTheChain) {
    const auto i = static_cast<std::size_t>(limb);
    const msg::JointState* state = joints_[i].fresh(step.now);
    for (std::size_t c = 0; state && c < limbs_.joints[i].size() && c < state->count; ++c)
      rad_[limbs_.joints[i][c]] = state->position_rad[c];
  }
  const msg::GaitState* gait = gait_.fresh(step.now);
  if (gait && msg::on_its_feet(gait->mode)) {
    const kinematics::Pose camera = chain_->camera(math::Quat(gait->q_world_torso), {gait->x_m, gait->y_m}, rad_);
    if (math::is_finite(camera.p_m) && math::is_finite(camera.q)) history_.add(gait->stamp.ns, camera);
  }
  if (const msg::Image* image = image_.get(); image && image->stamp != seen_) seen_ = waits_ = image->stamp;
  if (waits_ == rt::Time{}) return rt::StepStatus::ok;

  kinematics::Pose pose;
  const auto found = history_.at(waits_.ns, pose);
  if (found == motion::CameraHistory::Found::not_yet)
    return step.now - waits_ > kPatience ? rt::StepStatus::stale : rt::StepStatus::ok;
  const rt::Time of = std::exchange(waits_, rt::Time{});
  if (found == motion::CameraHistory::Found::too_old) return rt::StepStatus::stale;
  msg::CameraPose& out = out_.loan();
  out.stamp = of;
  out.p_world_m = pose.p_m.to<msg::Vec3>();
  out.q_world_optical = pose.q.to<msg::Quat>();
  return rt::StepStatus::ok;
}

}  // namespace sinew::kid
