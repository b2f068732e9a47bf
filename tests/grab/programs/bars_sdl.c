/* bars_sdl FRAMES: frame numbers by SDL2, which opens libGL itself. */
#include <SDL.h>
#include <SDL_opengl.h>
#include <stdlib.h>

#include "bars.h"

static void (*enable)(GLenum);
static void (*scissor)(GLint, GLint, GLsizei, GLsizei);
static void (*clear_color)(GLfloat, GLfloat, GLfloat, GLfloat);
static void (*clear)(GLbitfield);

static void fill(int x, int y, int width, int height, float r, float g, float b) {
  enable(GL_SCISSOR_TEST);
  scissor(x, y, width, height);
  clear_color(r, g, b, 1);
  clear(GL_COLOR_BUFFER_BIT);
}

int main(int argc, char** argv) {
  unsigned number, frames = argc > 1 ? (unsigned)atoi(argv[1]) : 100;
  if (SDL_Init(SDL_INIT_VIDEO) != 0) return 2;
  SDL_Window* window = SDL_CreateWindow("bars", 0, 0, 640, 480, SDL_WINDOW_OPENGL);
  if (window == NULL || SDL_GL_CreateContext(window) == NULL) return 2;
  enable = (void (*)(GLenum))SDL_GL_GetProcAddress("glEnable");
  scissor = (void (*)(GLint, GLint, GLsizei, GLsizei))SDL_GL_GetProcAddress("glScissor");
  clear_color = (void (*)(GLfloat, GLfloat, GLfloat, GLfloat))SDL_GL_GetProcAddress("glClearColor");
  clear = (void (*)(GLbitfield))SDL_GL_GetProcAddress("glClear");
  for (number = 1; number <= frames; ++number) {
    SDL_Event event;
    while (SDL_PollEvent(&event))
      if (event.type == SDL_QUIT) return 0; /* SDL makes one of SIGTERM */
    bars_draw(number, 640, 480, fill);
    long long before = bars_now_ns();
    SDL_GL_SwapWindow(window);
    bars_told(number, before, 640, 480, 0);
    SDL_Delay(16);
  }
  SDL_Quit();
  return 0;
}
