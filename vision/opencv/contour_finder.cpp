#include "vision/opencv/contour_finder.hpp"

#include <opencv2/imgproc.hpp>

#include "vision/opencv/mat_view.hpp"

namespace sinew::vision {

void ContourFinder::declare(rt::Declaration& d) {
  d.best_effort();
  d.in("image", image_);
  d.out("small", small_);
  d.out("report", report_);
  d.param("fx_px", lens_.fx_px, {.unit = "px", .min = 0, .max = 1e5, .doc = "0: the lens is not corrected"});
  d.param("fy_px", lens_.fy_px, {.unit = "px", .min = 0, .max = 1e5});
  d.param("cx_px", lens_.cx_px, {.unit = "px", .min = 0, .max = 1e5});
  d.param("cy_px", lens_.cy_px, {.unit = "px", .min = 0, .max = 1e5});
  d.param("k1", lens_.bends.k1, {.min = -10, .max = 10});
  d.param("k2", lens_.bends.k2, {.min = -10, .max = 10});
  d.param("p1", lens_.bends.p1, {.min = -1, .max = 1});
  d.param("p2", lens_.bends.p2, {.min = -1, .max = 1});
  d.param("small_width_px", small_width_px_, {.unit = "px", .min = 16, .max = 1280});
  d.param("threshold_grey", threshold_grey_, {.min = 0, .max = 255, .doc = "0: chosen by Otsu's method"});
}

rt::StepStatus ContourFinder::step(const rt::Step&) noexcept {
  const msg::Image* image = image_.get();
  if (image == nullptr || !image_.updated()) return rt::StepStatus::stale;
  return without_exceptions([&] { return work(*image); });
}

bool ContourFinder::to_grey(const msg::Image& image) {
  const ReadOnlyMat pixels(image);
  if (pixels.empty()) return false;
  switch (image.format) {
    case msg::PixelFormat::mono8:
      pixels->copyTo(grey_);
      return true;
    case msg::PixelFormat::yuyv:
      cv::extractChannel(*pixels, grey_, 0);
      return true;
    case msg::PixelFormat::rgb8:
      cv::cvtColor(*pixels, grey_, cv::COLOR_RGB2GRAY);
      return true;
    case msg::PixelFormat::bgr8:
      cv::cvtColor(*pixels, grey_, cv::COLOR_BGR2GRAY);
      return true;
    case msg::PixelFormat::none:
      return false;
  }
  return false;
}

/// For each pixel of the straight image, its place in the distorted one. (OpenCV's own maker of these maps is in
/// calib3d.)
void ContourFinder::make_maps(const cv::Size& size) {
  size_ = size;
  made_for_ = lens_;
  map_x_.create(size, CV_32F);
  map_y_.create(size, CV_32F);
  const Lens& c = lens_;
  for (int v = 0; v < size.height; ++v)
    for (int u = 0; u < size.width; ++u) {
      const auto at = c.bends.distorted((u - c.cx_px) / c.fx_px, (v - c.cy_px) / c.fy_px);
      map_x_.at<float>(v, u) = static_cast<float>(at.x * c.fx_px + c.cx_px);
      map_y_.at<float>(v, u) = static_cast<float>(at.y * c.fy_px + c.cy_px);
    }
}

rt::StepStatus ContourFinder::work(const msg::Image& image) {
  if (!to_grey(image)) return rt::StepStatus::fault;
  const bool correct = lens_.fx_px > 0 && lens_.fy_px > 0;
  if (correct && (grey_.size() != size_ || lens_ != made_for_)) make_maps(grey_.size());
  if (correct) cv::remap(grey_, straight_, map_x_, map_y_, cv::INTER_LINEAR);
  const cv::Mat& straight = correct ? straight_ : grey_;

  const auto width = static_cast<std::uint32_t>(small_width_px_);
  const std::uint32_t height = image.height * width / image.width;
  msg::Image& out = small_.loan();
  if (!out.format_as(msg::PixelFormat::mono8, width, height)) return rt::StepStatus::fault;
  out.stamp = image.stamp, out.exposure_ns = image.exposure_ns, out.frame_number = image.frame_number;
  cv::Mat small = mat_view(out);
  cv::resize(straight, small, small.size(), 0, 0, cv::INTER_AREA);
  if (small.data != out.pixels())
    return rt::StepStatus::fault;  // OpenCV allocated its own memory: nothing is in the slot

  const int kind = cv::THRESH_BINARY | (threshold_grey_ > 0 ? 0 : int{cv::THRESH_OTSU});
  cv::threshold(small, bright_, threshold_grey_, 255, kind);
  cv::findContours(bright_, contours_, cv::RETR_EXTERNAL, cv::CHAIN_APPROX_NONE);
  report(image, double(image.width) / width, double(image.height) / height);
  return rt::StepStatus::ok;
}

void ContourFinder::report(const msg::Image& image, double scale_x, double scale_y) {
  ContourReport& out = report_.loan();
  out.stamp = image.stamp;
  out.contours = static_cast<std::uint32_t>(contours_.size());
  for (const auto& contour : contours_) {
    const cv::Moments m = cv::moments(contour);
    if (m.m00 * scale_x * scale_y <= out.largest_area_px) continue;
    out.largest_area_px = m.m00 * scale_x * scale_y;
    // Pixel centres are whole numbers in both images.
    out.largest_u_px = (m.m10 / m.m00 + 0.5) * scale_x - 0.5;
    out.largest_v_px = (m.m01 / m.m00 + 0.5) * scale_y - 0.5;
  }
}

}  // namespace sinew::vision
