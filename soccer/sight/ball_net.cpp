#include "soccer/sight/ball_net.hpp"

#include <algorithm>

namespace sinew::soccer {
namespace {

template <std::size_t kIn, std::size_t kOut>
const float* layer(const float* w, const float* in, std::array<float, kOut>& out) {
  std::copy_n(w + kIn * kOut, kOut, out.begin());
  for (std::size_t i = 0; i < kIn; ++i, w += kOut) {
    const float x = in[i];
    for (std::size_t k = 0; k < kOut; ++k) out[k] += x * w[k];
  }
  return w + kOut;
}

}  // namespace

double BallNet::confidence(const BallPatch& patch) const {
  std::array<float, kFirst> first;
  std::array<float, kSecond> second;
  const float* w = layer<kInputs>(w_.data(), patch.value.data(), first);
  for (float& x : first) x = std::max(0.0F, x);
  w = layer<kFirst>(w, first.data(), second);
  float out = w[kSecond];
  for (std::size_t k = 0; k < kSecond; ++k) out += w[k] * std::max(0.0F, second[k]);
  return 1 / (1 + math::exp(-std::clamp(static_cast<double>(out), -30.0, 30.0)));
}

}  // namespace sinew::soccer
