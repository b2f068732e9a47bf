#pragma once
#include "msg/camera_pose.hpp"
#include "msg/head.hpp"
#include "msg/soccer.hpp"
#include "rt/module.hpp"
#include "vision/detector_parameters.hpp"

namespace sinew::mixed {

/// Puts a ball that a detector of colours has found in the place of the league's ball: what a picture shows of the
/// game, with that ball and no other one.
/// Frames:  as SoccerSight: "robot".
/// Thread:  executor, released by sightings of the same camera.   RT: yes.
/// Errors:  stale where sighting, ball and camera's pose are not of one picture: nothing is published.
class OrangeBall final : public rt::Module {
 public:
  void declare(rt::Declaration& d) override;
  rt::StepStatus step(const rt::Step& step) noexcept override;

 private:
  rt::In<msg::SoccerSight> sight_;
  rt::In<msg::BallSighting> ball_;
  rt::InQueue<msg::CameraPose> camera_;
  rt::Out<msg::SoccerSight> out_;
  vision::CameraParameters optics_;
  std::int64_t width_px_ = 320, height_px_ = 240;
  double radius_m_ = 0.07, confidence_ = 0.95;
};

}  // namespace sinew::mixed
