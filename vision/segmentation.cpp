#include "vision/segmentation.hpp"

#include <algorithm>

namespace sinew::vision {

Segmentation::Segmentation(const SegmentationLimits& limits) : limits_(limits) {
  limits_.colours = std::min(limits_.colours, kMaxColours);
  for (std::uint32_t c = 0; c < limits_.colours; ++c) joiners_[c].set_capacity(limits_.max_runs);
  regions_.resize(limits_.max_runs);
  blobs_.resize(limits_.max_blobs);
}

std::uint32_t Segmentation::dropped_runs() const {
  std::uint32_t n = 0;
  for (const RunJoiner& j : joiners_) n += j.dropped();
  return n;
}

void Segmentation::start(std::size_t colours) {
  for (RunJoiner& j : joiners_) j.clear();
  used_ = colours;
  blob_count_ = dropped_blobs_ = 0;
}

void Segmentation::finish() {
  for (std::uint32_t c = 0; c < used_; ++c) {
    const std::uint32_t n = joiners_[c].finish(c + 1, regions_.data());
    for (std::uint32_t i = 0; i < n; ++i) {
      if (regions_[i].area_px < limits_.min_area_px) continue;
      if (blob_count_ < limits_.max_blobs)
        blobs_[blob_count_++] = regions_[i];
      else
        ++dropped_blobs_;
    }
  }
}

namespace {

/// Turns the colours of a row's pixels into runs.
class RowRuns {
 public:
  RowRuns(RunJoiner* joiners, std::uint32_t y) : joiners_(joiners), y_(y) {}
  void pixel(std::uint32_t x, unsigned colour) {
    if (colour == colour_) return;
    end(x);
    colour_ = colour;
    from_ = x;
  }
  void end(std::uint32_t x) {
    if (colour_ != 0) joiners_[colour_ - 1].add(y_, from_, x);
  }

 private:
  RunJoiner* joiners_;
  std::uint32_t y_, from_ = 0;
  unsigned colour_ = 0;
};

void yuyv_row(const std::uint8_t* p, std::uint32_t width, const std::uint8_t* table, RowRuns& runs) {
  for (std::uint32_t x = 0; x < width; x += 2, p += 4) {
    const std::uint8_t* cell = table + ColourTable::yuv_index(0, p[1], p[3]);
    runs.pixel(x, cell[p[0] >> 3]);
    runs.pixel(x + 1, cell[p[2] >> 3]);
  }
}

template <int R, int B>
void rgb_row(const std::uint8_t* p, std::uint32_t width, const std::uint8_t* table, RowRuns& runs) {
  for (std::uint32_t x = 0; x < width; ++x, p += 3) runs.pixel(x, table[ColourTable::rgb_index(p[R], p[1], p[B])]);
}

}  // namespace

bool Segmentation::by_table(const ImageView& image, const ColourTable& table) {
  using msg::PixelFormat;
  const PixelFormat f = image.format;
  start(0);
  if (!image || table.colours() > limits_.colours ||
      (f != PixelFormat::yuyv && f != PixelFormat::rgb8 && f != PixelFormat::bgr8))
    return false;
  if (image.width > 65535 || image.height > 65535) return false;
  start(table.colours());
  for (std::uint32_t y = 0; y < image.height; ++y) {
    RowRuns runs(joiners_.data(), y);
    if (f == PixelFormat::yuyv)
      yuyv_row(image.row(y), image.width, table.yuv(), runs);
    else if (f == PixelFormat::rgb8)
      rgb_row<0, 2>(image.row(y), image.width, table.rgb(), runs);
    else
      rgb_row<2, 0>(image.row(y), image.width, table.rgb(), runs);
    runs.end(image.width);
    for (std::size_t c = 0; c < used_; ++c) joiners_[c].end_row();
  }
  finish();
  return true;
}

bool Segmentation::by_boxes(const ImageView& image, std::span<const ColourBox> boxes, Simd simd) {
  const bool good = image && image.format == msg::PixelFormat::yuyv && image.width <= 65535 && image.height <= 65535 &&
                    boxes.size() <= limits_.colours;
  start(good ? boxes.size() : 0);
  if (!good) return false;
#if defined(SINEW_VISION_AVX2)
  if (simd == Simd::avx2)
    detail::box_runs_avx2(image, boxes, joiners_.data());
  else
#elif defined(SINEW_VISION_NEON)
  if (simd == Simd::neon)
    detail::box_runs_neon(image, boxes, joiners_.data());
  else
#endif
    detail::box_runs_scalar(image, boxes, joiners_.data());
  (void)simd;
  finish();
  return true;
}

namespace detail {

void box_runs_scalar(const ImageView& image, std::span<const ColourBox> boxes, RunJoiner* joiners) {
  const auto in = [](unsigned value, unsigned lo, unsigned hi) { return value >= lo && value <= hi; };
  for (std::uint32_t y = 0; y < image.height; ++y)
    for (std::size_t c = 0; c < boxes.size(); ++c) {
      const ColourBox& box = boxes[c];
      const std::uint8_t* p = image.row(y);
      RowRuns runs(joiners + c, y);
      for (std::uint32_t x = 0; x < image.width; x += 2, p += 4) {
        const bool uv = in(p[1], box.lo[1], box.hi[1]) && in(p[3], box.lo[2], box.hi[2]);
        runs.pixel(x, uv && in(p[0], box.lo[0], box.hi[0]));
        runs.pixel(x + 1, uv && in(p[2], box.lo[0], box.hi[0]));
      }
      runs.end(image.width);
      joiners[c].end_row();
    }
}

}  // namespace detail

}  // namespace sinew::vision
