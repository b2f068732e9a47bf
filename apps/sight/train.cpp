#include "apps/sight/train.hpp"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <numeric>

namespace sinew::sight {
namespace {

using soccer::BallNet;
using soccer::BallPatch;

constexpr std::size_t kBatch = 64;
constexpr std::uint32_t kOneOf = 2;  // so many patches of no ball are one example
constexpr int kOff = 2;              // patches cut a little off each ball

/// Light and sensors that no scene has: a slope or an edge of shade, noise, another tint.
void disturb(BallPatch& p, math::Random& random) {
  if (random.below(2) != 0) soccer::mirror(p);
  constexpr std::size_t kSide = BallPatch::kSide;
  const auto along = [&](double sigma) { return random.normal(0, sigma) / kSide; };
  const double dx = along(0.4), dy = along(0.4), noise = random.uniform(0, 0.2);
  const double edge = random.below(4) == 0 ? random.normal(0, 0.4) : 0, turn = random.uniform(0, 2 * math::kPi);
  const math::SinCos t = math::sincos(turn);
  const double at = random.uniform(-0.5, 0.5) * kSide;
  for (std::size_t y = 0; y < kSide; ++y)
    for (std::size_t x = 0; x < kSide; ++x) {
      const double rx = static_cast<double>(x) - 7.5, ry = static_cast<double>(y) - 7.5;
      double more = dx * rx + dy * ry + (t.cos * rx + t.sin * ry > at ? edge : 0);
      const std::uint32_t draw = random.next_u32();  // four bytes together are nearly normal
      more += noise *
              (static_cast<double>((draw & 255) + (draw >> 8 & 255) + (draw >> 16 & 255) + (draw >> 24)) - 510) / 147.8;
      p.value[y * kSide + x] += static_cast<float>(more);
    }
  for (std::size_t c = 0; c < 2; ++c) {
    const auto gain = static_cast<float>(random.uniform(0.8, 1.2)), tint = static_cast<float>(random.normal(0, 0.05));
    for (std::size_t i = 0; i < BallPatch::kChroma; ++i) {
      float& v = p.value[BallPatch::kLuma + c * BallPatch::kChroma + i];
      v = v * gain + tint;
    }
  }
}

/// Gradients of one example, added up.
class Slope {
 public:
  explicit Slope(const std::vector<float>& w)
      : w_(w), net_(std::span<const float, BallNet::kWeights>(w)), g_(w.size()) {}
  std::vector<float>& all() { return g_; }
  /// The loss.
  double add(const BallPatch& patch, bool is_ball);

 private:
  /// Where the larger of 2 x 2 places was, of what was given on.
  template <std::size_t kSide, std::size_t kOut, std::size_t kStride>
  static void spread(const float* before, const float* after, const float* slope, float* to);

