#pragma once
#include <opencv2/core.hpp>
#include <vector>

#include "math/lens.hpp"
#include "msg/image.hpp"
#include "rt/module.hpp"

namespace sinew::vision {

/// The outlines of a picture, as numbers. A message that this module defines itself, as any program can.
struct ContourReport {
  msg::Time stamp;                            // of the image
  double largest_area_px = 0;                 // of the region inside, in pixels of the undistorted image at full size
  double largest_u_px = 0, largest_v_px = 0;  // its centroid, the same
  std::uint32_t contours = 0;
  std::uint32_t reserved = 0;
};

}  // namespace sinew::vision

template <>
struct sinew::msg::Description<sinew::vision::ContourReport> {
  using C = sinew::vision::ContourReport;
  static constexpr std::string_view name = "ContourReport", doc = "Outlines of bright regions in an image.";
  static constexpr auto fields =
      describe(field<&C::stamp>("ns"), field<&C::largest_area_px>("px^2"), field<&C::largest_u_px>("px"),
               field<&C::largest_v_px>("px"), field<&C::contours>("1"), field<&C::reserved>("1"));
};

namespace sinew::vision {

/// Example of a module built on OpenCV (imgproc): removes the lens' distortion from an image, makes it smaller, and
/// finds outlines of bright regions. The small image is published too; OpenCV writes it into the slot.
/// Takes mono8, rgb8, bgr8 and yuyv; the small image is mono8.
/// Thread:  executor, best effort: OpenCV allocates.   RT: no.
/// Errors:  stale when there is no new image; fault when the image cannot be used, the small one does not fit its slot,
///          or OpenCV throws.
class ContourFinder final : public rt::Module {
 public:
  void declare(rt::Declaration& d) override;
  void reset() override { size_ = {}; }
  rt::StepStatus step(const rt::Step& step) noexcept override;

 private:
  struct Lens {
    double fx_px = 0, fy_px = 0, cx_px = 0, cy_px = 0;  // fx 0: no distortion is taken out
    math::LensDistortion bends{};
    bool operator==(const Lens&) const = default;
  };
  rt::StepStatus work(const msg::Image& image);
  bool to_grey(const msg::Image& image);
  void make_maps(const cv::Size& size);
  void report(const msg::Image& image, double scale_x, double scale_y);

  rt::In<msg::Image> image_;
  rt::Out<msg::Image> small_;
  rt::Out<ContourReport> report_;
  Lens lens_;
  std::int64_t small_width_px_ = 160;
  double threshold_grey_ = 0;  // 0: chosen by Otsu's method
  cv::Size size_;              // the size and
  Lens made_for_;              // the lens that the maps were made for
  cv::Mat map_x_, map_y_, grey_, straight_, bright_;
  std::vector<std::vector<cv::Point>> contours_;
};

}  // namespace sinew::vision
