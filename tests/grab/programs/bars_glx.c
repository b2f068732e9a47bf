/* bars_glx FRAMES FPS WIDTH HEIGHT [--resize FRAME WIDTHxHEIGHT] [--windows N] [--state] [--read-every N]
 *          [--titles TITLE,TITLE,...] [--turn-titles FRAME]
 * Frame numbers by GLX, linked with libGL as glxgears is. --state: leaves every state that a reader of pixels could
 * disturb at an unusual value, and checks at each frame that it is still there (exit code 3). --read-every N: reads its
 * own picture at each Nth frame (bench/grab_bench.py). --turn-titles: from that frame on each window has the title of the
 * next one. */
#define GL_GLEXT_PROTOTYPES
#include <GL/gl.h>
#include <GL/glext.h>
#include <GL/glx.h>
#include <X11/Xlib.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bars.h"

static void fill(int x, int y, int width, int height, float r, float g, float b) {
  glEnable(GL_SCISSOR_TEST);
  glScissor(x, y, width, height);
  glClearColor(r, g, b, 1);
  glClear(GL_COLOR_BUFFER_BIT);
}

static GLuint framebuffer, pack_buffer;
static unsigned char own[1280 * 960 * 4];

static void set_state(void) {
  glGenFramebuffers(1, &framebuffer);
  glGenBuffers(1, &pack_buffer);
  glBindBuffer(GL_PIXEL_PACK_BUFFER, pack_buffer);
  glBufferData(GL_PIXEL_PACK_BUFFER, 64, NULL, GL_STREAM_READ);
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glPixelStorei(GL_PACK_ROW_LENGTH, 77);
  glPixelStorei(GL_PACK_SKIP_ROWS, 3);
  glPixelStorei(GL_PACK_SKIP_PIXELS, 5);
  glPixelStorei(GL_PACK_SWAP_BYTES, 1);
  glReadBuffer(GL_FRONT);
}

static int is(GLenum name, GLint wanted) {
  GLint value = -1;
  glGetIntegerv(name, &value);
  if (value != wanted) fprintf(stderr, "state 0x%x is %d, was %d\n", name, value, wanted);
  return value == wanted;
}

static int state_is_there(GLuint read_framebuffer) {
  int good = is(GL_PIXEL_PACK_BUFFER_BINDING, (GLint)pack_buffer) & is(GL_PACK_ALIGNMENT, 1) & is(GL_PACK_ROW_LENGTH, 77) &
             is(GL_PACK_SKIP_ROWS, 3) & is(GL_PACK_SKIP_PIXELS, 5) & is(GL_PACK_SWAP_BYTES, 1) &
             is(GL_READ_FRAMEBUFFER_BINDING, (GLint)read_framebuffer);
  if (read_framebuffer == 0) good &= is(GL_READ_BUFFER, GL_FRONT);
  GLenum error = glGetError();
  if (error != GL_NO_ERROR) fprintf(stderr, "error 0x%x\n", error);
  return good && error == GL_NO_ERROR;
}

/* Window w gets the title number w of those between commas. */
static void set_titles(Display* display, const Window* window, int windows, const char* titles, int first) {
  char all[256], *title[8], *at;
  int count = 0, w;
  strncpy(all, titles, sizeof all - 1), all[sizeof all - 1] = 0;
  for (at = strtok(all, ","); at != NULL && count < 8; at = strtok(NULL, ",")) title[count++] = at;
  for (w = 0; w < windows && count > 0; ++w) XStoreName(display, window[w], title[(w + first) % count]);
  XSync(display, False);
}

