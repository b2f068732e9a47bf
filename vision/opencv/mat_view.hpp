#pragma once
// An image message as a cv::Mat and back, without a copy of pixels.
#include <opencv2/core.hpp>

#include "msg/image.hpp"
#include "rt/step.hpp"
#include "vision/image_view.hpp"

namespace sinew::vision {

/// The pixels of a message to write through, e.g. of a slot just loaned. Describe it with format_as() first: OpenCV
/// writes in place into an output array that already has the right size and type. Empty when the header cannot be used.
/// Shape:   height x width; CV_8UC1 for mono8, CV_8UC2 for yuyv, CV_8UC3 for rgb8 and bgr8 (OpenCV's own order).
/// Owner:   the slot. The Mat owns nothing and must not outlive the step.
inline cv::Mat mat_view(msg::Image& image) {
  const ImageView v = view(image);
  if (!v) return {};
  const int type = CV_8UC(static_cast<int>(msg::bytes_per_pixel(v.format)));
  return {static_cast<int>(v.height), static_cast<int>(v.width), type, image.pixels(), v.stride};
}

/// The pixels of a message to read. A copy of a cv::Mat header drops const, so this class hands out no copy: pass it
/// where an InputArray or const cv::Mat& is wanted.
/// Owner:   as above.
class ReadOnlyMat {
 public:
  explicit ReadOnlyMat(const msg::Image& image) : mat_(mat_view(const_cast<msg::Image&>(image))) {}
  ReadOnlyMat(const ReadOnlyMat&) = delete;
  ReadOnlyMat& operator=(const ReadOnlyMat&) = delete;
  const cv::Mat& operator*() const { return mat_; }
  const cv::Mat* operator->() const { return &mat_; }
  bool empty() const { return mat_.empty(); }

 private:
  const cv::Mat mat_;
};

/// Runs a step's work that calls OpenCV: its exceptions (and std::bad_alloc) become a fault.
template <class Work>
rt::StepStatus without_exceptions(const Work& work) noexcept {
  try {
    return work();
  } catch (...) {
    return rt::StepStatus::fault;
  }
}

}  // namespace sinew::vision
