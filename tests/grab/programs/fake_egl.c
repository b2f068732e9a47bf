/* An EGL and OpenGL ES that only tell what they are asked for: for machines without libraries of 32 bits. Its surface is
 * 640x480, and its pixels are the bars of frame `swaps` (bars.h). Built as libfake_egl.so; bars_fake is the program. */
#include <string.h>

#include "bars.h"

static unsigned swaps = 1;
static unsigned char picture[480][640][4];

static void fill(int x, int y, int width, int height, float r, float g, float b) {
  int i, j;
  for (j = y; j < y + height; ++j)
    for (i = x; i < x + width; ++i)
      picture[j][i][0] = (unsigned char)(255 * r), picture[j][i][1] = (unsigned char)(255 * g),
      picture[j][i][2] = (unsigned char)(255 * b);
}

void* eglGetCurrentContext(void) { return &swaps; }
void* eglGetCurrentSurface(int which) { return which ? picture : NULL; }
unsigned eglQuerySurface(void* display, void* surface, int what, int* value) {
  (void)display, (void)surface;
  *value = what == 0x3057 ? 640 : 480;
  return 1;
}
unsigned eglSwapBuffers(void* display, void* surface) {
  (void)display, (void)surface;
  ++swaps;
  return 1;
}
void* eglGetProcAddress(const char* name) {
  (void)name; /* as before EGL 1.5: the program asks the library itself */
  return NULL;
}
const unsigned char* glGetString(unsigned name) {
  (void)name;
  return (const unsigned char*)"OpenGL ES 2.0 fake";
}
void glGetIntegerv(unsigned name, int* value) { *value = name == 0x0D05 ? 4 : 0; }
void glPixelStorei(unsigned name, int value) { (void)name, (void)value; }
void glBindFramebuffer(unsigned target, unsigned name) { (void)target, (void)name; }
void glReadPixels(int x, int y, int width, int height, unsigned format, unsigned type, void* into) {
  int row;
  (void)format, (void)type;
  bars_draw(swaps, 640, 480, fill);
  for (row = 0; row < height; ++row) memcpy((char*)into + row * width * 4, picture[y + row][x], (size_t)width * 4);
}
