#pragma once
#include <memory>

#include "msg/flight.hpp"
#include "rt/module.hpp"
#include "vision/detector_parameters.hpp"
#include "vision/pad_finder.hpp"

namespace sinew::vision {

/// Looks for the landing pad in each image (yuyv, rgb8 or bgr8) and reports its position. A message comes for every
/// image; without a pad its `found` is 0.
/// Units:   range_m is the straight distance from the camera to the pad's centre, for a pad seen from above.
/// Frames:  direction in camera_optical: z forward, x right, y down.
/// Thread:  executor.   RT: yes.
/// Errors:  stale when there is no new image; fault when the image's header or format cannot be used.
/// The colours and radii are read in configure(); the camera's numbers may change between steps.
class PadDetector final : public rt::Module {
 public:
  void declare(rt::Declaration& d) override;
  hal::Status configure(rt::Setup& setup) override;
  rt::StepStatus step(const rt::Step& step) noexcept override;

 private:
  PadCircle find(const ImageView& pixels, const rt::Step& step);

  rt::In<msg::Image> image_;
  rt::Out<msg::PadSighting> sighting_;
  CameraParameters camera_;
  ColourParameters colour_;
  PadLook look_;
  std::unique_ptr<PadFinder> finder_;
};

}  // namespace sinew::vision