int main(int argc, char** argv) {
  unsigned frames = argc > 1 ? (unsigned)atoi(argv[1]) : 100, resize_at = 0, number;
  double fps = argc > 2 ? atof(argv[2]) : 60;
  int width[8], height[8], new_width = 0, new_height = 0, windows = 1, check = 0, read_every = 0, i, w;
  const char* titles = NULL;
  unsigned turn_at = 0;
  for (w = 0; w < 8; ++w) width[w] = argc > 3 ? atoi(argv[3]) : 640, height[w] = argc > 4 ? atoi(argv[4]) : 480;
  for (i = 5; i < argc; ++i) {
    if (strcmp(argv[i], "--resize") == 0 && i + 2 < argc) {
      resize_at = (unsigned)atoi(argv[i + 1]);
      sscanf(argv[i + 2], "%dx%d", &new_width, &new_height);
    }
    if (strcmp(argv[i], "--windows") == 0 && i + 1 < argc) windows = atoi(argv[i + 1]);
    if (strcmp(argv[i], "--state") == 0) check = 1;
    if (strcmp(argv[i], "--titles") == 0 && i + 1 < argc) titles = argv[i + 1];
    if (strcmp(argv[i], "--turn-titles") == 0 && i + 1 < argc) turn_at = (unsigned)atoi(argv[i + 1]);
    if (strcmp(argv[i], "--read-every") == 0 && i + 1 < argc) read_every = atoi(argv[i + 1]);
  }
  Display* display = XOpenDisplay(NULL);
  if (display == NULL || windows > 8) return 2;
  int attributes[] = {GLX_RGBA, GLX_DOUBLEBUFFER, GLX_RED_SIZE, 8, GLX_GREEN_SIZE, 8, GLX_BLUE_SIZE, 8, None};
  XVisualInfo* visual = glXChooseVisual(display, DefaultScreen(display), attributes);
  if (visual == NULL) return 2;
  XSetWindowAttributes more = {0};
  more.colormap = XCreateColormap(display, DefaultRootWindow(display), visual->visual, AllocNone);
  Window window[8];
  for (w = 0; w < windows; ++w) {
    window[w] = XCreateWindow(display, DefaultRootWindow(display), 40 * w, 40 * w, (unsigned)width[w], (unsigned)height[w], 0,
                              visual->depth, InputOutput, visual->visual, CWColormap, &more);
    XMapWindow(display, window[w]);
  }
  if (titles != NULL) set_titles(display, window, windows, titles, 0);
  GLXContext context = glXCreateContext(display, visual, NULL, True);
  glXMakeCurrent(display, window[0], context);
  if (check) set_state();
  long long start = bars_now_ns();
  for (number = 1; number <= frames; ++number) {
    if (number == resize_at) {
      XResizeWindow(display, window[0], (unsigned)new_width, (unsigned)new_height);
      XSync(display, False);
      width[0] = new_width, height[0] = new_height;
    }
    if (number == turn_at && titles != NULL) set_titles(display, window, windows, titles, 1);
    for (w = 0; w < windows; ++w) {
      if (windows > 1) glXMakeCurrent(display, window[w], context);
      GLuint read_framebuffer = check && number % 2 == 0 ? framebuffer : 0;
      if (check) glBindFramebuffer(GL_FRAMEBUFFER, 0);
      glViewport(0, 0, width[w], height[w]);
      bars_draw(number + 1000u * (unsigned)w, width[w], height[w], fill);
      if (check) glBindFramebuffer(GL_READ_FRAMEBUFFER, read_framebuffer);
      if (read_every > 0 && number % (unsigned)read_every == 0)
        glReadPixels(0, 0, width[w], height[w], GL_BGRA, GL_UNSIGNED_BYTE, own);
      long long before = bars_now_ns();
      glXSwapBuffers(display, window[w]);
      if (fps > 0 || number % 64 == 0) bars_told(number + 1000u * (unsigned)w, before, width[w], height[w], w);
      if (check && !state_is_there(read_framebuffer)) return 3;
    }
    if (fps > 0) {
      long long due = start + (long long)(number * 1e9 / fps);
      struct timespec until = {due / 1000000000, due % 1000000000};
      clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, NULL);
    }
  }
  fprintf(stderr, "frames %u in %.6f s\n", frames, (double)(bars_now_ns() - start) * 1e-9);
  glXMakeCurrent(display, None, NULL);
  glXDestroyContext(display, context);
  XCloseDisplay(display);
  return 0;
}
