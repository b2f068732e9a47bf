// What soccer/sight takes for a picture, beside the least that could be done with it: reading the same pixels and
// looking each up in a table.
//
//   sight_bench [BODY.toml]
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <ctime>
#include <vector>

#include "apps/sight/scenes.hpp"
#include "apps/toml/body_reader.hpp"

namespace {

using namespace sinew;

/// Of this process's processor time.
double core_us() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return 1e6 * static_cast<double>(now.tv_sec) + 1e-3 * static_cast<double>(now.tv_nsec);
}

std::uint32_t floor_of(const vision::ImageView& image, const std::uint8_t* table) {
  std::uint32_t sum = 0;
  for (std::uint32_t y = 0; y < image.height; ++y) {
    const std::uint8_t* p = image.row(y);
    for (std::uint32_t x = 0; x < image.width; x += 2, p += 4) {
      sum += table[soccer::FieldColours::index(p[0], p[1], p[3])];
      sum += table[soccer::FieldColours::index(p[2], p[1], p[3])];
    }
  }
  return sum;
}

}  // namespace

int main(int argc, char** argv) {
  const app::LoadedBody loaded = app::load_body(argc > 1 ? argv[1] : "robots/kid/op3.toml");
  if (!loaded.problems.empty()) return std::fprintf(stderr, "sight_bench: no body\n"), 2;
  constexpr std::size_t kScenes = 40;
  std::printf("processor time of one core, %zu scenes: median of all, mean, largest\n", kScenes);
  for (const std::uint32_t width : {320U, 640U}) {
    sight::SceneMaker maker(loaded.body, {.width = width, .height = width * 3 / 4, .seed = 5});
    std::vector<sight::Scene> scenes(kScenes);
    for (std::size_t i = 0; i < kScenes; ++i) maker.make(i, scenes[i]);
    soccer::FieldSight eyes;
    const soccer::FieldColours colours;
    msg::SoccerSight seen;
    std::vector<double> whole, least;
    std::uint32_t sum = 0;
    constexpr int kTimes = 9;
    for (const sight::Scene& s : scenes) {
      const soccer::GroundView view = s.ground(false);
      if (!view.is_upright()) continue;
      std::vector<double> a, b;
      for (int k = 0; k < kTimes; ++k) {
        const double t0 = core_us();
        eyes.look(s.view(), view, seen);
        const double t1 = core_us();
        sum += floor_of(s.view(), colours.table());
        const double t2 = core_us();
        a.push_back(t1 - t0), b.push_back(t2 - t1);
      }
      std::ranges::sort(a), std::ranges::sort(b);
      whole.push_back(a[kTimes / 2]), least.push_back(b[kTimes / 2]);
    }
    std::ranges::sort(whole), std::ranges::sort(least);
    const auto mean = [](const std::vector<double>& v) {
      double all = 0;
      for (const double x : v) all += x;
      return all / static_cast<double>(v.size());
    };
    std::printf(
        "%ux%u: all of soccer/sight %.0f us, %.0f, %.0f; floor (each pixel read and looked up) %.0f us, %.0f, %.0f; "
        "%.1f times its floor (%u)\n",
        width, width * 3 / 4, whole[whole.size() / 2], mean(whole), whole.back(), least[least.size() / 2], mean(least),
        least.back(), mean(whole) / mean(least), sum & 1);
  }
}
