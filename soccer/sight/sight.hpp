#pragma once
#include <memory>

#include "msg/gait.hpp"
#include "rt/module.hpp"
#include "soccer/sight/field_sight.hpp"
#include "vision/detector_parameters.hpp"

namespace sinew::soccer {

/// Says for each picture what it shows of the game, as soon as its camera's pose is known: docs/soccer-vision.md.
/// The picture that is newest when a pose comes must be the one that the pose is of.
/// Frames:  out: "robot" and the odometry's, by `gait`, whose newest message is moved back to the exposure by its own
///          velocities.
/// Thread:  executor, released by `pose`.   RT: yes.
/// Errors:  stale when there is no new pose, its picture has not come or has been replaced, or nothing is known of the
///          gait for 100 ms; fault when the picture's header or format (yuyv up to 640 x 480) cannot be used.
class Sight final : public rt::Module {
 public:
  void declare(rt::Declaration& d) override;
  hal::Status configure(rt::Setup& setup) override;
  void reset() override;
  rt::StepStatus step(const rt::Step& step) noexcept override;

 private:
  rt::In<msg::Image> image_;
  rt::In<msg::CameraPose> pose_;
  rt::In<msg::GaitState> gait_;
  rt::Out<msg::SoccerSight> sight_;
  vision::CameraParameters camera_;
  SightOptions options_;
  std::int64_t number_ = 0;
  CarpetLook start_;
  std::unique_ptr<FieldSight> look_;

  CarpetLook carpet_;  // state
};

}  // namespace sinew::soccer
