// Replaces the calls that a step must not make. Outside a step they pass through; inside a step of a real-time module
// the program ends with the name of the call and of the module; for a best-effort module they are counted.
#include "trap.hpp"

#include <dlfcn.h>
#include <fcntl.h>
#include <poll.h>
#include <pthread.h>
#include <sched.h>
#include <semaphore.h>
#include <sys/epoll.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <sys/select.h>
#include <sys/socket.h>
#include <sys/uio.h>
#include <unistd.h>

#include <algorithm>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string_view>
#include <utility>

#include "rt/trap.hpp"

extern "C" {  // glibc's own names for the allocator, so that replacing malloc needs no dlsym (which allocates)
void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void* __libc_memalign(std::size_t, std::size_t);
void __libc_free(void*);
}

namespace {

using sinew::rt::trap::state;

struct Name {
  const char* text;
  consteval Name(const char* t) : text(t) {
    if (std::find(sinew::trap::kCalls.begin(), sinew::trap::kCalls.end(), std::string_view(t)) ==
        sinew::trap::kCalls.end())
      throw "a trapped call must be listed in kCalls";
  }
};

// A 32-bit C library has some functions twice. With 64-bit times and offsets its headers give the names of the first to
// the second: the second ones are replaced here, and passed on to.
const char* symbol(std::string_view name) {
#ifdef __USE_TIME_BITS64
  static constexpr std::pair<std::string_view, const char*> kLong[] = {
      {"mmap", "mmap64"},
      {"pread", "pread64"},
      {"pwrite", "pwrite64"},
      {"open", "open64"},
      {"openat", "openat64"},
      {"fopen", "fopen64"},
      {"ioctl", "__ioctl_time64"},
      {"ppoll", "__ppoll64"},
      {"select", "__select64"},
      {"sendmsg", "__sendmsg64"},
      {"recvmsg", "__recvmsg64"},
      {"pthread_mutex_timedlock", "__pthread_mutex_timedlock64"},
      {"pthread_cond_timedwait", "__pthread_cond_timedwait64"},
      {"pthread_cond_clockwait", "__pthread_cond_clockwait64"},
      {"sem_timedwait", "__sem_timedwait64"},
      {"nanosleep", "__nanosleep64"},
      {"clock_nanosleep", "__clock_nanosleep_time64"},
      {"clock_gettime", "__clock_gettime64"},
  };
  for (const auto& [first, second] : kLong)
    if (name == first) return second;
#endif
  return name.data();
}

template <class F>
F* real(const char* name) {
  return reinterpret_cast<F*>(dlsym(RTLD_NEXT, symbol(name)));
}

[[noreturn]] void fail(const char* call) {
  const char* module = state.module;
  state = {};  // so that reporting may write
  char text[256];
  std::snprintf(text, sizeof(text), "trap: %s called inside a step of module '%s'\n", call, module);
  static auto* real_write = real<ssize_t(int, const void*, size_t)>("write");
  [[maybe_unused]] const auto n = real_write(2, text, std::strlen(text));
  std::abort();
}

inline void check(Name call) {
  if (!state.module) [[likely]]
    return;
  if (!state.best_effort) fail(call.text);
  ++*state.best_effort;
}

// A call made by the replaced function itself must not be trapped a second time.
class Pause {
 public:
  Pause() : saved_(state) { state = {}; }
  ~Pause() { state = saved_; }

 private:
  sinew::rt::trap::State saved_;
};

template <class F, class... A>
auto pass(F*& target, const char* name, A... args) {
  const Pause pause;
  if (!target) target = real<F>(name);
  return target(args...);
}

}  // namespace

namespace sinew::trap {
bool is_set() { return true; }
}  // namespace sinew::trap

