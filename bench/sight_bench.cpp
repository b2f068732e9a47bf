// What soccer/sight takes for a picture, beside the least that could be done with it: reading the same pixels and
// looking each up in a table. Then each stage by itself, in its order; the network beside as many multiplications and
// additions of numbers that lie in a row.
//
//   sight_bench [BODY.toml]
#include <algorithm>
#include <array>
#include <cstdio>
#include <cstring>
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

float floor_of_net(const float* weights) {
  // 256 x 9 x 8, 36 x 90 x 16 and 148 x 24 multiplications, four at once.
  using Four = float __attribute__((vector_size(16)));
  using N = soccer::BallNet;
  constexpr std::size_t kAll = soccer::BallPatch::kLuma * N::kTaps * N::kFirst +
                               N::kSide2 * N::kSide2 * N::kTaps * N::kDeep * N::kSecond + N::kFlat * N::kUnits;
  Four sum[4] = {}, w;
  float x = 0.5F;
  for (std::size_t i = 0; i < kAll / 4; ++i) {
    std::memcpy(&w, weights + 4 * (i % (N::kWeights / 4)), sizeof w);
    sum[i % 4] += x * w;
  }
  return sum[0][0] + sum[1][1] + sum[2][2] + sum[3][3];
}

/// Each stage of FieldSight::look(), as it does them. `counts`: not the first time, when the table is made anew.
class Stages {
 public:
  static constexpr std::size_t kCount = 9;
  static constexpr const char* kName[kCount] = {"carpet", "classes",  "border",     "line points", "lines, circle",
                                                "marks",  "uprights", "candidates", "network"};
  void look(const vision::ImageView& image, const soccer::GroundView& view, bool counts) {
    double at = core_us();
    const auto took = [&](std::size_t stage) {
      const double now = core_us();
      if (counts) us_[stage].push_back(now - at);
      at = core_us();
    };
    meter_.measure(image, view, carpet_);
    took(0);
    colours_.set(carpet_);
    picture_.read(image, colours_);
    took(1);
    border_.find(picture_, view);
    took(2);
    if (!border_.found()) return;
    points_.find(picture_, view, border_);
    took(3);
    lines_.find(picture_, view, points_.points(), soccer::FieldSize{}.circle_radius_m);
    took(4);
    marks_.find(picture_, view, lines_, points_.points());
    took(5);
    uprights_.find(picture_, view, border_, carpet_);
    took(6);
    candidates_.find(picture_, view, border_, soccer::SightOptions{}.ball_radius_m);
    took(7);
    for (const soccer::BallCandidate& c : candidates_.all()) {
      soccer::BallPatch patch;
      soccer::take_patch(picture_, carpet_, c, patch);
      sum_ += net_.confidence(patch);
    }
    took(8);
    candidates_seen_ += candidates_.all().size(), ++pictures_;
  }
  void print() {
    std::printf("stage by stage, mean us:");
    for (std::size_t i = 0; i < kCount; ++i) {
      double all = 0;
      for (const double v : us_[i]) all += v;
      std::printf("%s %s %.0f", i > 0 ? "," : "", kName[i], all / static_cast<double>(us_[i].size()));
    }
    const double per = static_cast<double>(candidates_seen_) / static_cast<double>(pictures_);
    std::vector<double> floor;
    for (int k = 0; k < 201; ++k) {
      const double t = core_us();
      sum_ += static_cast<double>(floor_of_net(soccer::trained_ball_weights().data()));
      floor.push_back(core_us() - t);
    }
    std::ranges::sort(floor);
    std::printf(" (%.1f candidates; the network's floor %.1f us each) (%d)\n", per, floor[100], sum_ > 0);
  }

 private:
  std::array<std::vector<double>, kCount> us_;
  std::size_t candidates_seen_ = 0, pictures_ = 0;
  double sum_ = 0;
  soccer::CarpetLook carpet_;
  soccer::CarpetMeter meter_;
  soccer::FieldColours colours_;
  soccer::Picture picture_{640, 480};
  soccer::FieldBorder border_;
  soccer::LinePoints points_;
  soccer::LineFinder lines_;
  soccer::MarkFinder marks_;
  soccer::Uprights uprights_;
  soccer::BallCandidates candidates_;
  soccer::BallNet net_{soccer::trained_ball_weights()};
};

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
    Stages stages;
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
        stages.look(s.view(), view, k > 0);  // the table is made anew for another light: not in it
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
    stages.print();
  }
}
