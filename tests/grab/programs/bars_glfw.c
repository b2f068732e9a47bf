/* bars_glfw FRAMES: frame numbers by GLFW, which opens libGL itself. */
#define GLFW_INCLUDE_GLCOREARB
#include <GLFW/glfw3.h>
#include <stdlib.h>

#include "bars.h"

static PFNGLENABLEPROC enable;
static PFNGLSCISSORPROC scissor;
static PFNGLCLEARCOLORPROC clear_color;
static PFNGLCLEARPROC clear;

static void fill(int x, int y, int width, int height, float r, float g, float b) {
  enable(GL_SCISSOR_TEST);
  scissor(x, y, width, height);
  clear_color(r, g, b, 1);
  clear(GL_COLOR_BUFFER_BIT);
}

int main(int argc, char** argv) {
  unsigned number, frames = argc > 1 ? (unsigned)atoi(argv[1]) : 100;
  if (!glfwInit()) return 2;
  glfwWindowHint(GLFW_RESIZABLE, GLFW_FALSE);
  GLFWwindow* window = glfwCreateWindow(640, 480, "bars", NULL, NULL);
  if (window == NULL) return 2;
  glfwMakeContextCurrent(window);
  enable = (PFNGLENABLEPROC)glfwGetProcAddress("glEnable");
  scissor = (PFNGLSCISSORPROC)glfwGetProcAddress("glScissor");
  clear_color = (PFNGLCLEARCOLORPROC)glfwGetProcAddress("glClearColor");
  clear = (PFNGLCLEARPROC)glfwGetProcAddress("glClear");
  for (number = 1; number <= frames; ++number) {
    bars_draw(number, 640, 480, fill);
    long long before = bars_now_ns();
    glfwSwapBuffers(window);
    bars_told(number, before, 640, 480, 0);
    glfwPollEvents();
    struct timespec pause = {0, 16000000};
    nanosleep(&pause, NULL);
  }
  glfwTerminate();
  return 0;
}