extern "C" {

// ---- memory
void* malloc(std::size_t n) {
  check("malloc");
  return __libc_malloc(n);
}
void* calloc(std::size_t n, std::size_t size) {
  check("calloc");
  return __libc_calloc(n, size);
}
void* realloc(void* p, std::size_t n) {
  check("realloc");
  return __libc_realloc(p, n);
}
void free(void* p) { check("free"), __libc_free(p); }
void* memalign(std::size_t a, std::size_t n) {
  check("memalign");
  return __libc_memalign(a, n);
}
void* aligned_alloc(std::size_t a, std::size_t n) {
  check("aligned_alloc");
  return __libc_memalign(a, n);
}
int posix_memalign(void** out, std::size_t a, std::size_t n) {
  check("posix_memalign");
  *out = __libc_memalign(a, n);
  return *out ? 0 : 12;
}

#define SINEW_TRAP(result, name, params, ...) \
  result name params {                        \
    check(#name);                             \
    static result(*target) params = nullptr;  \
    return pass(target, #name, __VA_ARGS__);  \
  }

SINEW_TRAP(void*, mmap, (void* a, size_t n, int p, int f, int fd, off_t o), a, n, p, f, fd, o)
SINEW_TRAP(int, munmap, (void* a, size_t n), a, n)
SINEW_TRAP(int, mprotect, (void* a, size_t n, int p), a, n, p)

// ---- locks and threads
SINEW_TRAP(int, pthread_mutex_lock, (pthread_mutex_t * m), m)
SINEW_TRAP(int, pthread_mutex_trylock, (pthread_mutex_t * m), m)
SINEW_TRAP(int, pthread_mutex_timedlock, (pthread_mutex_t * m, const timespec* t), m, t)
SINEW_TRAP(int, pthread_mutex_unlock, (pthread_mutex_t * m), m)
SINEW_TRAP(int, pthread_rwlock_rdlock, (pthread_rwlock_t * l), l)
SINEW_TRAP(int, pthread_rwlock_wrlock, (pthread_rwlock_t * l), l)
SINEW_TRAP(int, pthread_spin_lock, (pthread_spinlock_t * l), l)
SINEW_TRAP(int, pthread_cond_wait, (pthread_cond_t * c, pthread_mutex_t* m), c, m)
SINEW_TRAP(int, pthread_cond_timedwait, (pthread_cond_t * c, pthread_mutex_t* m, const timespec* t), c, m, t)
SINEW_TRAP(int, pthread_cond_clockwait, (pthread_cond_t * c, pthread_mutex_t* m, clockid_t k, const timespec* t), c, m,
           k, t)
SINEW_TRAP(int, pthread_cond_signal, (pthread_cond_t * c), c)
SINEW_TRAP(int, pthread_cond_broadcast, (pthread_cond_t * c), c)
SINEW_TRAP(int, pthread_create, (pthread_t * t, const pthread_attr_t* a, void* (*f)(void*), void* x), t, a, f, x)
SINEW_TRAP(int, pthread_join, (pthread_t t, void** r), t, r)
SINEW_TRAP(int, sem_wait, (sem_t * s), s)
SINEW_TRAP(int, sem_timedwait, (sem_t * s, const timespec* t), s, t)
SINEW_TRAP(int, sem_post, (sem_t * s), s)
int sched_yield() {
  check("sched_yield");
  static int (*target)() = nullptr;
  return pass(target, "sched_yield");
}

// ---- files, devices, sockets
int open(const char* path, int flags, ...) {
  check("open");
  va_list list;
  va_start(list, flags);
  const mode_t mode = va_arg(list, mode_t);
  va_end(list);
  static int (*target)(const char*, int, mode_t) = nullptr;
  return pass(target, "open", path, flags, mode);
}
int openat(int dir, const char* path, int flags, ...) {
  check("openat");
  va_list list;
  va_start(list, flags);
  const mode_t mode = va_arg(list, mode_t);
  va_end(list);
  static int (*target)(int, const char*, int, mode_t) = nullptr;
  return pass(target, "openat", dir, path, flags, mode);
}
int ioctl(int fd, unsigned long request, ...) {
  check("ioctl");
  va_list list;
  va_start(list, request);
  void* arg = va_arg(list, void*);
  va_end(list);
  static int (*target)(int, unsigned long, void*) = nullptr;
  return pass(target, "ioctl", fd, request, arg);
}
SINEW_TRAP(int, close, (int fd), fd)
SINEW_TRAP(ssize_t, read, (int fd, void* b, size_t n), fd, b, n)
SINEW_TRAP(ssize_t, write, (int fd, const void* b, size_t n), fd, b, n)
SINEW_TRAP(ssize_t, readv, (int fd, const iovec* v, int n), fd, v, n)
SINEW_TRAP(ssize_t, writev, (int fd, const iovec* v, int n), fd, v, n)
SINEW_TRAP(ssize_t, pread, (int fd, void* b, size_t n, off_t o), fd, b, n, o)
SINEW_TRAP(ssize_t, pwrite, (int fd, const void* b, size_t n, off_t o), fd, b, n, o)
SINEW_TRAP(int, poll, (pollfd * p, nfds_t n, int t), p, n, t)
SINEW_TRAP(int, ppoll, (pollfd * p, nfds_t n, const timespec* t, const sigset_t* s), p, n, t, s)
SINEW_TRAP(int, select, (int n, fd_set* r, fd_set* w, fd_set* e, timeval* t), n, r, w, e, t)
SINEW_TRAP(int, epoll_wait, (int fd, epoll_event* e, int n, int t), fd, e, n, t)
SINEW_TRAP(ssize_t, send, (int fd, const void* b, size_t n, int f), fd, b, n, f)
SINEW_TRAP(ssize_t, recv, (int fd, void* b, size_t n, int f), fd, b, n, f)
SINEW_TRAP(ssize_t, sendto, (int fd, const void* b, size_t n, int f, const sockaddr* a, socklen_t l), fd, b, n, f, a, l)
SINEW_TRAP(ssize_t, recvfrom, (int fd, void* b, size_t n, int f, sockaddr* a, socklen_t* l), fd, b, n, f, a, l)
SINEW_TRAP(ssize_t, sendmsg, (int fd, const msghdr* m, int f), fd, m, f)
SINEW_TRAP(ssize_t, recvmsg, (int fd, msghdr* m, int f), fd, m, f)
SINEW_TRAP(int, accept, (int fd, sockaddr* a, socklen_t* l), fd, a, l)
SINEW_TRAP(int, connect, (int fd, const sockaddr* a, socklen_t l), fd, a, l)

// ---- time
SINEW_TRAP(int, nanosleep, (const timespec* t, timespec* r), t, r)
SINEW_TRAP(int, clock_nanosleep, (clockid_t c, int f, const timespec* t, timespec* r), c, f, t, r)
SINEW_TRAP(int, usleep, (useconds_t t), t)
SINEW_TRAP(unsigned, sleep, (unsigned t), t)
SINEW_TRAP(int, clock_gettime, (clockid_t c, timespec* t), c, t)

long syscall(long number, ...) {  // futex and whatever has no wrapper
  check("syscall");
  va_list list;
  va_start(list, number);
  long a[6];
  for (long& x : a) x = va_arg(list, long);
  va_end(list);
  static long (*target)(long, long, long, long, long, long, long) = nullptr;
  return pass(target, "syscall", number, a[0], a[1], a[2], a[3], a[4], a[5]);
}

// ---- stdio: its own locks and writes do not use the names above
int printf(const char* format, ...) {
  check("printf");
  const Pause pause;
  va_list list;
  va_start(list, format);
  const int n = std::vfprintf(stdout, format, list);
  va_end(list);
  return n;
}
SINEW_TRAP(int, puts, (const char* s), s)
SINEW_TRAP(int, putc, (int c, FILE* f), c, f)  // compilers turn short writes of the others into these
SINEW_TRAP(int, fputc, (int c, FILE* f), c, f)
// The C library's header has an inline body for this name.
int trapped_putchar(int c) asm("putchar");
int trapped_putchar(int c) {
  check("putchar");
  static int (*target)(int) = nullptr;
  return pass(target, "putchar", c);
}
SINEW_TRAP(int, fputs, (const char* s, FILE* f), s, f)
SINEW_TRAP(size_t, fwrite, (const void* b, size_t s, size_t n, FILE* f), b, s, n, f)
SINEW_TRAP(size_t, fread, (void* b, size_t s, size_t n, FILE* f), b, s, n, f)
SINEW_TRAP(int, fflush, (FILE * f), f)
SINEW_TRAP(FILE*, fopen, (const char* p, const char* m), p, m)

}  // extern "C"
