/* What the programs of the tests draw: their frame's number as 16 bars from left to right (white 1, grey 0, the highest
 * bit first), in the upper half of the window and again in the lower half, and a red border on top: so that a picture
 * shows which frame it is, whether it is torn, and whether it is upside down. Between two bars, and right and left, is
 * black. Each swap is a line on standard output:
 *
 *   swap NUMBER BEFORE_NS AFTER_NS WIDTH HEIGHT WINDOW
 */
#ifndef SINEW_TESTS_BARS_H
#define SINEW_TESTS_BARS_H
#include <stdio.h>
#include <time.h>

enum { kBars = 16, kBorder = 8 };

static inline long long bars_now_ns(void) {
  struct timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return (long long)t.tv_sec * 1000000000 + t.tv_nsec;
}

static inline void bars_told(unsigned number, long long before, int width, int height, int window) {
  printf("swap %u %lld %lld %d %d %d\n", number, before, bars_now_ns(), width, height, window);
  fflush(stdout);
}

/* fill(x, y, width, height, red, green, blue): pixels from the lower left, colours 0 or 1 or a half. */
static inline void bars_draw(unsigned number, int width, int height,
                             void (*fill)(int, int, int, int, float, float, float)) {
  int bar = width / kBars, half, i;
  fill(0, 0, width, height, 0, 0, 0);
  for (half = 0; half < 2; ++half)
    for (i = 0; i < kBars; ++i) {
      float value = (number >> (kBars - 1 - i)) & 1 ? 1.f : 0.5f;
      fill(i * bar + bar / 4, half * (height / 2), bar / 2, height / 2, value, value, value);
    }
  fill(0, height - kBorder, width, kBorder, 1, 0, 0);
}
#endif
