// The functions that programs call instead of those of their window system. A program comes to them in three ways: it
// is linked with libGL or libEGL (our symbols are found first), it opens the library and asks dlsym(), or it asks
// glXGetProcAddress() or eglGetProcAddress(). SDL, GLFW, Qt and Wine use the last two.
#include <dlfcn.h>

#include <cstddef>
#include <cstring>

#include "grab/preload/gl_pictures.hpp"

#define SINEW_EXPORTED extern "C" __attribute__((visibility("default")))

namespace sinew::grab {
namespace {

using Function = void (*)();
using Drawable = unsigned long;

enum Hook : unsigned {
  kGlxSwapBuffers,
  kGlxSwapBuffersMsc,
  kGlxGetProc,
  kGlxGetProcArb,
  kGlxCreateWindow,
  kGlxDestroyWindow,
  kXDestroyWindow,
  kEglSwapBuffers,
  kEglSwapWithDamageKhr,
  kEglSwapWithDamageExt,
  kEglGetProc,
  kEglCreateSurface,
  kEglCreatePlatform,
  kEglCreatePlatformExt,
  kEglDestroySurface,
  kHooks
};
constexpr const char* kNames[kHooks] = {"glXSwapBuffers",
                                        "glXSwapBuffersMscOML",
                                        "glXGetProcAddress",
                                        "glXGetProcAddressARB",
                                        "glXCreateWindow",
                                        "glXDestroyWindow",
                                        "XDestroyWindow",
                                        "eglSwapBuffers",
                                        "eglSwapBuffersWithDamageKHR",
                                        "eglSwapBuffersWithDamageEXT",
                                        "eglGetProcAddress",
                                        "eglCreateWindowSurface",
                                        "eglCreatePlatformWindowSurface",
                                        "eglCreatePlatformWindowSurfaceEXT",
                                        "eglDestroySurface"};

/// A process may have several libraries with a function of one name: ANGLE has its own eglSwapBuffers and calls the
/// system's. So each function that was found gets an entry of ours of its own; entry 0 is for calls that the linker
/// bound. When all are used the program gets the function itself, and its pictures are not seen.
constexpr std::size_t kEntries = 4;
std::atomic<Function> reals[kHooks][kEntries];

// A call within a call is the driver's own business.
thread_local int depth __attribute__((tls_model("initial-exec"))) = 0;
struct Inside {
  Inside() noexcept { ++depth; }
  ~Inside() { --depth; }
  Inside(const Inside&) = delete;
  Inside& operator=(const Inside&) = delete;
};

using Dlsym = void* (*)(void*, const char*);
std::atomic<Dlsym> real_dlsym_{nullptr};

/// The C library's own. Its version is that of the first C library of the machine, or of 2.34, which moved it.
Dlsym real_dlsym() noexcept {
  Dlsym real = real_dlsym_.load(std::memory_order_relaxed);
  if (real != nullptr) return real;
  constexpr const char* kVersions[] = {"GLIBC_2.2.5", "GLIBC_2.0",  "GLIBC_2.4",  "GLIBC_2.17",
                                       "GLIBC_2.27",  "GLIBC_2.36", "GLIBC_2.34", "GLIBC_2.2"};
  for (const char* version : kVersions) {
    real = reinterpret_cast<Dlsym>(::dlvsym(RTLD_NEXT, "dlsym", version));
    if (real != nullptr) break;
  }
  real_dlsym_.store(real, std::memory_order_relaxed);
  return real;
}

void* looked_up(void* handle, const char* name) noexcept {
  const Dlsym real = real_dlsym();
  return real == nullptr ? nullptr : real(handle, name);
}

/// In a library that the process has already; it is not loaded for us.
void* in_loaded(const char* library, const char* name) noexcept {
  void* handle = ::dlopen(library, RTLD_LAZY | RTLD_NOLOAD);
  if (handle == nullptr) return nullptr;
  void* found = looked_up(handle, name);
  ::dlclose(handle);  // the program's own handle keeps it
  return found;
}

void* in_any_loaded(const char* name, bool egl) noexcept {
  constexpr const char* kGlx[] = {"libGL.so.1", "libGLX.so.0", "libX11.so.6"};
  constexpr const char* kEgl[] = {"libEGL.so.1", "libGLESv2.so.2", "libOpenGL.so.0", "libGL.so.1"};
  void* found = nullptr;
  if (egl) {
    for (const char* library : kEgl)
      if (found == nullptr) found = in_loaded(library, name);
  } else {
    for (const char* library : kGlx)
      if (found == nullptr) found = in_loaded(library, name);
  }
  return found;
}

bool is_egl(Hook hook) noexcept { return hook >= kEglSwapBuffers; }

/// The function behind an entry. Null: the process has none.
template <class F>
F real_of(Hook hook, std::size_t entry) noexcept {
  Function real = reals[hook][entry].load(std::memory_order_acquire);
  if (real == nullptr && entry == 0) {
    real = reinterpret_cast<Function>(looked_up(RTLD_NEXT, kNames[hook]));
    if (real == nullptr) real = reinterpret_cast<Function>(in_any_loaded(kNames[hook], is_egl(hook)));
    reals[hook][0].store(real, std::memory_order_release);
  }
  return reinterpret_cast<F>(real);
}

void* hooked(const char* name, void* real) noexcept;

// ---- GLX

void* glx_function(const char* name) noexcept {
  using GetProc = Function (*)(const unsigned char*);
  auto get = real_of<GetProc>(kGlxGetProcArb, 0);
  if (get == nullptr) get = real_of<GetProc>(kGlxGetProc, 0);
  return get == nullptr ? nullptr : reinterpret_cast<void*>(get(reinterpret_cast<const unsigned char*>(name)));
}

template <class F>
F glx(const char* name, std::atomic<void*>& cache) noexcept {
  void* found = cache.load(std::memory_order_relaxed);
  if (found == nullptr) {
    found = glx_function(name);
    cache.store(found, std::memory_order_relaxed);
  }
  return reinterpret_cast<F>(found);
}

/// Asks the driver, and the driver the X server: only when a picture is to be read.
bool glx_size(const GlPlace& place, Size& size) noexcept {
  static std::atomic<void*> cache{nullptr};
  constexpr int kWidth = 0x801D, kHeight = 0x801E;
  const auto query = glx<void (*)(const void*, Drawable, int, unsigned*)>("glXQueryDrawable", cache);
  if (query == nullptr) return false;
  query(place.display, static_cast<Drawable>(place.key), kWidth, &size.width);
  query(place.display, static_cast<Drawable>(place.key), kHeight, &size.height);
  return size.width != 0 && size.height != 0;
}

void before_glx_swap(void* display, Drawable drawable) noexcept {
  if (memory() == nullptr) return;
  static std::atomic<void*> context_cache{nullptr}, draw_cache{nullptr}, read_cache{nullptr};
  const auto context = glx<const void* (*)()>("glXGetCurrentContext", context_cache);
  const auto draw = glx<Drawable (*)()>("glXGetCurrentDrawable", draw_cache);
  const auto read = glx<Drawable (*)()>("glXGetCurrentReadDrawable", read_cache);
  if (context == nullptr || draw == nullptr || read == nullptr) return;
  // A program may swap what is not current: then there is nothing to read it with.
  const void* current = context();
  if (current == nullptr || draw() != drawable || read() != drawable) return;
  picture_of_gl({Api::glx, display, drawable, current, glx_function, glx_size});
}

template <std::size_t N>
void glx_swap(void* display, Drawable drawable) noexcept {
  const auto real = real_of<void (*)(void*, Drawable)>(kGlxSwapBuffers, N);
  if (real == nullptr) return;
  if (depth == 0) {
    const Inside inside;
    before_glx_swap(display, drawable);
    real(display, drawable);
  } else {
    real(display, drawable);
  }
}

template <std::size_t N>
std::int64_t glx_swap_msc(void* display, Drawable drawable, std::int64_t target, std::int64_t divisor,
                          std::int64_t remainder) noexcept {
  const auto real =
      real_of<std::int64_t (*)(void*, Drawable, std::int64_t, std::int64_t, std::int64_t)>(kGlxSwapBuffersMsc, N);
  if (real == nullptr) return -1;
  if (depth != 0) return real(display, drawable, target, divisor, remainder);
  const Inside inside;
  before_glx_swap(display, drawable);
  return real(display, drawable, target, divisor, remainder);
}

template <Hook H, std::size_t N>
Function glx_get_proc(const unsigned char* name) noexcept {
  const auto real = real_of<Function (*)(const unsigned char*)>(H, N);
  if (real == nullptr) return nullptr;
  return reinterpret_cast<Function>(hooked(reinterpret_cast<const char*>(name), reinterpret_cast<void*>(real(name))));
}

template <std::size_t N>
Drawable glx_create_window(void* display, void* config, Drawable window, const int* attributes) noexcept {
  const auto real = real_of<Drawable (*)(void*, void*, Drawable, const int*)>(kGlxCreateWindow, N);
  if (real == nullptr) return 0;
  const Drawable made = real(display, config, window, attributes);
  if (made != 0) note_x11_window(Api::glx, display, made, window);
  return made;
}

template <std::size_t N>
void glx_destroy_window(void* display, Drawable window) noexcept {
  const auto real = real_of<void (*)(void*, Drawable)>(kGlxDestroyWindow, N);
  if (real == nullptr) return;
  forget_window(Api::glx, display, window);
  real(display, window);
}

template <std::size_t N>
int x_destroy_window(void* display, Drawable window) noexcept {
  const auto real = real_of<int (*)(void*, Drawable)>(kXDestroyWindow, N);
  if (real == nullptr) return 0;
  forget_window(Api::glx, display, window);
  return real(display, window);
}

// ---- EGL

void* egl_function(const char* name) noexcept {
  const auto get = real_of<Function (*)(const char*)>(kEglGetProc, 0);
  void* found = get == nullptr ? nullptr : reinterpret_cast<void*>(get(name));
  if (found == nullptr) found = in_any_loaded(name, true);  // before EGL 1.5 it knows extensions only
  return found;
}

template <class F>
F egl(const char* name, std::atomic<void*>& cache) noexcept {
  void* found = cache.load(std::memory_order_relaxed);
  if (found == nullptr) {
    found = egl_function(name);
    cache.store(found, std::memory_order_relaxed);
  }
  return reinterpret_cast<F>(found);
}

constexpr int kEglDraw = 0x3059, kEglRead = 0x305A, kEglHeight = 0x3056, kEglWidth = 0x3057;

bool egl_size(const GlPlace& place, Size& size) noexcept {
  static std::atomic<void*> cache{nullptr};
  const auto query = egl<unsigned (*)(const void*, const void*, int, int*)>("eglQuerySurface", cache);
  if (query == nullptr) return false;
  const auto* surface = reinterpret_cast<const void*>(static_cast<std::uintptr_t>(place.key));
  int width = 0, height = 0;
  if (query(place.display, surface, kEglWidth, &width) == 0 || query(place.display, surface, kEglHeight, &height) == 0)
    return false;
  if (width <= 0 || height <= 0) return false;
  size.width = static_cast<std::uint32_t>(width), size.height = static_cast<std::uint32_t>(height);
  return true;
}

void before_egl_swap(void* display, void* surface) noexcept {
  if (memory() == nullptr) return;
  static std::atomic<void*> context_cache{nullptr}, surface_cache{nullptr};
  const auto context = egl<const void* (*)()>("eglGetCurrentContext", context_cache);
  const auto current_surface = egl<const void* (*)(int)>("eglGetCurrentSurface", surface_cache);
  if (context == nullptr || current_surface == nullptr) return;
  const void* current = context();
  if (current == nullptr || current_surface(kEglDraw) != surface || current_surface(kEglRead) != surface) return;
  picture_of_gl({Api::egl, display, static_cast<std::uint64_t>(reinterpret_cast<std::uintptr_t>(surface)), current,
                 egl_function, egl_size});
}

template <std::size_t N>
unsigned egl_swap(void* display, void* surface) noexcept {
  const auto real = real_of<unsigned (*)(void*, void*)>(kEglSwapBuffers, N);
  if (real == nullptr) return 0;
  if (depth != 0) return real(display, surface);
  const Inside inside;
  before_egl_swap(display, surface);
  return real(display, surface);
}

template <Hook H, std::size_t N>
unsigned egl_swap_damage(void* display, void* surface, const int* rectangles, int count) noexcept {
  const auto real = real_of<unsigned (*)(void*, void*, const int*, int)>(H, N);
  if (real == nullptr) return 0;
  if (depth != 0) return real(display, surface, rectangles, count);
  const Inside inside;
  before_egl_swap(display, surface);
  return real(display, surface, rectangles, count);
}

template <std::size_t N>
Function egl_get_proc(const char* name) noexcept {
  const auto real = real_of<Function (*)(const char*)>(kEglGetProc, N);
  if (real == nullptr) return nullptr;
  return reinterpret_cast<Function>(hooked(name, reinterpret_cast<void*>(real(name))));
}

void* noted_surface(void* display, void* surface, std::uint64_t window) noexcept {
  if (surface != nullptr)
    note_x11_window(Api::egl, display, static_cast<std::uint64_t>(reinterpret_cast<std::uintptr_t>(surface)), window);
  return surface;
}

template <std::size_t N>
void* egl_create_surface(void* display, void* config, std::uintptr_t window, const int* attributes) noexcept {
  const auto real = real_of<void* (*)(void*, void*, std::uintptr_t, const int*)>(kEglCreateSurface, N);
  if (real == nullptr) return nullptr;
  return noted_surface(display, real(display, config, window, attributes), window);
}

/// Of X11, `window` points to the window's number. Of other systems it points to something else, whose first bytes are
/// then the number of no window that has a title.
template <Hook H, std::size_t N>
void* egl_create_platform(void* display, void* config, const void* window, const void* attributes) noexcept {
  const auto real = real_of<void* (*)(void*, void*, const void*, const void*)>(H, N);
  if (real == nullptr) return nullptr;
  void* made = real(display, config, window, attributes);
  std::uint32_t number = 0;
  if (made != nullptr && window != nullptr) std::memcpy(&number, window, sizeof number);
  return noted_surface(display, made, number);
}

template <std::size_t N>
unsigned egl_destroy_surface(void* display, void* surface) noexcept {
  const auto real = real_of<unsigned (*)(void*, void*)>(kEglDestroySurface, N);
  if (real == nullptr) return 0;
  forget_window(Api::egl, display, static_cast<std::uint64_t>(reinterpret_cast<std::uintptr_t>(surface)));
  return real(display, surface);
}

// ---- who gets which

template <std::size_t N>
void* entry_of(Hook hook) noexcept {
  switch (hook) {
    case kGlxSwapBuffers:
      return reinterpret_cast<void*>(&glx_swap<N>);
    case kGlxSwapBuffersMsc:
      return reinterpret_cast<void*>(&glx_swap_msc<N>);
    case kGlxGetProc:
      return reinterpret_cast<void*>(&glx_get_proc<kGlxGetProc, N>);
    case kGlxGetProcArb:
      return reinterpret_cast<void*>(&glx_get_proc<kGlxGetProcArb, N>);
    case kGlxCreateWindow:
      return reinterpret_cast<void*>(&glx_create_window<N>);
    case kGlxDestroyWindow:
      return reinterpret_cast<void*>(&glx_destroy_window<N>);
    case kXDestroyWindow:
      return reinterpret_cast<void*>(&x_destroy_window<N>);
    case kEglSwapBuffers:
      return reinterpret_cast<void*>(&egl_swap<N>);
    case kEglSwapWithDamageKhr:
      return reinterpret_cast<void*>(&egl_swap_damage<kEglSwapWithDamageKhr, N>);
    case kEglSwapWithDamageExt:
      return reinterpret_cast<void*>(&egl_swap_damage<kEglSwapWithDamageExt, N>);
    case kEglGetProc:
      return reinterpret_cast<void*>(&egl_get_proc<N>);
    case kEglCreateSurface:
      return reinterpret_cast<void*>(&egl_create_surface<N>);
    case kEglCreatePlatform:
      return reinterpret_cast<void*>(&egl_create_platform<kEglCreatePlatform, N>);
    case kEglCreatePlatformExt:
      return reinterpret_cast<void*>(&egl_create_platform<kEglCreatePlatformExt, N>);
    case kEglDestroySurface:
      return reinterpret_cast<void*>(&egl_destroy_surface<N>);
    case kHooks:
      break;
  }
  return nullptr;
}

void* entry_at(Hook hook, std::size_t entry) noexcept {
  switch (entry) {
    case 0:
      return entry_of<0>(hook);
    case 1:
      return entry_of<1>(hook);
    case 2:
      return entry_of<2>(hook);
    case 3:
      return entry_of<3>(hook);
    default:
      return nullptr;
  }
}

Hook hook_of(const char* name) noexcept {
  // Every look-up of the process passes here; few of them begin like ours.
  if (name == nullptr || (std::strncmp(name, "glX", 3) != 0 && std::strncmp(name, "egl", 3) != 0 && name[0] != 'X'))
    return kHooks;
  for (unsigned h = 0; h < kHooks; ++h)
    if (std::strcmp(name, kNames[h]) == 0) return static_cast<Hook>(h);
  return kHooks;
}

void* exported(Hook hook) noexcept;

/// What the program gets in place of `real`, which was found under this name.
void* hooked(const char* name, void* real) noexcept {
  const Hook hook = hook_of(name);
  if (hook == kHooks || real == nullptr || real == exported(hook)) return real;
  for (std::size_t e = 0; e < kEntries; ++e) {
    if (real == entry_at(hook, e)) return real;
    Function known = reals[hook][e].load(std::memory_order_acquire);
    const auto wanted = reinterpret_cast<Function>(real);
    if (known == nullptr && e > 0 && reals[hook][e].compare_exchange_strong(known, wanted)) known = wanted;
    if (known == wanted) return entry_at(hook, e);
  }
  return real;
}

}  // namespace
}  // namespace sinew::grab

