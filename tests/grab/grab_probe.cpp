// grab_probe SESSION PICTURES [camera|view] [RATE_HZ] [X,Y,WIDTH,HEIGHT] [WINDOW] [TITLE]: what a robot's camera, or a
// reader of the shared memory, gets of a program that draws bars (programs/bars.h). A line a picture:
//
//   picture NUMBER UPPER LOWER SHOWN_NS THERE_NS SWAP WIDTH HEIGHT WINDOW READ_NS
//
// UPPER and LOWER are the frame's number in the two halves of the picture; -1: bars cannot be read, -2: upside down.
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>

#include "hal/linux/grab/grab_camera.hpp"
#include "hal/linux/grab/grab_view.hpp"
#include "hal/platform.hpp"
#include "msg/image_buffer.hpp"

namespace {

using namespace sinew;
using namespace std::chrono_literals;

constexpr std::uint32_t kBars = 16;

/// `grey(x, y)` of a picture of this size.
template <class Grey>
long number_in(Grey&& grey, std::uint32_t width, std::uint32_t y) {
  long number = 0;
  const std::uint32_t bar = width / kBars;
  for (std::uint32_t i = 0; i < kBars; ++i) {
    const int value = grey(i * bar + bar / 2, y), between = grey(i * bar, y);
    if (between > 40 || value < 90) return -1;
    number = number << 1 | (value > 190 ? 1 : 0);
  }
  return number;
}

struct Shown {
  std::uint32_t number, swap, width, height, window;
  long upper, lower;
  hal::Time shown, there, read;
};

void print(const Shown& s) {
  std::printf("picture %u %ld %ld %lld %lld %u %u %u %u %lld\n", s.number, s.upper, s.lower,
              static_cast<long long>(s.shown.ns), static_cast<long long>(s.there.ns), s.swap, s.width, s.height,
              s.window, static_cast<long long>(s.read.ns));
  std::fflush(stdout);
}

int by_view(const std::string& session, int pictures, double rate_hz, const hal::GrabRegion& region, int window) {
  std::string why;
  auto view = hal::GrabView::open(session, why);
  if (!view) return std::fprintf(stderr, "%s\n", why.c_str()), 2;
  hal::Os& os = hal::system_os();
  hal::Time due = os.now();
  for (int i = 0; i < pictures;) {
    while ((*view)->open_asks() < 2) {
      if (rate_hz > 0) due = due + hal::Duration{static_cast<std::int64_t>(1e9 / rate_hz)};
      (*view)->ask(window < 0 ? hal::GrabView::kAnyWindow : static_cast<std::uint32_t>(window), region,
                   rate_hz > 0 ? due : hal::Time{});
    }
    (*view)->wait(os.now() + 1s);
    const auto p = (*view)->oldest();
    if (!p) {
      if (!(*view)->is_connected()) return std::fprintf(stderr, "the session ended\n"), 1;
      continue;
    }
    if (p->status != grab::AnswerStatus::ok)
      return std::fprintf(stderr, "status %u\n", static_cast<unsigned>(p->status)), 3;
    const auto grey = [&](std::uint32_t x, std::uint32_t y) { return int{p->row(y)[4 * x + 1]}; };
    long upper = number_in(grey, p->width, p->height / 4);
    const std::uint8_t* top = p->row(2);
    const int red = p->order == grab::PixelOrder::bgrx ? top[2] : top[0],
              blue = p->order == grab::PixelOrder::bgrx ? top[0] : top[2];
    if (p->y == 0 && (red < 200 || top[1] > 50 || blue > 50)) upper = -2;
    print({p->number, p->swap, p->window_width, p->window_height, p->window, upper,
           number_in(grey, p->width, p->height * 3 / 4), p->shown, p->there, os.now()});
    (*view)->take();
    ++i;
  }
  return 0;
}

int by_camera(const std::string& session, int pictures, double rate_hz, const hal::GrabRegion& region, int window,
              const std::string& title) {
  std::string why;
  hal::GrabSpec spec;
  spec.name = session, spec.rate_hz = rate_hz, spec.format = msg::PixelFormat::yuyv, spec.window = window;
  spec.title = title;
  spec.x = region.x, spec.y = region.y, spec.region_width = region.width, spec.region_height = region.height;
  hal::Os& os = hal::system_os();
  auto camera = hal::GrabCamera::open(spec, os, why);
  if (!camera) return std::fprintf(stderr, "%s\n", why.c_str()), 2;
  msg::ImageBuffer image(msg::PixelFormat::yuyv, spec.width, spec.height);
  for (int i = 0; i < pictures;) {
    const auto got = (*camera)->read(*image);
    if (!got || !*got) {
      os.sleep_until(os.now() + 1ms);
      continue;
    }
    const auto grey = [&](std::uint32_t x, std::uint32_t y) { return int{image->row(y)[2 * x]}; };
    print({image->frame_number, 0, image->width, image->height, 0, number_in(grey, image->width, image->height / 4),
           number_in(grey, image->width, image->height * 3 / 4), image->stamp, image->stamp, os.now()});
    ++i;
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) return 2;
  const double rate_hz = argc > 4 ? std::atof(argv[4]) : 30;
  sinew::hal::GrabRegion region;
  if (argc > 5) std::sscanf(argv[5], "%d,%d,%u,%u", &region.x, &region.y, &region.width, &region.height);
  const int window = argc > 6 ? std::atoi(argv[6]) : -1;
  const bool view = argc > 3 && std::strcmp(argv[3], "view") == 0;
  if (view) return by_view(argv[1], std::atoi(argv[2]), rate_hz, region, window);
  return by_camera(argv[1], std::atoi(argv[2]), rate_hz, region, window, argc > 7 ? argv[7] : "");
}
