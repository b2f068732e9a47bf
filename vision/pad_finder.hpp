#pragma once
#include <array>
#include <vector>

#include "vision/circle_fit.hpp"
#include "vision/segmentation.hpp"

namespace sinew::vision {

/// The landing pad's look: a disc of one colour on a darker ground, with a bright ring inside.
struct PadLook {
  HueSector colour{.hue_from_deg = 350, .hue_to_deg = 40, .saturation_min = 0.5, .value_min = 0.15};
  double radius_m = 0.30;
  double mark_radius_m = 0.144;  // inner edge of the ring; 0: there is none
};

/// The circle of the pad in one image.
struct PadCircle {
  Circle circle;
  bool found = false;
  bool is_mark = false;     // the ring was measured, not the pad's edge
  double radius_m = 0;      // true radius of the measured circle
  double coverage = 0;      // share of the circle's outline that was seen, 0..1
  double fill = 0;          // share of the circle's visible area that has the pad's colour, 0..1
  double confidence = 0;    // 0..1
  std::uint32_t blobs = 0;  // regions of the pad's colour
};

/// Finds the pad by its colour, then by its outline: the ends of a region's rows lie on a circle, except where the
/// image cuts them off. Ends with darker ground behind them belong to the pad's edge, ends with something brighter
/// behind them to the ring. So the pad is found even when it leaves the image on all sides, as long as part of its edge
/// or of its ring is in sight; its centre may lie outside of the image. Where both circles are in sight, the centre is
/// corrected for perspective: seen at an angle, a circle's image is not centred on the image of its centre, by an
/// amount that grows with the square of its radius.
/// Takes yuyv, rgb8 and bgr8.
/// Thread:  owner.   RT: yes, except the constructor (configure only).
class PadFinder {
 public:
  PadFinder(const PadLook& look, const SegmentationLimits& limits);
  PadCircle find(const ImageView& image) { return segment(image) ? outline(image) : PadCircle{}; }
  /// The two halves of find(): the regions of the pad's colour (false: not that kind of image), then the circle.
  bool segment(const ImageView& image) { return segmentation_.by_table(image, table_); }
  PadCircle outline(const ImageView& image);
  const Segmentation& segmentation() const { return segmentation_; }

 private:
  /// An end of a row of a region.
  struct Edge {
    PointPx at;
    bool left = false;    // the region lies to the right of it
    bool bright = false;  // what lies behind it is brighter than the region
  };
  static constexpr std::size_t kMaxEdges = 2 * msg::kMaxImageHeight;
  static constexpr std::size_t kCandidates = 4;  // regions looked at, the largest first

  void collect_edges(const ImageView& image, const Blob& blob);
  Circle fit(bool bright);  // through the edges of one kind
  PadCircle judge(const ImageView& image, const Circle& circle, bool bright) const;
  double fill(const ImageView& image, const Circle& circle) const;

  PadLook look_;
  ColourTable table_;
  Segmentation segmentation_;
  std::array<Edge, kMaxEdges> edges_;
  std::size_t edge_count_ = 0;
  std::array<PointPx, kMaxEdges> points_;
  std::size_t point_count_ = 0;
};

}  // namespace sinew::vision
