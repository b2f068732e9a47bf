#pragma once
// Places of a picture where a ball could be, by geometry: something that is no carpet, as large as a ball would be
// there, with carpet beside it.
#include <array>
#include <span>

#include "soccer/sight/field_border.hpp"

namespace sinew::soccer {

struct BallCandidate {
  double u_px = 0, v_px = 0, radius_px = 0;  // fitted
  double expected_px = 0;                    // by the place
  double fit = 0;                            // 1: a full disc in clean carpet
};

/// Thread:  owner.   RT: yes.
class BallCandidates {
 public:
  static constexpr std::size_t kMost = 24;
  void find(const Picture& picture, const GroundView& view, const FieldBorder& border, double ball_radius_m);
  /// The best first.
  std::span<const BallCandidate> all() const { return {candidate_.data(), count_}; }

 private:
  void add(const BallCandidate& c);

  std::array<BallCandidate, kMost> candidate_{};
  std::size_t count_ = 0;
};

}  // namespace sinew::soccer
