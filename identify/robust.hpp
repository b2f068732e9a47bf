#pragma once

namespace sinew::identify {

/// Errors beyond so many sigmas count linearly. Source: P. Huber, Robust Statistics (1981).
inline constexpr double kHuber = 2.5;
/// A normal distribution's sigma by the median of its absolute errors.
inline constexpr double kSigmaOfMedian = 1.4826;

}  // namespace sinew::identify
