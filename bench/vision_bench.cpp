// Segmentation, elementary motion and bins of pixels at 640x480, each beside its floor.
// usage: vision_bench [PAIRS]
#include <cstdlib>
#include <cstring>

#include "pairs.hpp"
#include "vision/elementary_motion.hpp"
#include "vision/luma.hpp"
#include "vision/segmentation.hpp"
#include "vision_floor.hpp"

namespace {

using namespace sinew;
using namespace sinew::vision;
namespace fl = bench::floor;
using bench::keep;

constexpr int kWidth = fl::kWidth, kHeight = fl::kHeight;
constexpr std::uint32_t kMinArea = 60;
constexpr Rgb kObject[fl::kColours] = {{235, 110, 30}, {30, 60, 200}, {60, 190, 40}, {230, 220, 40}};

std::uint32_t g_state = 1;
int noise(int amplitude) {  // xorshift; only has to be cheap
  g_state ^= g_state << 13, g_state ^= g_state >> 17, g_state ^= g_state << 5;
  return int(g_state % std::uint32_t(2 * amplitude + 1)) - amplitude;
}

// Soft shading, a dozen flat discs in four colours, sensor noise: like a camera's picture as far as time is concerned.
Rgb scene(int x, int y, int shift) {
  const int base = 70 + x * 50 / kWidth + y * 40 / kHeight + (((x / 40 + y / 40) & 1) != 0 ? 8 : 0);
  Rgb c{base + 2, base + 6, base};
  for (int o = 0; o < 12; ++o) {
    const int dx = x - (50 + o % 4 * 170 + shift * (o % 3)), dy = y - (70 + o / 4 * 160), r = 14 + 3 * o;
    if (dx * dx + dy * dy < r * r) c = kObject[o % 4];
  }
  return {c.r + noise(4), c.g + noise(4), c.b + noise(4)};
}

struct Frame {
  std::vector<std::uint8_t> yuyv, mono;
};

Frame frame(int shift) {
  Frame f{std::vector<std::uint8_t>(kWidth * kHeight * 2), std::vector<std::uint8_t>(kWidth * kHeight + 64)};
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; x += 2) {
      const Yuv a = to_yuv(scene(x, y, shift)), b = to_yuv(scene(x + 1, y, shift));
      const int at = y * kWidth + x;
      const int bytes[4] = {a.y, (a.u + b.u) / 2, b.y, (a.v + b.v) / 2};
      for (int k = 0; k < 4; ++k) f.yuyv[std::size_t(at * 2 + k)] = std::uint8_t(bytes[k]);
      f.mono[std::size_t(at)] = std::uint8_t(a.y), f.mono[std::size_t(at + 1)] = std::uint8_t(b.y);
    }
  return f;
}

std::array<ColourBox, fl::kColours> boxes() {
  std::array<ColourBox, fl::kColours> out;
  for (std::size_t c = 0; c < out.size(); ++c) {
    const Yuv m = to_yuv(kObject[c]);
    const int mid[3] = {m.y, m.u, m.v}, reach[3] = {24, 16, 16};
    for (std::size_t k = 0; k < 3; ++k) {
      out[c].lo[k] = std::uint8_t(std::max(0, mid[k] - reach[k]));
      out[c].hi[k] = std::uint8_t(std::min(255, mid[k] + reach[k]));
    }
  }
  return out;
}

bool segmentation(const Frame& f, int pairs) {
  const auto colours = boxes();
  std::array<fl::Box, fl::kColours> bare;
  ColourTable table;
  for (std::size_t c = 0; c < colours.size(); ++c) {
    std::memcpy(bare[c].lo, colours[c].lo.data(), 3), std::memcpy(bare[c].hi, colours[c].hi.data(), 3);
    table.add(colours[c]);
  }
  fl::segmentation_setup(bare);
  Segmentation seg({.min_area_px = kMinArea});
  const ImageView image{f.yuyv.data(), kWidth, kHeight, kWidth * 2, msg::PixelFormat::yuyv};

  int floor_blobs = fl::segment_boxes(f.yuyv.data(), kMinArea);
  if (!seg.by_boxes(image, colours) || int(seg.blobs().size()) != floor_blobs || floor_blobs != 12) {
    std::printf("segmentation by boxes: %zu blobs, floor %d, painted 12\n", seg.blobs().size(), floor_blobs);
    return false;
  }
  floor_blobs = fl::segment_table(f.yuyv.data(), kMinArea);
  if (!seg.by_table(image, table) || int(seg.blobs().size()) != floor_blobs) {
    std::printf("segmentation by table: %zu blobs, floor %d\n", seg.blobs().size(), floor_blobs);
    return false;
  }
  bool good = bench::report("segmentation_boxes_640x480",
                            bench::alternate(
                                pairs, 60, [&] { keep(seg.by_boxes(image, colours)); },
                                [&] { keep(fl::segment_boxes(f.yuyv.data(), kMinArea)); }),
                            1.2);
  good &= bench::report("segmentation_table_640x480",
                        bench::alternate(
                            pairs, 30, [&] { keep(seg.by_table(image, table)); },
                            [&] { keep(fl::segment_table(f.yuyv.data(), kMinArea)); }),
                        1.2);
  return good;
}

