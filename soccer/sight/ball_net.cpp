#include "soccer/sight/ball_net.hpp"

#include <algorithm>
#include <cstring>

namespace sinew::soccer {
namespace {

/// The same sums on every machine: lanes are units, not parts of a sum.
using Units = float __attribute__((vector_size(16)));
constexpr std::size_t kLanes = 4;

Units load(const float* from) {
  Units v;
  std::memcpy(&v, from, sizeof v);
  return v;
}

void store(float* to, const Units& v) { std::memcpy(to, &v, sizeof v); }

/// Adds weights times inputs to `sum`, for `count` inputs in a row; the weights' next input.
template <std::size_t kVectors>
const float* add(const float* w, const float* in, std::size_t count, std::array<Units, kVectors>& sum) {
  for (std::size_t i = 0; i < count; ++i, w += kVectors * kLanes) {
    const float x = in[i];
    for (std::size_t k = 0; k < kVectors; ++k) sum[k] += x * load(w + kLanes * k);
  }
  return w;
}

/// 3 x 3 filters over a picture of `kWide` columns and `kDeep` values each; a square of `kSide` results.
template <std::size_t kSide, std::size_t kWide, std::size_t kDeep, std::size_t kOut>
void filter(const float* w, const float* offset, const float* in, float* out) {
  constexpr std::size_t kVectors = kOut / kLanes;
  for (std::size_t y = 0; y < kSide; ++y)
    for (std::size_t x = 0; x < kSide; ++x, out += kOut) {
      std::array<Units, kVectors> sum;
      for (std::size_t k = 0; k < kVectors; ++k) sum[k] = load(offset + kLanes * k);
      const float* at = w;
      for (std::size_t row = 0; row < 3; ++row) at = add(at, in + ((y + row) * kWide + x) * kDeep, 3 * kDeep, sum);
      for (std::size_t k = 0; k < kVectors; ++k) store(out + kLanes * k, sum[k]);
    }
}

/// The largest of 2 x 2 places, at least 0; `to` has `kStride` values for each place.
template <std::size_t kSide, std::size_t kOut, std::size_t kStride>
void take_largest(const float* in, float* to) {
  for (std::size_t y = 0; y < kSide / 2; ++y)
    for (std::size_t x = 0; x < kSide / 2; ++x, to += kStride) {
      const float* const a = in + (2 * y * kSide + 2 * x) * kOut;
      const float* const b = a + kSide * kOut;
      for (std::size_t k = 0; k < kOut; ++k)
        to[k] = std::max(std::max(0.0F, std::max(a[k], a[k + kOut])), std::max(b[k], b[k + kOut]));
    }
}

}  // namespace

void BallNet::run(const BallPatch& patch, Trace& t) const {
  constexpr std::size_t kSide = BallPatch::kSide, kWide = kSide + 2;
  t.luma.fill(0);
  for (std::size_t y = 0; y < kSide; ++y) std::copy_n(&patch.value[y * kSide], kSide, &t.luma[(y + 1) * kWide + 1]);
  const float* const w = w_.data();
  filter<kSide, kWide, 1, kFirst>(w + kAt1, w + kOffset1, t.luma.data(), t.first.data());
  take_largest<kSide, kFirst, kDeep>(t.first.data(), t.deep.data());
  for (std::size_t i = 0; i < BallPatch::kChroma; ++i)
    for (std::size_t c = 0; c < 2; ++c)
      t.deep[i * kDeep + kFirst + c] = patch.value[BallPatch::kLuma + c * BallPatch::kChroma + i];
  filter<kSide2, kPool1, kDeep, kSecond>(w + kAt2, w + kOffset2, t.deep.data(), t.second.data());
  take_largest<kSide2, kSecond, kSecond>(t.second.data(), t.flat.data());
  std::copy_n(&patch.value[BallPatch::kValues - BallPatch::kFacts], BallPatch::kFacts,
              &t.flat[kFlat - BallPatch::kFacts]);
  std::array<Units, kUnits / kLanes> sum;
  for (std::size_t k = 0; k < sum.size(); ++k) sum[k] = load(w + kOffset3 + kLanes * k);
  add(w + kAt3, t.flat.data(), kFlat, sum);
  for (std::size_t k = 0; k < sum.size(); ++k) store(&t.units[kLanes * k], sum[k]);
  t.out = w[kOffset4];
  for (std::size_t k = 0; k < kUnits; ++k) {
    t.units[k] = std::max(0.0F, t.units[k]);
    t.out += t.units[k] * w[kAt4 + k];
  }
}

double BallNet::confidence(const BallPatch& patch) const {
  Trace trace;
  run(patch, trace);
  return 1 / (1 + math::exp(-std::clamp(static_cast<double>(trace.out), -30.0, 30.0)));
}

void mirror(BallPatch& p) {
  const auto rows = [&](std::size_t from, std::size_t side) {
    for (std::size_t r = 0; r < side; ++r) std::reverse(&p.value[from + r * side], &p.value[from + r * side] + side);
  };
  rows(0, BallPatch::kSide);
  for (std::size_t c = 0; c < 2; ++c) rows(BallPatch::kLuma + c * BallPatch::kChroma, BallPatch::kChromaSide);
}

}  // namespace sinew::soccer