using namespace sinew::grab;

// Under the names that the linker binds. A program without such a library never calls them.
SINEW_EXPORTED void glXSwapBuffers(void* display, Drawable drawable) { glx_swap<0>(display, drawable); }
SINEW_EXPORTED std::int64_t glXSwapBuffersMscOML(void* display, Drawable drawable, std::int64_t target,
                                                 std::int64_t divisor, std::int64_t remainder) {
  return glx_swap_msc<0>(display, drawable, target, divisor, remainder);
}
SINEW_EXPORTED Function glXGetProcAddress(const unsigned char* name) { return glx_get_proc<kGlxGetProc, 0>(name); }
SINEW_EXPORTED Function glXGetProcAddressARB(const unsigned char* name) {
  return glx_get_proc<kGlxGetProcArb, 0>(name);
}
SINEW_EXPORTED Drawable glXCreateWindow(void* display, void* config, Drawable window, const int* attributes) {
  return glx_create_window<0>(display, config, window, attributes);
}
SINEW_EXPORTED void glXDestroyWindow(void* display, Drawable window) { glx_destroy_window<0>(display, window); }
SINEW_EXPORTED int XDestroyWindow(void* display, Drawable window) { return x_destroy_window<0>(display, window); }
SINEW_EXPORTED unsigned eglSwapBuffers(void* display, void* surface) { return egl_swap<0>(display, surface); }
SINEW_EXPORTED unsigned eglSwapBuffersWithDamageKHR(void* display, void* surface, const int* rectangles, int count) {
  return egl_swap_damage<kEglSwapWithDamageKhr, 0>(display, surface, rectangles, count);
}
SINEW_EXPORTED unsigned eglSwapBuffersWithDamageEXT(void* display, void* surface, const int* rectangles, int count) {
  return egl_swap_damage<kEglSwapWithDamageExt, 0>(display, surface, rectangles, count);
}
SINEW_EXPORTED Function eglGetProcAddress(const char* name) { return egl_get_proc<0>(name); }
SINEW_EXPORTED void* eglCreateWindowSurface(void* display, void* config, std::uintptr_t window, const int* attributes) {
  return egl_create_surface<0>(display, config, window, attributes);
}
SINEW_EXPORTED void* eglCreatePlatformWindowSurface(void* display, void* config, void* window, const void* attributes) {
  return egl_create_platform<kEglCreatePlatform, 0>(display, config, window, attributes);
}
SINEW_EXPORTED void* eglCreatePlatformWindowSurfaceEXT(void* display, void* config, void* window,
                                                       const void* attributes) {
  return egl_create_platform<kEglCreatePlatformExt, 0>(display, config, window, attributes);
}
SINEW_EXPORTED unsigned eglDestroySurface(void* display, void* surface) {
  return egl_destroy_surface<0>(display, surface);
}

