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
  /// For each of three sizes: small ones are so many that they would leave no room for others.
  static constexpr std::size_t kSizes = 3, kMostOfSize = 10, kMost = kSizes * kMostOfSize;
  void find(const Picture& picture, const GroundView& view, const FieldBorder& border, double ball_radius_m);
  /// The smallest size first; of each size the best first.
  std::span<const BallCandidate> all() const { return {candidate_.data(), count_}; }
  /// BallCandidate::fit of any disc.
  static double fit(const Picture& picture, double u_px, double v_px, double radius_px);

 private:
  void add(const BallCandidate& c);
  bool near(double u_px, double v_px, double within_px) const;
  struct List {
    std::array<BallCandidate, kMostOfSize> item{};
    std::size_t count = 0;
  };

  std::array<BallCandidate, kMost> candidate_{};
  std::size_t count_ = 0;
  std::array<List, kSizes> list_{};
};

}  // namespace sinew::soccer
