#include "soccer/play/walk_to.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace sinew::soccer::walk_to_test {
namespace {

constexpr double kStep_s = 0.05;

/// Walks as it is told until it stands there; how near it came to each thing on its way, and when it was there.
struct Walked {
  double least_m = math::kInf, took_s = math::kInf;
  FieldAt at;
};

Walked walk(const FieldAt& to, const std::vector<Round>& things, const WalkLimits& limits = {}) {
  Walked out;
  for (int i = 0; i < 1200; ++i) {
    std::vector<Round> seen = things;
    for (Round& r : seen) r.at = out.at.in(r.at.x_m, r.at.y_m);
    for (const Round& r : seen) out.least_m = std::min(out.least_m, length_m(r.at) - r.radius_m);
    const FieldAt off = out.at.way_to(to);
    if (math::hypot(off.x_m, off.y_m) < 0.02 && math::fabs(off.heading_rad) < 0.05) {
      out.took_s = i * kStep_s;
      return out;
    }
    const WalkSpeed v = walk_to(off, seen, limits);
    EXPECT_LE(v.forward_mps, limits.forward_mps + 1e-9);
    EXPECT_GE(v.forward_mps, -limits.back_mps - 1e-9);
    EXPECT_LE(math::fabs(v.left_mps), limits.side_mps + 1e-9);
    EXPECT_LE(math::fabs(v.turn_radps), limits.turn_radps + 1e-9);
    out.at = out.at.then({kStep_s * v.forward_mps, kStep_s * v.left_mps, kStep_s * v.turn_radps});
  }
  return out;
}

TEST(WalkTo, ComesToAnyPlaceAndTurnsThere) {
  for (const FieldAt& to : {FieldAt{2, 0, 0}, FieldAt{-1, 0.3, 3}, FieldAt{0, 0.3, -1.5}, FieldAt{0.1, -1.5, 1}}) {
    const Walked w = walk(to, {});
    EXPECT_LT(w.took_s, 4 + math::hypot(to.x_m, to.y_m) / 0.15 + math::fabs(to.heading_rad)) << to.x_m << ' ' << to.y_m;
  }
}

TEST(WalkTo, GoesRoundWhatStandsInTheWay) {
  const Round other{{1, 0}, 0.15};
  const Walked w = walk({2, 0, 0}, {other});
  EXPECT_LT(w.took_s, 20);
  EXPECT_GT(w.least_m, 0.15) << "0.2 m are wanted; it walks in arcs";
}

TEST(WalkTo, PassesTwoThatLeaveNoRoomBetweenThemTogether) {
  const Walked w = walk({2, 0, 0}, {{{1, 0.2}, 0.15}, {{1, -0.2}, 0.15}});
  EXPECT_LT(w.took_s, 25);
  EXPECT_GT(w.least_m, 0.15);
}

TEST(WalkTo, GoesThroughAGapThatIsWideEnough) {
  EXPECT_EQ(way_rad({2, 0}, std::vector<Round>{{{1, 0.5}, 0.15}, {{1, -0.5}, 0.15}}, 0.2), 0);
}

TEST(WalkTo, LeavesAMarginThatItStandsIn) {
  const std::vector<Round> things{{{0.2, 0}, 0.15}};
  EXPECT_GT(math::fabs(way_rad({2, 0}, things, 0.2)), 0.5 * math::kPi) << "not towards it";
  EXPECT_GT(walk({2, 0, 0}, things).least_m, 0.03);
}

TEST(WalkTo, ThingsBehindThePlaceAreNotInTheWay) {
  EXPECT_EQ(way_rad({1, 0}, std::vector<Round>{{{1.5, 0}, 0.15}}, 0.2), 0);
}

}  // namespace
}  // namespace sinew::soccer::walk_to_test
