#include "soccer/sight/ball_patch.hpp"

#include <algorithm>

namespace sinew::soccer {

void take_patch(const Picture& picture, const CarpetLook& carpet, const BallCandidate& ball, BallPatch& out) {
  constexpr std::size_t kSide = BallPatch::kSide, kChroma = BallPatch::kChromaSide;
  const double cell = BallPatch::kAcross * ball.radius_px / kSide;
  const int taps = cell > 2.5 ? 3 : cell > 1.2 ? 2 : 1;
  std::array<int, kSide * 3> xs{}, ys{};
  const auto places = [&](std::array<int, kSide * 3>& at, double middle, int most) {
    for (int k = 0; k < static_cast<int>(kSide) * taps; ++k)
      at[static_cast<std::size_t>(k)] =
          std::clamp(static_cast<int>(math::floor(middle + cell * ((k + 0.5) / taps - 0.5 * kSide) + 0.5)), 0, most);
  };
  places(xs, ball.u_px, picture.width() - 1);
  places(ys, ball.v_px, picture.height() - 1);
  std::array<float, kSide * kSide> luma{};
  std::array<float, kChroma * kChroma> u{}, v{}, light{};
  for (std::size_t r = 0; r < kSide; ++r)
    for (int tr = 0; tr < taps; ++tr) {
      const int y = ys[r * static_cast<std::size_t>(taps) + static_cast<std::size_t>(tr)];
      for (std::size_t c = 0; c < kSide; ++c)
        for (int tc = 0; tc < taps; ++tc) {
          const int x = xs[c * static_cast<std::size_t>(taps) + static_cast<std::size_t>(tc)];
          const auto bright = static_cast<float>(picture.luma(x, y));
          luma[r * kSide + c] += bright;
          const std::uint8_t* pair = picture.pair(x, y);
          const std::size_t at = r / 2 * kChroma + c / 2;
          u[at] += static_cast<float>(pair[1]) - 128, v[at] += static_cast<float>(pair[3]) - 128;
          light[at] += bright;
        }
    }
  const float one = 1.0F / static_cast<float>(taps * taps);
  float sum = 0, square = 0;
  for (float& l : luma) l *= one, sum += l, square += l * l;
  constexpr float kN = kSide * kSide;
  const float mean = sum / kN, spread = math::sqrt(std::max(0.0F, square / kN - mean * mean));
  const float scale = 1 / (spread + 6);
  for (std::size_t i = 0; i < luma.size(); ++i) out.value[i] = (luma[i] - mean) * scale;
  const auto base_u = static_cast<float>(carpet.u), base_v = static_cast<float>(carpet.v);
  const float of_cell = 4.0F * static_cast<float>(taps * taps);
  for (std::size_t i = 0; i < u.size(); ++i) {
    const float l = light[i] + of_cell * static_cast<float>(kLumaOffset);
    out.value[luma.size() + i] = 2.5F * (u[i] / l - base_u);
    out.value[luma.size() + u.size() + i] = 2.5F * (v[i] / l - base_v);
  }
  const double half = 0.5 * BallPatch::kAcross * ball.radius_px;
  const auto inside = [half](double middle, double most) {
    return std::max(0.0, std::min(most, middle + half) - std::max(0.0, middle - half)) / (2 * half);
  };
  const double beyond = 1 - inside(ball.u_px, picture.width() - 1.0) * inside(ball.v_px, picture.height() - 1.0);
  float* const fact = &out.value[BallPatch::kValues - BallPatch::kFacts];
  fact[0] = static_cast<float>(2 * ball.fit - 1);
  fact[1] = static_cast<float>(4 * math::log(ball.radius_px / ball.expected_px));
  fact[2] = static_cast<float>(0.7 * math::log(ball.expected_px / 12));
  fact[3] = static_cast<float>(beyond);
}

}  // namespace sinew::soccer
