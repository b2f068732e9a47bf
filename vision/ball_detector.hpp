#pragma once
#include <memory>

#include "msg/head.hpp"
#include "rt/module.hpp"
#include "vision/ball_finder.hpp"
#include "vision/detector_parameters.hpp"

namespace sinew::vision {

/// Looks for a coloured ball in each image (yuyv, rgb8 or bgr8) and reports its position. A message comes for every
/// image; without a ball its `found` is 0.
/// Units:   range_m is the distance from the camera to the ball's centre.
/// Frames:  direction in camera_optical: z forward, x right, y down.
/// Thread:  executor.   RT: yes.
/// Errors:  stale when there is no new image; fault when the image's header or format cannot be used.
/// Colour and limits are read in configure(); the camera's numbers and the ball's radius may change between steps.
class BallDetector final : public rt::Module {
 public:
  void declare(rt::Declaration& d) override;
  hal::Status configure(rt::Setup& setup) override;
  rt::StepStatus step(const rt::Step& step) noexcept override;

 private:
  BallImage find(const ImageView& pixels, const Pinhole& camera, const rt::Step& step);

  rt::In<msg::Image> image_;
  rt::Out<msg::BallSighting> sighting_;
  CameraParameters camera_;
  ColourParameters colour_;
  double radius_m_ = 0.07, range_max_m_ = 0;
  BallLook look_;
  std::unique_ptr<BallFinder> finder_;
};

}  // namespace sinew::vision
