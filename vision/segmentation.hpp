#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "vision/colour_table.hpp"
#include "vision/image_view.hpp"
#include "vision/run_joiner.hpp"
#include "vision/simd.hpp"

namespace sinew::vision {

/// The limits of a segmentation; all memory is allocated in the constructor.
struct SegmentationLimits {
  std::uint32_t colours = kMaxColours;
  std::uint32_t max_runs = 16384;  // of each colour
  std::uint32_t max_blobs = 256;   // of all colours together
  std::uint32_t min_area_px = 1;   // smaller regions are not reported
};

/// Colours to runs to blobs. The look-up table takes yuyv, rgb8 and bgr8; the boxes take yuyv and are faster.
/// Thread:  owner.   RT: yes, except the constructor (configure only).
/// Errors:  false, and no blobs, when the image has another format or more than 65535 px a side, or there are more
///          colours than the limits say.
class Segmentation {
 public:
  explicit Segmentation(const SegmentationLimits& limits = {});
  /// The colour of each pixel by look-up: a pixel has one colour.
  bool by_table(const ImageView& image, const ColourTable& table);
  /// By boxes in YUV: colours are independent of each other and may overlap. Scalar and SIMD give the same result.
  bool by_boxes(const ImageView& image, std::span<const ColourBox> boxes, Simd simd = best_simd());

  /// Blobs by colour, then in raster order of their first pixel.
  std::span<const Blob> blobs() const { return {blobs_.data(), blob_count_}; }
  /// Runs of a colour (1..), in raster order; label = Blob::region.
  std::span<const Run> runs(std::uint32_t colour) const { return {joiner(colour).begin(), joiner(colour).end()}; }
  /// Runs that did not fit in the last image. Blobs of a colour with dropped runs only cover the image's upper part.
  std::uint32_t dropped_runs(std::uint32_t colour) const { return joiner(colour).dropped(); }
  std::uint32_t dropped_runs() const;
  std::uint32_t dropped_blobs() const { return dropped_blobs_; }

 private:
  const RunJoiner& joiner(std::uint32_t colour) const { return joiners_[colour - 1]; }
  void start(std::size_t colours);
  void finish();

  SegmentationLimits limits_;
  std::array<RunJoiner, kMaxColours> joiners_;
  std::size_t used_ = 0;  // colours of the last image
  std::vector<Blob> regions_, blobs_;
  std::uint32_t blob_count_ = 0, dropped_blobs_ = 0;
};

/// The `N` largest blobs, the largest first; the rest is null.
template <std::size_t N>
std::array<const Blob*, N> largest(std::span<const Blob> blobs) {
  std::array<const Blob*, N> places{};
  for (const Blob& b : blobs) {
    const Blob* candidate = &b;
    for (const Blob*& place : places)
      if (candidate != nullptr && (place == nullptr || candidate->area_px > place->area_px))
        std::swap(candidate, place);
  }
  return places;
}

/// Calls `row(y, x0, x1)` for each row of a region, from its first pixel to behind its last one; holes do not matter.
template <class Row>
void each_row(std::span<const Run> runs, std::uint32_t region, const Row& row) {
  for (std::size_t i = 0; i < runs.size();) {
    if (runs[i].label != region) {
      ++i;
      continue;
    }
    const std::uint32_t y = runs[i].y, x0 = runs[i].x0;
    std::uint32_t x1 = 0;
    for (; i < runs.size() && runs[i].y == y; ++i)
      if (runs[i].label == region) x1 = runs[i].x1;
    row(y, x0, x1);
  }
}

namespace detail {
/// Runs of all boxes, rows ended. `joiners` has one place per box.
void box_runs_scalar(const ImageView& image, std::span<const ColourBox> boxes, RunJoiner* joiners);
void box_runs_avx2(const ImageView& image, std::span<const ColourBox> boxes, RunJoiner* joiners);
void box_runs_neon(const ImageView& image, std::span<const ColourBox> boxes, RunJoiner* joiners);
}  // namespace detail

}  // namespace sinew::vision