  const std::vector<float>& w_;
  BallNet net_;
  BallNet::Trace t_{};
  std::vector<float> g_;
  std::array<float, BallNet::kFlat> flat_{};
  std::array<float, BallNet::kSide2 * BallNet::kSide2 * BallNet::kSecond> second_{};
  std::array<float, BallPatch::kChroma * BallNet::kDeep> deep_{};
  std::array<float, BallPatch::kLuma * BallNet::kFirst> first_{};
};

template <std::size_t kSide, std::size_t kOut, std::size_t kStride>
void Slope::spread(const float* before, const float* after, const float* slope, float* to) {
  std::fill_n(to, kSide * kSide * kOut, 0.0F);
  for (std::size_t y = 0; y < kSide / 2; ++y)
    for (std::size_t x = 0; x < kSide / 2; ++x, after += kStride, slope += kStride)
      for (std::size_t k = 0; k < kOut; ++k) {
        if (!(after[k] > 0)) continue;
        const std::size_t first = (2 * y * kSide + 2 * x) * kOut + k;
        for (const std::size_t at : {first, first + kOut, first + kSide * kOut, first + (kSide + 1) * kOut})
          if (before[at] == after[k]) {
            to[at] = slope[k];
            break;
          }
      }
}

double Slope::add(const BallPatch& patch, bool is_ball) {
  using N = BallNet;
  net_.run(patch, t_);
  const double p = 1 / (1 + math::exp(-std::clamp(static_cast<double>(t_.out), -30.0, 30.0)));
  const auto error = static_cast<float>(p - (is_ball ? 1 : 0));
  std::array<float, N::kUnits> du{};
  for (std::size_t k = 0; k < N::kUnits; ++k) {
    g_[N::kAt4 + k] += error * t_.units[k];
    du[k] = t_.units[k] > 0 ? error * w_[N::kAt4 + k] : 0;
    g_[N::kOffset3 + k] += du[k];
  }
  g_[N::kOffset4] += error;
  for (std::size_t i = 0; i < N::kFlat; ++i) {
    const float x = t_.flat[i];
    const float* const w = &w_[N::kAt3 + i * N::kUnits];
    float* const g = &g_[N::kAt3 + i * N::kUnits];
    float sum = 0;
    for (std::size_t k = 0; k < N::kUnits; ++k) sum += w[k] * du[k];
    for (std::size_t k = 0; k < N::kUnits; ++k) g[k] += x * du[k];
    flat_[i] = sum;
  }
  spread<N::kSide2, N::kSecond, N::kSecond>(t_.second.data(), t_.flat.data(), flat_.data(), second_.data());
  deep_.fill(0);
  for (std::size_t y = 0; y < N::kSide2; ++y)
    for (std::size_t x = 0; x < N::kSide2; ++x) {
      const float* const d = &second_[(y * N::kSide2 + x) * N::kSecond];
      for (std::size_t k = 0; k < N::kSecond; ++k) {
        if (d[k] == 0) continue;
        const float one = d[k];
        g_[N::kOffset2 + k] += one;
        for (std::size_t row = 0; row < 3; ++row) {
          const std::size_t in = ((y + row) * N::kPool1 + x) * N::kDeep;
          const float* w = &w_[N::kAt2 + row * 3 * N::kDeep * N::kSecond + k];
          float* g = &g_[N::kAt2 + row * 3 * N::kDeep * N::kSecond + k];
          for (std::size_t i = 0; i < 3 * N::kDeep; ++i, w += N::kSecond, g += N::kSecond) {
            *g += t_.deep[in + i] * one;
            deep_[in + i] += *w * one;
          }
        }
      }
    }
  spread<BallPatch::kSide, N::kFirst, N::kDeep>(t_.first.data(), t_.deep.data(), deep_.data(), first_.data());
  constexpr std::size_t kWide = BallPatch::kSide + 2;
  for (std::size_t y = 0; y < BallPatch::kSide; ++y)
    for (std::size_t x = 0; x < BallPatch::kSide; ++x) {
      const float* const d = &first_[(y * BallPatch::kSide + x) * N::kFirst];
      for (std::size_t k = 0; k < N::kFirst; ++k) {
        if (d[k] == 0) continue;
        g_[N::kOffset1 + k] += d[k];
        for (std::size_t tap = 0; tap < N::kTaps; ++tap)
          g_[N::kAt1 + tap * N::kFirst + k] += d[k] * t_.luma[(y + tap / 3) * kWide + x + tap % 3];
      }
    }
  return -math::log(std::max(1e-12, is_ball ? p : 1 - p));
}

}  // namespace

Verdict verdict(const soccer::BallCandidate& c, const std::optional<Scene::Ball>& ball) {
  if (!ball || !(ball->visible > 0.02)) return Verdict::not_ball;
  const double off = math::hypot(c.u_px - ball->u_px, c.v_px - ball->v_px), r = ball->radius_px;
  const double size = c.radius_px / r;
  if (off < 0.45 * r + 1 && size > 0.65 && size < 1.5) return ball->visible > 0.3 ? Verdict::ball : Verdict::unclear;
  return off < 1.2 * r + c.radius_px ? Verdict::unclear : Verdict::not_ball;
}

void collect(SceneMaker& maker, std::uint64_t first, std::uint64_t count, bool as_they_come,
             std::vector<Example>& out) {
  Scene scene;
  soccer::FieldSight sight;
  msg::SoccerSight seen;
  math::Random few(first, 8);
  for (std::uint64_t n = first; n < first + count; ++n) {
    maker.make(n, scene);
    const soccer::GroundView view = scene.ground(false);
    if (!sight.look(scene.view(), view, seen) || !sight.border().found()) continue;
    for (const soccer::BallCandidate& c : sight.candidates().all()) {
      const Verdict v = verdict(c, scene.ball);
      if (v == Verdict::unclear) continue;
      if (v == Verdict::not_ball && !as_they_come && few.below(kOneOf) != 0) continue;
      Example e;
      soccer::take_patch(sight.picture(), sight.carpet(), c, e.patch);
      e.is_ball = v == Verdict::ball;
      out.push_back(e);
    }
    if (as_they_come || !scene.ball || !(scene.ball->visible > 0.3)) continue;
    const Scene::Ball& b = *scene.ball;
    const auto expected = view.ball_radius_px(b.u_px, b.v_px, soccer::SightOptions{}.ball_radius_m);
    for (int k = 0; k < kOff && expected && sight.picture().holds(b.u_px, b.v_px); ++k) {
      soccer::BallCandidate c{b.u_px + few.normal(0, 0.13 * b.radius_px + 0.3),
                              b.v_px + few.normal(0, 0.13 * b.radius_px + 0.3),
                              b.radius_px * math::exp(few.normal(0, 0.07)), *expected, 0};
      c.fit = soccer::BallCandidates::fit(sight.picture(), c.u_px, c.v_px, c.radius_px);
      if (verdict(c, scene.ball) != Verdict::ball) continue;
      Example e;
      soccer::take_patch(sight.picture(), sight.carpet(), c, e.patch);
      e.is_ball = true;
      out.push_back(e);
    }
  }
}

std::vector<float> train(std::span<const Example> examples, const Training& how) {
  using N = BallNet;
  math::Random random(how.seed, 9);
  std::vector<float> w(N::kWeights), m(w.size()), v(w.size());
  Slope slope(w);
  std::vector<float>& g = slope.all();
  const auto fill = [&](std::size_t from, std::size_t in, std::size_t out) {
    const double sigma = math::sqrt(2.0 / static_cast<double>(in));
    for (std::size_t i = 0; i < in * out; ++i) w[from + i] = static_cast<float>(random.normal(0, sigma));
  };
  fill(N::kAt1, N::kTaps, N::kFirst), fill(N::kAt2, N::kTaps * N::kDeep, N::kSecond);
  fill(N::kAt3, N::kFlat, N::kUnits), fill(N::kAt4, N::kUnits, 1);
  std::vector<std::size_t> order(examples.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  constexpr double kBeta1 = 0.9, kBeta2 = 0.999, kDecay = 1e-4;
  double power1 = 1, power2 = 1;
  const std::size_t batches = examples.size() / kBatch, all = batches * static_cast<std::size_t>(how.epochs);
  for (int epoch = 0; epoch < how.epochs; ++epoch) {
    for (std::size_t i = order.size(); i > 1; --i)
      std::swap(order[i - 1], order[random.below(static_cast<std::uint32_t>(i))]);
    double loss = 0;
    for (std::size_t at = 0; at < batches; ++at) {
      std::fill(g.begin(), g.end(), 0.0F);
      for (std::size_t k = 0; k < kBatch; ++k) {
        const Example& e = examples[order[at * kBatch + k]];
        BallPatch patch = e.patch;
        disturb(patch, random);
        loss += slope.add(patch, e.is_ball);
      }
      power1 *= kBeta1, power2 *= kBeta2;
      const double done =
          static_cast<double>(static_cast<std::size_t>(epoch) * batches + at) / static_cast<double>(all);
      const double rate = how.rate * 0.5 * (1 + math::cos(math::kPi * done));
      const auto step = static_cast<float>(rate * math::sqrt(1 - power2) / (1 - power1));
      const auto shrink = static_cast<float>(1 - rate * kDecay);
      for (std::size_t i = 0; i < w.size(); ++i) {
        const float d = g[i] / kBatch;
        m[i] = static_cast<float>(kBeta1) * m[i] + static_cast<float>(1 - kBeta1) * d;
        v[i] = static_cast<float>(kBeta2) * v[i] + static_cast<float>(1 - kBeta2) * d * d;
        w[i] = w[i] * shrink - step * m[i] / (__builtin_sqrtf(v[i]) + 1e-8F);
      }
    }
    std::fprintf(stderr, "epoch %d: loss %.5f\n", epoch + 1, loss / static_cast<double>(batches * kBatch));
  }
  return w;
}

void calibrate(std::vector<float>& weights, std::span<const Example> as_they_come) {
  const BallNet net(std::span<const float, BallNet::kWeights>{weights});
  BallNet::Trace trace;
  std::vector<double> odds;
  for (const Example& e : as_they_come) {
    net.run(e.patch, trace);
    odds.push_back(std::clamp(static_cast<double>(trace.out), -30.0, 30.0));
  }
  // Newton's steps; the loss is convex.
  double scale = 1, more = 0;
  for (int round = 0; round < 30; ++round) {
    double gs = 0, gm = 0, hss = 1e-6, hsm = 0, hmm = 1e-6;
    for (std::size_t i = 0; i < odds.size(); ++i) {
      const double p = 1 / (1 + math::exp(-std::clamp(scale * odds[i] + more, -30.0, 30.0)));
      const double off = p - (as_they_come[i].is_ball ? 1 : 0), h = p * (1 - p);
      gs += off * odds[i], gm += off;
      hss += h * odds[i] * odds[i], hsm += h * odds[i], hmm += h;
    }
    const double det = hss * hmm - hsm * hsm;
    scale -= std::clamp((hmm * gs - hsm * gm) / det, -0.3, 0.3),
        more -= std::clamp((hss * gm - hsm * gs) / det, -1.0, 1.0);
  }
  std::fprintf(stderr, "odds: times %.3f, and %+.3f\n", scale, more);
  for (std::size_t k = 0; k <= BallNet::kUnits; ++k)
    weights[BallNet::kAt4 + k] = static_cast<float>(scale * weights[BallNet::kAt4 + k]);
  weights[BallNet::kOffset4] += static_cast<float>(more);
}

bool save(const std::string& path, std::span<const Example> examples, std::string& why) {
  std::ofstream file(path, std::ios::binary);
  for (const Example& e : examples) {
    file.put(e.is_ball ? 1 : 0);
    file.write(reinterpret_cast<const char*>(e.patch.value.data()), sizeof e.patch.value);
  }
  if (!file.flush()) return why = path + " cannot be written", false;
  return true;
}

bool load(const std::string& path, std::vector<Example>& out, std::string& why) {
  std::error_code error;
  const auto bytes = std::filesystem::file_size(path, error);
  constexpr std::size_t kEach = 1 + sizeof(soccer::BallPatch::value);
  if (error || bytes % kEach != 0)
    return why = path + ": no patches of " + std::to_string(kEach) + " bytes each", false;
  std::ifstream file(path, std::ios::binary);
  for (std::size_t i = 0; i < bytes / kEach; ++i) {
    Example e;
    e.is_ball = file.get() == 1;
    file.read(reinterpret_cast<char*>(e.patch.value.data()), sizeof e.patch.value);
    out.push_back(e);
  }
  if (!file) return why = path + " cannot be read", false;
  return true;
}

std::string weights_source(const std::vector<float>& weights, const std::string& command) {
  std::string out = "// Generated by:\n// " + command +
                    "\n// docs/soccer-vision.md\n#include \"soccer/sight/ball_net.hpp\"\n\nnamespace sinew::soccer {\n"
                    "namespace {\n\n// clang-format off\nconstexpr std::array<float, BallNet::kWeights> kBall = {\n";
  std::string line;
  for (const float w : weights) {
    char number[32];
    std::snprintf(number, sizeof number, "%.3eF,", static_cast<double>(w));
    if (line.size() + std::char_traits<char>::length(number) > 118) out += line + "\n", line.clear();
    line += number;
  }
  return out + line +
         "\n};\n// clang-format on\n\n}  // namespace\n\nstd::span<const float, BallNet::kWeights> "
         "trained_ball_weights() { return kBall; }\n\n}  // namespace sinew::soccer\n";
}

}  // namespace sinew::sight
