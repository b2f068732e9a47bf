#pragma once
#include "grab/preload/program_side.hpp"

namespace sinew::grab {

/// How to ask for functions of OpenGL, and for the size of what is swapped.
struct GlPlace {
  Api api;
  const void* display;
  std::uint64_t key;    // the drawable or surface
  const void* context;  // that is current
  void* (*function)(const char* name) noexcept;
  bool (*size)(const GlPlace& place, Size& size) noexcept;
};

/// Call before the program's swap, in its thread with its context: reads the back buffer for those who ask. Every state
/// of the context that it changes is set back; it leaves no error in the context. Of the state that glReadPixels obeys
/// only a pixel map or scale of old OpenGL (glPixelTransfer) is not looked after.
void picture_of_gl(const GlPlace& place) noexcept;

}  // namespace sinew::grab
