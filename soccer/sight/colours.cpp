#include "soccer/sight/colours.hpp"

#include <algorithm>

namespace sinew::soccer {
namespace {

constexpr double kNear_m = 4;
constexpr double kBlack = 16;                                             // luma below which chroma is noise
constexpr double kDarkest = 6;                                            // luma of samples
constexpr std::size_t kMostSamples = 320 * 240;                           // each second pixel of 640 x 480
constexpr std::uint32_t kSamples = 60;                                    // of the picture's width
constexpr double kChromaStep = 0.015, kLumaStep = 6, kSpreadStep = 0.01;  // of the table's look

/// What any carpet looks like in any light that people play in: more green than red, and not blue.
bool may_be_carpet(double u, double v) { return v < -0.07 && u < 0.06; }

/// Of four values of chroma.
double share(unsigned chroma4, double luma) { return (0.25 * chroma4 - 128) / (luma + kLumaOffset); }

Colour classify(const CarpetLook& c, double y, double du, double dv) {
  const double scale = 1 / (y + kLumaOffset), u = du * scale, v = dv * scale;
  // A cell is 4 wide and pixels are noisy: in the dark the shares are less sure.
  const double sure = 4 * c.spread + 0.035 + 3.0 * scale;
  // Chroma is in proportion to luma; its share of y + kLumaOffset falls in the dark.
  const double dim = (c.luma + kLumaOffset) / c.luma * y * scale;
  const double off_u = u - c.u * dim, off_v = v - c.v * dim, off2 = off_u * off_u + off_v * off_v;
  const double grey2 = u * u + v * v;
  if (y < std::min(0.22 * c.luma, kBlack) && grey2 < 0.5) return Colour::dark;
  if (off2 < sure * sure && off2 < grey2 && y < 2.2 * c.luma + 10) return Colour::carpet;
  if (v > 0.30 && u > -0.42) return Colour::red;
  if (u > 0.24 && v < 0.12) return Colour::blue;
  const double most = 0.16 + 2 * scale;
  if (grey2 < most * most) return y > 1.2 * c.luma ? Colour::white : y < 0.75 * c.luma ? Colour::dark : Colour::other;
  return Colour::other;
}

}  // namespace

FieldColours::FieldColours() : built_{}, table_(16 * 64 * 64) { build(); }

void FieldColours::set(const CarpetLook& look) {
  look_ = look;
  const auto coarse = [](double x, double step) { return step * math::floor(x / step + 0.5); };
  const CarpetLook next{coarse(look.luma, kLumaStep), coarse(look.u, kChromaStep), coarse(look.v, kChromaStep),
                        coarse(look.spread, kSpreadStep)};
  if (next == built_) return;
  built_ = next;
  build();
}

void FieldColours::build() {
  for (unsigned y = 0; y < 16; ++y)
    for (unsigned u = 0; u < 64; ++u)
      for (unsigned v = 0; v < 64; ++v) {
        const double luma = 16.0 * y + 7.5;
        const Colour c = classify(built_, luma, 4.0 * u + 1.5 - 128, 4.0 * v + 1.5 - 128);
        const bool bright = c != Colour::carpet && c != Colour::blue && luma > 0.9 * built_.luma;
        table_[y << 12 | u << 6 | v] = static_cast<std::uint8_t>(static_cast<unsigned>(c) | (bright ? kBright : 0U));
      }
}

CarpetMeter::CarpetMeter() { sample_.reserve(kMostSamples); }

bool CarpetMeter::measure(const vision::ImageView& image, const GroundView& view, CarpetLook& look) {
  count_.fill(0);
  const std::uint32_t step = std::max(2U, image.width / kSamples / 2 * 2);
  sample_.clear();
  std::uint32_t asked = 0;
  for (std::uint32_t y = step / 2; y < image.height; y += step) {
    const std::uint8_t* row = image.row(y);
    for (std::uint32_t x = 0; x + 1 < image.width; x += step) {
      const auto p = view.ground(x, y);
      if (!p) continue;
      const double dx = p->x_m - view.camera_m().x, dy = p->y_m - view.camera_m().y;
      if (dx * dx + dy * dy > kNear_m * kNear_m) continue;
      // Two pairs in each of two rows: in the dark one alone is mostly noise.
      const std::uint8_t *a = row + std::size_t{x & ~1U} * 2,
                         *b = y + 1 < image.height ? image.row(y + 1) + (a - row) : a;
      const std::size_t next = x + 3 < image.width ? 4 : 0;
      const auto sum = [&](std::size_t i) { return a[i] + a[i + next] + b[i] + b[i + next]; };
      const Sample s{static_cast<std::uint16_t>(sum(0) + sum(2)), static_cast<std::uint16_t>(sum(1)),
                     static_cast<std::uint16_t>(sum(3))};
      ++asked;
      if (luma_of(s) < kDarkest || luma_of(s) > 235) continue;
      if (may_be_carpet(share(s.u4, luma_of(s)), share(s.v4, luma_of(s))) && sample_.size() < kMostSamples)
        sample_.push_back(s);
    }
  }
  const auto each = [&](const auto& use) {
    for (const Sample& s : sample_) {
      const double luma = luma_of(s);
      use(luma, share(s.u4, luma), share(s.v4, luma));
    }
  };
  const auto cell = [](double s) { return std::clamp(static_cast<int>(s * 64 + 48), 0, 63); };
  // Counted by shares of chroma in cells of 1/64.
  each([&](double, double u, double v) { ++count_[static_cast<std::size_t>(cell(u) * 64 + cell(v))]; });
  if (asked < 40) return false;
  std::uint32_t most = 0;
  int at_u = 0, at_v = 0;
  // In the dark the noise is wide: a wider place then.
  for (const int half : {1, 3}) {
    most = 0;
    for (int u = half; u < 64 - half; ++u)
      for (int v = half; v < 64 - half; ++v) {
        if (count_[static_cast<std::size_t>(u * 64 + v)] == 0) continue;
        std::uint32_t sum = 0;
        for (int i = -half; i <= half; ++i)
          for (int k = -half; k <= half; ++k) sum += count_[static_cast<std::size_t>((u + i) * 64 + v + k)];
        if (sum > most) most = sum, at_u = u, at_v = v;
      }
    if (most * 8 >= asked) break;
  }
  if (most * 8 < asked) return false;
  double mid_u = (at_u - 47.5) / 64, mid_v = (at_v - 47.5) / 64;
  double n = 0, luma_sum = 0, spread2 = 0;
  for (int round = 0; round < 2; ++round) {
    double sum_u = 0, sum_v = 0, sum2 = 0;
    n = luma_sum = 0;
    each([&](double luma, double u, double v) {
      const double du = u - mid_u, dv = v - mid_v;
      if (du * du + dv * dv > 0.08 * 0.08) return;
      n += 1, luma_sum += luma, sum_u += u, sum_v += v, sum2 += du * du + dv * dv;
    });
    if (n < 20) return false;
    const double shift_u = sum_u / n - mid_u, shift_v = sum_v / n - mid_v;
    mid_u += shift_u, mid_v += shift_v;
    spread2 = std::max(0.0, sum2 / n - shift_u * shift_u - shift_v * shift_v) / 2;
  }
  look = {luma_sum / n, mid_u, mid_v, math::sqrt(spread2)};
  return true;
}

}  // namespace sinew::soccer
