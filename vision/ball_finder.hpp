#pragma once
#include <array>

#include "math/linear.hpp"
#include "vision/circle_fit.hpp"
#include "vision/pinhole.hpp"
#include "vision/segmentation.hpp"

namespace sinew::vision {

/// What the ball looks like: one colour, and round.
struct BallLook {
  HueSector colour{.hue_from_deg = 4, .hue_to_deg = 34, .saturation_min = 0.55, .value_min = 0.2};
  double fill_min = 0.72;      // least share of its circle with the colour: a bright spot and a shadow may lack it
  double coverage_min = 0.66;  // least share of its outline, as far as the image has it, that lies on the circle
};

/// Frames:  direction in camera_optical: z forward, x right, y down.
struct BallImage {
  bool found = false;
  math::Vec3 direction;  // unit vector to the centre
  double angular_radius_rad = 0;
  double u_px = 0, v_px = 0;  // where the centre appears
  double radius_px = 0;       // as if it were in the middle of the image
  double rms_px = 0;          // of the outline's distances from the circle
  double coverage = 0;        // share of the outline inside of the image that was seen, 0..1
  double fill = 0;            // share of the disc inside of the image that has the colour, 0..1
  double confidence = 0;      // 0..1
  std::uint32_t blobs = 0;    // regions of the colour
};

/// Finds the largest round region of the ball's colour. The ends of a region's rows, except where the image cuts them
/// off, are points of the outline. Seen from the camera they lie on a cone. Turned into the middle of the image they
/// lie on a circle, wherever in the picture the ball is. So its centre is found to less than a pixel, even when
/// something hides part of the ball. A region whose outline is not round, or that does not fill its circle, is not the
/// ball.
/// Takes yuyv, rgb8 and bgr8.
/// Thread:  owner.   RT: yes, except the constructor (configure only).
class BallFinder {
 public:
  BallFinder(const BallLook& look, const SegmentationLimits& limits);
  BallImage find(const ImageView& image, const Pinhole& camera) {
    return segment(image) ? outline(image, camera) : BallImage{};
  }
  /// The two halves of find(): the regions of the colour (false: not that kind of image), then the ball.
  bool segment(const ImageView& image) { return segmentation_.by_table(image, table_); }
  BallImage outline(const ImageView& image, const Pinhole& camera);
  const Segmentation& segmentation() const { return segmentation_; }

 private:
  static constexpr std::size_t kMaxPoints = 2 * msg::kMaxImageHeight;
  static constexpr std::size_t kCandidates = 4;  // regions looked at, the largest first

  /// The camera as if it looked at a region: q_turned_optical.
  struct Turned {
    const ImageView& image;
    const Pinhole& camera;
    math::Quat q;
    PointPx from_image(double u, double v) const;
    /// False: outside of the image, or close to its border.
    bool in_image(const PointPx& p) const;
    double focal_px() const { return math::sqrt(camera.fx_px * camera.fy_px); }
  };

  void collect(const Turned& view, const Blob& blob);
  double coverage(const Turned& view, const Circle& circle, bool& cut) const;
  BallImage judge(const Turned& view, const Blob& blob, const Circle& circle) const;

  BallLook look_;
  ColourTable table_;
  Segmentation segmentation_;
  std::array<PointPx, kMaxPoints> points_;
  std::size_t point_count_ = 0, outline_count_ = 0;  // of them used by the fit; of the region
};

}  // namespace sinew::vision
