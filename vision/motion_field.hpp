#pragma once
#include "rt/module.hpp"
#include "vision/luma.hpp"
#include "vision/motion_grid.hpp"

namespace sinew::vision {

/// How the picture moves between one image (mono8 or yuyv) and the next, on a grid of cells and as a whole, by
/// elementary motion detection. See motion_grid.hpp for what it can and cannot tell. `moving` means that the picture
/// travels; a camera that only shakes does not move.
/// Units:   speeds in pixels of the image per frame, whatever the bin.
/// Frames:  x right, y down, in the image.
/// Thread:  executor.   RT: yes.
/// Errors:  stale when there is no new image, for the first one, and when the size changed; fault when the image's
///          header or format cannot be used, it does not fit, or its stamp is not after the last one.
/// The bin is read in configure().
class MotionField final : public rt::Module {
 public:
  void declare(rt::Declaration& d) override;
  hal::Status configure(rt::Setup& setup) override;
  void reset() override;
  rt::StepStatus step(const rt::Step& step) noexcept override;

 private:
  void scale(msg::MotionField& field) const;

  rt::In<msg::Image> image_;
  rt::Out<msg::MotionField> field_;
  MotionOptions options_;
  TravelDetector::Options travel_;
  TravelDetector detector_;
  std::int64_t bin_ = 1;
  Luma older_, newer_;
  msg::Time older_stamp_;
};

}  // namespace sinew::vision
