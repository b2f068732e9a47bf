#include "soccer/world/pose_score.hpp"

#include <cstring>

#include "math/elementary.hpp"

namespace sinew::soccer {
namespace {

using Kind = ScoredSight::Kind;
using Four = float __attribute__((vector_size(16)));

// The larger and the smaller; of equal ones the second. Plain comparisons, so that both ways have the same bits.
template <class V>
V larger(V a, V b) {
  return a > b ? a : b;
}
template <class V>
V smaller(V a, V b) {
  return a < b ? a : b;
}
template <class V>
V all(float value) {
  return V{} + value;
}
float magnitude(float a) { return math::fabs(a); }
Four magnitude(Four a) {
  using Bits = std::int32_t __attribute__((vector_size(16)));
  Bits bits;
  std::memcpy(&bits, &a, sizeof bits);
  bits &= 0x7fffffff;
  std::memcpy(&a, &bits, sizeof a);
  return a;
}
template <class V>
V load(const float* from) {
  V v;
  std::memcpy(&v, from, sizeof v);
  return v;
}

}  // namespace

void ScoredPoses::add(double x, double y, double heading_rad) {
  if (full()) return;
  const math::SinCos turn = math::sincos(heading_rad);
  x_m[count] = static_cast<float>(x), y_m[count] = static_cast<float>(y);
  cos[count] = static_cast<float>(turn.cos), sin[count] = static_cast<float>(turn.sin);
  ++count;
}

PoseScore::PoseScore(const Field& field) {
  const FieldSize& f = field.size();
  const auto m = [](double v) { return static_cast<float>(v); };
  const double x = f.length_m / 2, y = f.width_m / 2;
  constexpr double kOverTheMiddle = -100;
  along_ = {Strip{m(y), m(kOverTheMiddle), m(x)},
            {m(f.penalty_area_width_m / 2), m(x - f.penalty_area_length_m), m(x)},
            {m(f.goal_area_width_m / 2), m(x - f.goal_area_length_m), m(x)}};
  across_ = {Strip{0, m(kOverTheMiddle), m(y)},
             {m(x), m(kOverTheMiddle), m(y)},
             {m(x - f.penalty_area_length_m), m(kOverTheMiddle), m(f.penalty_area_width_m / 2)},
             {m(x - f.goal_area_length_m), m(kOverTheMiddle), m(f.goal_area_width_m / 2)}};
  const auto add = [&](Kind kind, const FieldPoint& p) {
    if (p.x_m < 0 || p.y_m < 0) return;
    Places& places = places_[static_cast<std::size_t>(kind)];
    places.x[places.count] = m(p.x_m), places.y[places.count] = m(p.y_m);
    ++places.count;
  };
  for (const FieldCorner& c : field.corners())
    add(c.kind == msg::FieldMark::corner_l   ? Kind::corner_l
        : c.kind == msg::FieldMark::corner_t ? Kind::corner_t
                                             : Kind::corner_x,
        c.at);
  for (const FieldPoint& p : field.penalty_marks()) add(Kind::penalty_mark, p);
  for (const FieldPoint& p : field.posts()) add(Kind::post, p);
  add(Kind::circle, {0, 0});
}

template <class V>
void PoseScore::run(std::span<const ScoredSight> sights, ScoredPoses& poses) const {
  constexpr std::size_t kLanes = sizeof(V) / sizeof(float);
  const V zero = all<V>(0), far = all<V>(1e6F);
  for (std::size_t at = 0; at < poses.count; at += kLanes) std::memcpy(&poses.cost[at], &zero, sizeof zero);
  // Sightings outside, poses inside: what belongs to a sighting stays in registers.
  const auto for_each_pose = [&](const ScoredSight& o, const auto& cost_of) {
    const V most = all<V>(o.most);
    for (std::size_t at = 0; at < poses.count; at += kLanes) {
      const V px = load<V>(&poses.x_m[at]), py = load<V>(&poses.y_m[at]);
      const V c = load<V>(&poses.cos[at]), s = load<V>(&poses.sin[at]);
      const V x = magnitude(px + (c * o.x_m - s * o.y_m)), y = magnitude(py + (s * o.x_m + c * o.y_m));
      const V cost = load<V>(&poses.cost[at]) + smaller<V>(cost_of(x, y, c, s), most);
      std::memcpy(&poses.cost[at], &cost, sizeof cost);
    }
  };
  for (const ScoredSight& o : sights) {
    if (o.kind != Kind::line) {
      const Places& places = places_[static_cast<std::size_t>(o.kind)];
      for_each_pose(o, [&](V x, V y, V, V) {
        V least = far;
        for (std::size_t k = 0; k < places.count; ++k) {
          const V dx = x - places.x[k], dy = y - places.y[k];
          least = smaller<V>(least, dx * dx + dy * dy);
        }
        return least * o.per_m2;
      });
      continue;
    }
    // The nearest of the lines along x, and of those along y. The first of each goes over the middle: it has no end
    // there.
    const V half = all<V>(o.half_m);
    for_each_pose(o, [&](V x, V y, V c, V s) {
      const V ux = magnitude(c * o.ahead - s * o.left), uy = magnitude(s * o.ahead + c * o.left);
      const V end_x = x + half, end_y = y + half, begin_x = half - x;
      V by_x = far, by_y = far;
#pragma GCC unroll 3
      for (std::size_t k = 0; k < along_.size(); ++k) {
        V out = larger<V>(end_x - along_[k].high, zero);
        if (k > 0) out = larger<V>(out, begin_x + along_[k].low);
        const V off = y - along_[k].at;
        by_x = smaller<V>(by_x, off * off + out * out);
      }
#pragma GCC unroll 4
      for (std::size_t k = 0; k < across_.size(); ++k) {
        const V out = larger<V>(end_y - across_[k].high, zero), off = x - across_[k].at;
        by_y = smaller<V>(by_y, off * off + out * out);
      }
      by_x = by_x * o.per_m2 + uy * uy * o.per_angle2;
      by_y = by_y * o.per_m2 + ux * ux * o.per_angle2;
      return ux > uy ? by_x : by_y;
    });
  }
}

void PoseScore::score(std::span<const ScoredSight> sights, ScoredPoses& poses) const { run<Four>(sights, poses); }
void PoseScore::score_one_by_one(std::span<const ScoredSight> sights, ScoredPoses& poses) const {
  run<float>(sights, poses);
}

}  // namespace sinew::soccer
