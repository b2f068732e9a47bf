#include "learn/radial_basis.hpp"

#include <algorithm>
#include <cstdlib>

#include "math/elementary.hpp"

namespace sinew::learn {
namespace {

constexpr double kWidth = 0.7;  // of a bump, in distances to its neighbour

}  // namespace

RadialBasis::RadialBasis(std::span<const GridAxis> axes) {
  if (!(axes.size() <= kMostAxes)) std::abort();
  for (const GridAxis& axis : axes) {
    if (!(axis.centres >= 2 && axis.centres <= kMostCentres && axis.low < axis.high)) std::abort();
    axis_[axis_count_++] = axis;
    size_ *= axis.centres;
  }
  if (!(size_ <= kMostFeatures)) std::abort();
}

void RadialBasis::at(std::span<const double> state, std::span<double> features) const noexcept {
  // A Gaussian of several coordinates is the product of one of each, and so is its normalised form.
  features[0] = 1;
  std::size_t made = 1;
  for (std::size_t i = 0; i < axis_count_; ++i) {
    const GridAxis& axis = axis_[i];
    std::array<double, kMostCentres> along;
    const double x = std::clamp(state[i], axis.low, axis.high);
    const double spacing = (axis.high - axis.low) / static_cast<double>(axis.centres - 1);
    double sum = 0;
    for (std::size_t k = 0; k < axis.centres; ++k) {
      const double off = (x - axis.low) / spacing - static_cast<double>(k);
      along[k] = math::exp(-0.5 * off * off / (kWidth * kWidth));
      sum += along[k];
    }
    for (std::size_t k = 0; k < axis.centres; ++k) along[k] /= sum;
    for (std::size_t f = made; f-- > 0;)  // from behind, so that it can be done in place
      for (std::size_t k = axis.centres; k-- > 0;) features[f * axis.centres + k] = features[f] * along[k];
    made *= axis.centres;
  }
}

}  // namespace sinew::learn
