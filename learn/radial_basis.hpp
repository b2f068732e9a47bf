#pragma once
#include <array>
#include <cstddef>
#include <span>

namespace sinew::learn {

/// One coordinate of a state: bumps at `centres` places from `low` to `high`, both included. A value outside counts as
/// the nearer end.
struct GridAxis {
  double low = 0, high = 1;
  std::size_t centres = 2;  // at least 2
};

/// Radial basis functions on a grid: at each crossing of the axes a Gaussian whose width (1 sigma) along an axis is 0.7
/// of the distance between neighbours there. They are normalised, so that they sum up to 1 everywhere: a function made
/// of them never leaves the range of its weights, and no separate constant is needed. Thread:  owner to make, then any.
/// RT: yes; allocates nothing.
class RadialBasis {
 public:
  static constexpr std::size_t kMostAxes = 4, kMostCentres = 12, kMostFeatures = 128;

  /// Without axes it has one feature, which is 1.
  RadialBasis() = default;
  /// `axes`: at most kMostAxes, each of 2 to kMostCentres; at most kMostFeatures crossings. Wrong numbers are a bug.
  explicit RadialBasis(std::span<const GridAxis> axes);

  std::size_t axes() const { return axis_count_; }
  std::size_t size() const { return size_; }
  /// Writes the value of each feature; the last axis runs fastest. `state`: one number for each axis; `features`: at
  /// least size().
  void at(std::span<const double> state, std::span<double> features) const noexcept;

 private:
  std::array<GridAxis, kMostAxes> axis_{};
  std::size_t axis_count_ = 0, size_ = 1;
};

}  // namespace sinew::learn
