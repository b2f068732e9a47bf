#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <numeric>

#include "images/buffer.hpp"
#include "images/pixel_rows.hpp"

namespace sinew::images {

/// Makes rows smaller: each value is the exact average of the area that it replaces, rounded. Parts of pixels count by
/// their area.
class BoxFilter {
 public:
  struct Size {
    std::uint32_t width, height;
  };
  /// `out` has at least one pixel and is in no direction larger than `in`; `in` has at most kMaxPixels.
  /// False: no memory.
  [[nodiscard]] bool start(Size in, Size out, std::uint32_t channels);

  /// The next row from above. row(y) gives row y of the picture; y does not fall, but the last one may come again.
  template <class Rows>
  void next(const Rows& row, std::uint8_t* out) {
    std::fill_n(sums_.get(), count_, 0u);
    for (std::uint32_t left = height_; left > 0;) {
      const std::uint32_t weight = std::min(left, left_of_row_);
      add_weighted(row(y_), count_, weight, sums_.get());
      left -= weight, left_of_row_ -= weight;
      if (left_of_row_ == 0) ++y_, left_of_row_ = out_height_;
    }
    reduce(out);
  }

 private:
  void reduce(std::uint8_t* out) const;

  // A pixel is divided into out_width_ x out_height_ units, which makes each pixel of the result width_ x height_
  // units.
  std::uint32_t width_ = 0, height_ = 0, out_width_ = 0, out_height_ = 0;
  std::uint32_t channels_ = 0, pixels_out_ = 0;
  std::size_t count_ = 0;  // values in a row of the picture
  std::uint32_t y_ = 0, left_of_row_ = 0;
  Buffer<std::uint32_t> sums_;
};

}  // namespace sinew::images
