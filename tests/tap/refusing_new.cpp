// A file of its own, so that the compiler does not see malloc behind new where it warns about free.
#include "refusing_new.hpp"

#include <atomic>
#include <cstdint>
#include <cstdlib>
#include <new>

static std::atomic<std::size_t> most{SIZE_MAX};
static thread_local bool spared = false;

void sinew::test::refuse_above(std::size_t bytes) {
  spared = true;
  most = bytes;
}

void* operator new(std::size_t bytes) {
  if (spared || bytes <= most)
    if (void* p = std::malloc(bytes ? bytes : 1)) return p;
  throw std::bad_alloc();
}
void* operator new[](std::size_t bytes) { return operator new(bytes); }
void operator delete(void* p) noexcept { std::free(p); }
void operator delete[](void* p) noexcept { std::free(p); }
void operator delete(void* p, std::size_t) noexcept { std::free(p); }
void operator delete[](void* p, std::size_t) noexcept { std::free(p); }
