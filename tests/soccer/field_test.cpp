#include "soccer/field.hpp"

#include <gtest/gtest.h>
#include <algorithm>

#include "math/elementary.hpp"
#include "sim_hil/pitch/field.hpp"

namespace sinew::soccer {
namespace {

using msg::FieldMark;

bool same(const FieldPoint& a, const FieldPoint& b) {
  return math::fabs(a.x_m - b.x_m) < 1e-9 && math::fabs(a.y_m - b.y_m) < 1e-9;
}

/// Its distance from the line, and whether it is at one of the ends.
bool on(const FieldLine& line, const FieldPoint& p) {
  return std::min(line.from.x_m, line.to.x_m) - 1e-9 <= p.x_m && p.x_m <= std::max(line.from.x_m, line.to.x_m) + 1e-9 &&
         std::min(line.from.y_m, line.to.y_m) - 1e-9 <= p.y_m && p.y_m <= std::max(line.from.y_m, line.to.y_m) + 1e-9;
}
bool ends(const FieldLine& line, const FieldPoint& p) { return same(line.from, p) || same(line.to, p); }

TEST(SoccerField, HasTheLinesOfTheFieldThatIsPlayedOn) {
  const Field field;
  const auto painted = plant::field_lines(plant::kKidField);
  std::size_t marks = 0;
  for (const plant::FieldLine& p : painted) {
    const FieldPoint from{p.x0_m, p.y0_m}, to{p.x1_m, p.y1_m};
    if (math::hypot(to.x_m - from.x_m, to.y_m - from.y_m) < 0.5) {
      ++marks;
      continue;
    }
    EXPECT_TRUE(std::ranges::any_of(field.lines(), [&](const FieldLine& l) { return ends(l, from) && ends(l, to); }))
        << from.x_m << ' ' << from.y_m << " to " << to.x_m << ' ' << to.y_m;
  }
  EXPECT_EQ(field.lines().size() + marks, painted.size());
}

TEST(SoccerField, HasACornerWhereverTwoLinesMeet) {
  const Field field;
  std::size_t corners = 0;
  for (std::size_t a = 0; a < field.lines().size(); ++a)
    for (std::size_t b = a + 1; b < field.lines().size(); ++b) {
      const FieldLine &l = field.lines()[a], &m = field.lines()[b];
      const bool l_upright = l.from.x_m == l.to.x_m, m_upright = m.from.x_m == m.to.x_m;
      if (l_upright == m_upright) continue;
      const FieldPoint at{l_upright ? l.from.x_m : m.from.x_m, l_upright ? m.from.y_m : l.from.y_m};
      if (!on(l, at) || !on(m, at)) continue;
      const FieldMark kind = ends(l, at) && ends(m, at) ? FieldMark::corner_l : FieldMark::corner_t;
      ++corners;
      const auto found = std::ranges::find_if(field.corners(), [&](const FieldCorner& c) { return same(c.at, at); });
      ASSERT_NE(found, field.corners().end()) << at.x_m << ' ' << at.y_m;
      EXPECT_EQ(found->kind, kind) << at.x_m << ' ' << at.y_m;
      // A step along the heading stays between the two lines of an L, and on the line of a T that ends.
      const double step = 0.1, x = at.x_m + step * math::cos(found->heading_rad),
                   y = at.y_m + step * math::sin(found->heading_rad);
      if (kind == FieldMark::corner_t)
        EXPECT_TRUE(on(ends(l, at) ? l : m, {x, y})) << at.x_m << ' ' << at.y_m;
      else
        EXPECT_TRUE((on(l, {at.x_m, y}) && on(m, {x, at.y_m})) || (on(m, {at.x_m, y}) && on(l, {x, at.y_m})));
    }
  EXPECT_EQ(corners + 2, field.corners().size());  // and the two at the circle
}

TEST(SoccerField, IsTheSameAfterHalfATurn) {
  const Field field;
  for (const FieldCorner& c : field.corners())
    EXPECT_EQ(std::ranges::count_if(field.corners(),
                                    [&](const FieldCorner& o) {
                                      const double turn = math::wrap_pi(o.heading_rad - c.heading_rad);
                                      return o.kind == c.kind && same(o.at, {-c.at.x_m, -c.at.y_m}) &&
                                             (c.kind == FieldMark::corner_x ||
                                              math::fabs(math::fabs(turn) - math::kPi) < 1e-9);
                                    }),
              1)
        << c.at.x_m << ' ' << c.at.y_m;
  EXPECT_TRUE(field.holds({4.4, -2.9}));
  EXPECT_FALSE(field.holds({4.6, 0}));
  EXPECT_TRUE(field.holds({4.6, 0}, 0.2));
}

}  // namespace
}  // namespace sinew::soccer
