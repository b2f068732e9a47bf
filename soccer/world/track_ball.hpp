#pragma once
#include "msg/camera_pose.hpp"
#include "rt/module.hpp"
#include "soccer/world/ball_filter.hpp"
#include "vision/detector_parameters.hpp"

namespace sinew::soccer {

/// Says where the ball is: docs/soccer-world.md. One that should be in a picture and is not becomes improbable; that
/// needs the poses of the cameras (`camera`, `camera2`).
/// Frames:  out: "robot" of the newest picture; the place on the field by `field`.
/// Thread:  executor, released by sightings.   RT: yes.
/// Errors:  stale when no picture came.
class TrackBall final : public rt::Module {
 public:
  void declare(rt::Declaration& d) override;
  void reset() override { filter_.forget(); }
  rt::StepStatus step(const rt::Step& step) noexcept override;

 private:
  void take(const msg::SoccerSight& sight, const rt::InQueue<msg::CameraPose>& poses);

  rt::InQueue<msg::SoccerSight> sight_, sight2_;
  rt::InQueue<msg::CameraPose> camera_, camera2_;
  rt::In<msg::FieldPose> field_;
  rt::Out<msg::BallModel> out_;
  vision::CameraParameters optics_;
  std::int64_t width_px_ = 320, height_px_ = 240;
  double ball_radius_m_ = 0.07, farthest_m_ = 3;

  BallFilter filter_;
};

}  // namespace sinew::soccer