bool motion(const Frame& f1, const Frame& f2, int pairs) {
  const auto mono = [](const Frame& f) {
    return ImageView{f.mono.data(), kWidth, kHeight, kWidth, msg::PixelFormat::mono8};
  };
  const ImageView older = mono(f1), newer = mono(f2);
  std::vector<float> magnitude(kWidth * kHeight), direction(kWidth * kHeight);
  std::vector<float> floor_magnitude = magnitude, floor_direction = direction;
  bool good =
      bench::report("emd_polar_640x480",
                    bench::alternate(
                        pairs, 60, [&] { correlate_polar(older, newer, magnitude.data(), direction.data()), keep(0); },
                        [&] {
                          fl::emd_polar(f1.mono.data(), f2.mono.data(), floor_magnitude.data(), floor_direction.data());
                          keep(0);
                        }),
                    1.15);
  for (std::size_t i = 0; i < magnitude.size(); ++i) {
    if (i % kWidth == kWidth - 1 || i / kWidth == kHeight - 1) continue;
    const float off = magnitude[i] - floor_magnitude[i], turn = direction[i] - floor_direction[i];
    if (off * off > 1e-12f * magnitude[i] * magnitude[i] || turn * turn > 1e-12f) {
      std::printf("emd differs from its floor at %zu: %g %g\n", i, double(off), double(turn));
      return false;
    }
  }
  std::int64_t sums[2];
  good &= bench::report("emd_sums_640x480",
                        bench::alternate(
                            pairs, 200, [&] { keep(correlate_sums(older, newer).x); },
                            [&] { fl::emd_sums(f1.mono.data(), f2.mono.data(), sums), keep(sums[0]); }),
                        1.2);
  return good;
}

bool bins(const Frame& f, int pairs) {
  constexpr std::uint32_t kBin = 4;
  const ImageView yuyv{f.yuyv.data(), kWidth, kHeight, kWidth * 2, msg::PixelFormat::yuyv};
  const ImageView mono{f.mono.data(), kWidth, kHeight, kWidth, msg::PixelFormat::mono8};
  Luma luma(kWidth * kHeight / (kBin * kBin));
  std::vector<std::uint8_t> bare(kWidth * kHeight / (kBin * kBin));
  const auto one = [&](const char* name, const ImageView& image, auto&& floor) {
    floor();
    if (!luma.take(image, kBin) || std::memcmp(luma.view().data, bare.data(), bare.size()) != 0) {
      std::printf("%s differs from its floor\n", name);
      return false;
    }
    return bench::report(name,
                         bench::alternate(
                             pairs, 200, [&] { keep(luma.take(image, kBin)); }, [&] { floor(), keep(bare[0]); }),
                         1.15);
  };
  const bool a = one("bin4_yuyv_640x480", yuyv, [&] { fl::bin4_yuyv(f.yuyv.data(), bare.data()); });
  const bool b = one("bin4_mono_640x480", mono, [&] { fl::bin4_mono(f.mono.data(), bare.data()); });
  return a && b;
}

}  // namespace

int main(int argc, char** argv) {
  const int pairs = std::max(15, argc > 1 ? std::atoi(argv[1]) : 25);
#ifdef __x86_64__
  if (!__builtin_cpu_supports("avx2") || !__builtin_cpu_supports("fma")) {
    std::printf("skipped: the floors need AVX2 and FMA\n");
    return 0;
  }
#endif
  const Frame f1 = frame(0), f2 = frame(3);
  const bool a = segmentation(f1, pairs), b = motion(f1, f2, pairs), c = bins(f1, pairs);
  return a && b && c ? 0 : 1;
}
