// What scoring 500 poses by 10 sightings takes, beside the same one pose at a time (docs/soccer-world.md), and what a
// picture costs the whole filter.
#include <cstdio>
#include <cstring>

#include "apps/locate/field_walk.hpp"
#include "math/random.hpp"
#include "pairs.hpp"
#include "soccer/world/locator.hpp"

namespace {

using namespace sinew;
using namespace sinew::soccer;
using Kind = ScoredSight::Kind;

constexpr int kPairs = 40, kReps = 200;
constexpr std::size_t kPoses = 500, kSights = 10;

std::array<ScoredSight, kSights> sights(std::size_t lines) {
  std::array<ScoredSight, kSights> all{};
  math::Random random(3);
  for (std::size_t i = 0; i < kSights; ++i) {
    ScoredSight& o = all[i];
    if (i >= lines) o.kind = static_cast<Kind>(1 + i % 6);
    const math::SinCos t = math::sincos(random.uniform(-3, 3));
    o.ahead = static_cast<float>(t.cos), o.left = static_cast<float>(t.sin), o.half_m = 0.5F;
    o.x_m = static_cast<float>(random.uniform(0, 4)), o.y_m = static_cast<float>(random.uniform(-2, 2));
    o.per_m2 = 10, o.per_angle2 = 20;
  }
  return all;
}

bool measure(const char* name, const PoseScore& score, std::size_t lines) {
  ScoredPoses four, one;
  math::Random random(5);
  while (four.count < kPoses) four.add(random.uniform(-5, 5), random.uniform(-4, 4), random.uniform(-4, 4));
  one = four;
  const auto seen = sights(lines);
  const bench::Ratio r = bench::alternate(
      kPairs, kReps, [&] { score.score(seen, four); }, [&] { score.score_one_by_one(seen, one); });
  const bool same = std::memcmp(four.cost.data(), one.cost.data(), kPoses * sizeof(float)) == 0;
  if (!same) std::printf("%s: not the same bits\n", name);
  return bench::report(name, r, 1) && same;
}

}  // namespace

int main() {
  const Field field;
  const PoseScore score(field);
  bool good = measure("score_500_poses_10_lines", score, 10);
  good = measure("score_500_poses_5_lines_5_marks", score, 5) && good;

  locate::FieldWalk walk(field, 1);
  Locator locator(field);
  locator.forget(true);
  std::vector<double> us;
  while (walk.now_s() < 120) {
    const msg::SoccerSight& seen = walk.step();
    const auto begin = std::chrono::steady_clock::now();
    locator.see(seen, true);
    us.push_back(std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - begin).count());
  }
  std::printf("one picture, all of the filter: %.1f us median, %.1f p99\n", bench::quantile(us, 0.5),
              bench::quantile(us, 0.99));
  return good ? 0 : 1;
}
