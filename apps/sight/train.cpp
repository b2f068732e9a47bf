#include "apps/sight/train.hpp"

#include <algorithm>
#include <cstdio>
#include <numeric>

namespace sinew::sight {
namespace {

using soccer::BallNet;
using soccer::BallPatch;

constexpr std::size_t kIn = BallNet::kInputs, kA = BallNet::kFirst, kB = BallNet::kSecond;
constexpr std::size_t kBatch = 64;
constexpr std::uint32_t kOneOf = 3;  // so many patches of no ball are one example

void mirror(BallPatch& p) {
  const auto rows = [&](std::size_t from, std::size_t side) {
    for (std::size_t r = 0; r < side; ++r) std::reverse(&p.value[from + r * side], &p.value[from + r * side] + side);
  };
  constexpr std::size_t kSide = BallPatch::kSide, kChroma = BallPatch::kChromaSide;
  rows(0, kSide), rows(kSide * kSide, kChroma), rows(kSide * kSide + kChroma * kChroma, kChroma);
}

/// Adds the gradient of one example; the loss.
double add_gradient(const std::vector<float>& w, const BallPatch& patch, bool is_ball, std::vector<float>& g) {
  const float* const wa = w.data();
  const float* const ba = wa + kIn * kA;
  const float* const wb = ba + kA;
  const float* const bb = wb + kA * kB;
  const float* const wo = bb + kB;
  std::array<float, kA> a{}, da{};
  std::array<float, kB> b{}, db{};
  std::copy_n(ba, kA, a.begin());
  for (std::size_t i = 0; i < kIn; ++i)
    for (std::size_t k = 0; k < kA; ++k) a[k] += patch.value[i] * wa[i * kA + k];
  for (float& x : a) x = std::max(0.0F, x);
  std::copy_n(bb, kB, b.begin());
  for (std::size_t i = 0; i < kA; ++i)
    for (std::size_t k = 0; k < kB; ++k) b[k] += a[i] * wb[i * kB + k];
  for (float& x : b) x = std::max(0.0F, x);
  double out = wo[kB];
  for (std::size_t k = 0; k < kB; ++k) out += static_cast<double>(b[k]) * wo[k];
  const double p = 1 / (1 + math::exp(-std::clamp(out, -30.0, 30.0)));
  const auto error = static_cast<float>(p - (is_ball ? 1 : 0));
  float* const ga = g.data();
  float* const gba = ga + kIn * kA;
  float* const gb = gba + kA;
  float* const gbb = gb + kA * kB;
  float* const go = gbb + kB;
  for (std::size_t k = 0; k < kB; ++k) go[k] += error * b[k], db[k] = b[k] > 0 ? error * wo[k] : 0;
  go[kB] += error;
  for (std::size_t i = 0; i < kA; ++i) {
    float sum = 0;
    for (std::size_t k = 0; k < kB; ++k) gb[i * kB + k] += a[i] * db[k], sum += db[k] * wb[i * kB + k];
    da[i] = a[i] > 0 ? sum : 0;
  }
  for (std::size_t k = 0; k < kB; ++k) gbb[k] += db[k];
  for (std::size_t i = 0; i < kIn; ++i)
    for (std::size_t k = 0; k < kA; ++k) ga[i * kA + k] += patch.value[i] * da[k];
  for (std::size_t k = 0; k < kA; ++k) gba[k] += da[k];
  return -math::log(std::max(1e-12, is_ball ? p : 1 - p));
}

}  // namespace

Verdict verdict(const soccer::BallCandidate& c, const std::optional<Scene::Ball>& ball) {
  if (!ball || !(ball->visible > 0.02)) return Verdict::not_ball;
  const double off = math::hypot(c.u_px - ball->u_px, c.v_px - ball->v_px), r = ball->radius_px;
  const double size = c.radius_px / r;
  if (off < 0.4 * r + 0.8 && size > 0.65 && size < 1.5) return ball->visible > 0.3 ? Verdict::ball : Verdict::unclear;
  return off < 1.2 * r + c.radius_px ? Verdict::unclear : Verdict::not_ball;
}

void collect(SceneMaker& maker, std::uint64_t first, std::uint64_t count, std::vector<Example>& out) {
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
      if (v == Verdict::not_ball && few.below(kOneOf) != 0) continue;
      Example e;
      soccer::take_patch(sight.picture(), sight.carpet(), c, e.patch);
      e.is_ball = v == Verdict::ball;
      out.push_back(e);
    }
  }
}

std::vector<float> train(const std::vector<Example>& examples, const Training& how) {
  math::Random random(how.seed, 9);
  std::vector<float> w(BallNet::kWeights), g(w.size()), m(w.size()), v(w.size());
  const auto fill = [&](std::size_t from, std::size_t in, std::size_t out) {
    const double sigma = math::sqrt(2.0 / static_cast<double>(in));
    for (std::size_t i = 0; i < in * out; ++i) w[from + i] = static_cast<float>(random.normal(0, sigma));
  };
  fill(0, kIn, kA), fill((kIn + 1) * kA, kA, kB), fill((kIn + 1) * kA + (kA + 1) * kB, kB, 1);
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
        if (random.below(2) != 0) mirror(patch);
        loss += add_gradient(w, patch, e.is_ball, g);
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
  // Odds as among all candidates.
  w.back() -= static_cast<float>(math::log(kOneOf));
  return w;
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
