/* bars_fake FRAMES [NANOSECONDS]: shows the pictures of fake_egl.c, by default 60 a second. */
#include <stdlib.h>

#include "bars.h"

unsigned eglSwapBuffers(void* display, void* surface);
void* eglGetCurrentSurface(int which);

int main(int argc, char** argv) {
  unsigned number, frames = argc > 1 ? (unsigned)atoi(argv[1]) : 100;
  long pause_ns = argc > 2 ? atol(argv[2]) : 16000000;
  for (number = 1; number <= frames; ++number) {
    struct timespec pause = {0, pause_ns};
    long long before = bars_now_ns();
    eglSwapBuffers(NULL, eglGetCurrentSurface(1));
    bars_told(number, before, 640, 480, 0);
    nanosleep(&pause, NULL);
  }
  return 0;
}