/// The C library finds the caller of RTLD_NEXT by the return address, so this must end in a jump: the call below is the
/// last thing that happens, and this file is compiled with optimisation in every build (grab/preload/CMakeLists.txt).
SINEW_EXPORTED void* dlsym(void* handle, const char* name) noexcept {
  const Dlsym real = real_dlsym();
  if (__builtin_expect(real == nullptr, 0)) return nullptr;
  if (__builtin_expect(hook_of(name) == kHooks, 1)) return real(handle, name);
  return hooked(name, real(handle, name));
}

namespace sinew::grab {
namespace {

void* exported(Hook hook) noexcept {
  switch (hook) {
    case kGlxSwapBuffers:
      return reinterpret_cast<void*>(&::glXSwapBuffers);
    case kGlxSwapBuffersMsc:
      return reinterpret_cast<void*>(&::glXSwapBuffersMscOML);
    case kGlxGetProc:
      return reinterpret_cast<void*>(&::glXGetProcAddress);
    case kGlxGetProcArb:
      return reinterpret_cast<void*>(&::glXGetProcAddressARB);
    case kGlxCreateWindow:
      return reinterpret_cast<void*>(&::glXCreateWindow);
    case kGlxDestroyWindow:
      return reinterpret_cast<void*>(&::glXDestroyWindow);
    case kXDestroyWindow:
      return reinterpret_cast<void*>(&::XDestroyWindow);
    case kEglSwapBuffers:
      return reinterpret_cast<void*>(&::eglSwapBuffers);
    case kEglSwapWithDamageKhr:
      return reinterpret_cast<void*>(&::eglSwapBuffersWithDamageKHR);
    case kEglSwapWithDamageExt:
      return reinterpret_cast<void*>(&::eglSwapBuffersWithDamageEXT);
    case kEglGetProc:
      return reinterpret_cast<void*>(&::eglGetProcAddress);
    case kEglCreateSurface:
      return reinterpret_cast<void*>(&::eglCreateWindowSurface);
    case kEglCreatePlatform:
      return reinterpret_cast<void*>(&::eglCreatePlatformWindowSurface);
    case kEglCreatePlatformExt:
      return reinterpret_cast<void*>(&::eglCreatePlatformWindowSurfaceEXT);
    case kEglDestroySurface:
      return reinterpret_cast<void*>(&::eglDestroySurface);
    case kHooks:
      break;
  }
  return nullptr;
}

}  // namespace
}  // namespace sinew::grab
