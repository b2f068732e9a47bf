// The floor of bench/movie_cost.py: processor time of libjpeg-turbo alone, for each picture of 640x480 that is there as
// planes of full range, thirty times a second as a camera gives them, quality 80.
// usage: jpeg_floor SECONDS [--squares] [--422]
#include <turbojpeg.h>

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <vector>

#include "camera_scene.hpp"
#include "hal/platform.hpp"
#include "images/pixel_rows.hpp"

namespace {

using namespace sinew;
constexpr std::uint32_t kWidth = 640, kHeight = 480, kHz = 30, kPictures = 8;

struct Planes {
  std::vector<std::uint8_t> y, u, v;
};

Planes planes_of(const std::uint8_t* yuyv, bool half_rows) {
  const std::uint32_t step = half_rows ? 2 : 1, pairs = kWidth / 2;
  Planes p;
  p.y.resize(kWidth * kHeight), p.u.resize(pairs * kHeight / step), p.v.resize(p.u.size());
  for (std::uint32_t row = 0; row < kHeight; ++row)
    images::luma_of_yuyv(yuyv + 2 * kWidth * row, kWidth, &p.y[kWidth * row]);
  for (std::uint32_t row = 0; row < kHeight / step; ++row) {
    const std::uint8_t* const in = yuyv + 2 * kWidth * row * step;
    images::mean_chroma_of_yuyv(in, half_rows ? in + 2 * kWidth : in, pairs, &p.u[pairs * row], &p.v[pairs * row]);
  }
  return p;
}

std::int64_t processor_ns() {
  timespec t{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return std::int64_t{t.tv_sec} * 1'000'000'000 + t.tv_nsec;
}

}  // namespace

int main(int argc, char** argv) {
  bool squares = false, half_rows = true;
  for (int i = 2; i < argc; ++i) {
    squares |= std::strcmp(argv[i], "--squares") == 0;
    if (std::strcmp(argv[i], "--422") == 0) half_rows = false;
  }
  const int count = argc > 1 ? std::atoi(argv[1]) * static_cast<int>(kHz) : 0;
  if (count <= 0) return std::fprintf(stderr, "usage: jpeg_floor SECONDS [--squares] [--422]\n"), 2;
  std::vector<Planes> pictures;
  {
    bench::NoisySquares painter;
    const bench::ShadedDiscs discs(kWidth, kHeight);
    std::vector<std::uint8_t> yuyv(2 * kWidth * kHeight);
    for (std::uint32_t p = 0; p < kPictures; ++p) {
      if (squares) painter.paint(p, kWidth, kHeight, [&](std::uint32_t row) { return &yuyv[2 * kWidth * row]; });
      pictures.push_back(planes_of(squares ? yuyv.data() : discs.picture(p).data(), half_rows));
    }
  }
  const int samples = half_rows ? TJSAMP_420 : TJSAMP_422;
  std::vector<std::uint8_t> file(tjBufSize(kWidth, kHeight, samples));
  const tjhandle handle = tjInitCompress();
  hal::Os& os = hal::system_os();
  const std::int64_t begin = processor_ns();
  const hal::Time start = os.now();
  std::size_t bytes = 0;
  for (int i = 0; i < count; ++i) {
    os.sleep_until(start + hal::Duration(1'000'000'000LL * i / kHz));
    const Planes& p = pictures[static_cast<std::size_t>(i) % pictures.size()];
    const std::uint8_t* planes[3] = {p.y.data(), p.u.data(), p.v.data()};
    const int strides[3] = {kWidth, kWidth / 2, kWidth / 2};
    std::uint8_t* to = file.data();
    unsigned long size = file.size();
    if (tjCompressFromYUVPlanes(handle, planes, kWidth, strides, kHeight, samples, &to, &size, 80, TJFLAG_NOREALLOC) !=
        0)
      return 1;
    bytes += size;
  }
  std::printf("%.1f us a picture of %.1f kB\n", static_cast<double>(processor_ns() - begin) / 1e3 / count,
              static_cast<double>(bytes) / 1e3 / count);
  tjDestroy(handle);
}
