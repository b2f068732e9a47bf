#include "robots/kid/camera_pose.hpp"

namespace sinew::kid {

using namespace std::chrono_literals;

namespace {

constexpr rt::Duration kPatience = 100ms;

}  // namespace

void CameraPose::declare(rt::Declaration& d) {
  d.in("image", image_);
  d.in("gait", gait_, {.max_age = 100ms});
  d.in("joints", joints_, {.max_age = 100ms});
  d.out("pose", out_);
  d.param("place", place_, {.doc = "name of the camera among the body's places"});
  d.state(history_, seen_, waits_);
}

hal::Status CameraPose::configure(rt::Setup& setup) {
  if (!robot_.body) {
    setup.explain("it needs [body] in the robot file (docs/bodies.md)");
    return hal::Error{hal::Errc::bad_argument, "a body"};
  }
  camera_ = robot_.body->find_place(place_);
  if (!camera_) {
    std::string known;
    for (const kinematics::Place& p : robot_.body->places) known += " " + p.name;
    setup.explain("the body has no place '" + place_ + "'; known:" + known);
    return hal::Error{hal::Errc::bad_argument, "a place"};
  }
  limbs_ = kinematics::Limbs::of(*robot_.body);
  pose_.emplace(*robot_.body);
  rad_.assign(robot_.body->joints(), 0);
  return {};
}

void CameraPose::reset() {
  history_ = {};
  seen_ = waits_ = {};
}

rt::StepStatus CameraPose::step(const rt::Step& step) noexcept {
  const msg::GaitState* gait = gait_.fresh(step.now);
  const msg::JointState* joints = joints_.fresh(step.now);
  if (gait && joints && msg::on_its_feet(gait->mode)) {
    const std::vector<std::size_t>& head = limbs_.of(kinematics::Limb::head);
    for (std::size_t c = 0; c < head.size() && c < joints->count; ++c) rad_[head[c]] = joints->position_rad[c];
    pose_->set(rad_, {{gait->x_m, gait->y_m, gait->height_m}, math::Quat(gait->q_world_torso)});
    const kinematics::Pose camera = motion::camera_pose(*pose_, *camera_);
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
