// Every call that the trap knows has a step here that makes it, and must be seen to fail.
#include "trap.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <malloc.h>
#include <poll.h>
#include <pthread.h>
#include <sched.h>
#include <semaphore.h>
#include <sys/epoll.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <sys/select.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <functional>
#include <map>
#include <string>

#include "rt/trap.hpp"

namespace sinew::trap_test {
namespace {

void* volatile g_keep = nullptr;  // so that the compiler cannot drop an allocation
volatile long g_result = 0;
pthread_mutex_t g_mutex = PTHREAD_MUTEX_INITIALIZER;
pthread_rwlock_t g_rwlock = PTHREAD_RWLOCK_INITIALIZER;
pthread_cond_t g_cond = PTHREAD_COND_INITIALIZER;
pthread_spinlock_t g_spin;
sem_t g_sem;
const timespec g_zero{};

template <class F>
F* through(F* function) {
  F* volatile pointer = function;
  return pointer;
}

const std::map<std::string_view, std::function<void()>>& culprits() {
  static char buffer[16];
  static iovec vec{buffer, 0};
  static msghdr message{};
  static const std::map<std::string_view, std::function<void()>> all{
      {"malloc", [] { g_keep = std::malloc(8); }},
      {"calloc", [] { g_keep = std::calloc(1, 8); }},
      {"realloc", [] { g_keep = std::realloc(g_keep, 16); }},
      {"free", [] { std::free(g_keep); }},
      {"posix_memalign",
       [] {
         void* p = nullptr;
         g_result = posix_memalign(&p, 64, 64);
         g_keep = p;
       }},
      {"aligned_alloc", [] { g_keep = std::aligned_alloc(64, 64); }},
      {"memalign", [] { g_keep = memalign(64, 64); }},
      {"mmap", [] { g_keep = mmap(nullptr, 4096, PROT_READ, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0); }},
      {"munmap", [] { g_result = munmap(nullptr, 0); }},
      {"mprotect", [] { g_result = mprotect(nullptr, 0, PROT_READ); }},
      {"pthread_mutex_lock", [] { pthread_mutex_lock(&g_mutex); }},
      {"pthread_mutex_trylock", [] { g_result = pthread_mutex_trylock(&g_mutex); }},
      {"pthread_mutex_timedlock", [] { g_result = pthread_mutex_timedlock(&g_mutex, &g_zero); }},
      {"pthread_mutex_unlock", [] { pthread_mutex_unlock(&g_mutex); }},
      {"pthread_rwlock_rdlock", [] { pthread_rwlock_rdlock(&g_rwlock); }},
      {"pthread_rwlock_wrlock", [] { pthread_rwlock_wrlock(&g_rwlock); }},
      {"pthread_spin_lock", [] { pthread_spin_lock(&g_spin); }},
      {"pthread_cond_wait", [] { pthread_cond_wait(&g_cond, &g_mutex); }},
      {"pthread_cond_timedwait", [] { pthread_cond_timedwait(&g_cond, &g_mutex, &g_zero); }},
      {"pthread_cond_clockwait", [] { pthread_cond_clockwait(&g_cond, &g_mutex, CLOCK_MONOTONIC, &g_zero); }},
      {"pthread_cond_signal", [] { pthread_cond_signal(&g_cond); }},
      {"pthread_cond_broadcast", [] { pthread_cond_broadcast(&g_cond); }},
      {"pthread_create",
       [] {
         pthread_t t;
         pthread_create(
             &t, nullptr, [](void*) -> void* { return nullptr; }, nullptr);
       }},
      {"pthread_join", [] { pthread_join(pthread_self(), nullptr); }},
      {"sem_wait", [] { sem_wait(&g_sem); }},
      {"sem_timedwait", [] { sem_timedwait(&g_sem, &g_zero); }},
      {"sem_post", [] { sem_post(&g_sem); }},
      {"open", [] { g_result = open("/dev/null", O_RDONLY); }},
      {"openat", [] { g_result = openat(AT_FDCWD, "/dev/null", O_RDONLY); }},
      {"close", [] { g_result = close(-1); }},
      {"read", [] { g_result = read(-1, buffer, 1); }},
      {"write", [] { g_result = write(-1, buffer, 1); }},
      {"readv", [] { g_result = readv(-1, &vec, 1); }},
      {"writev", [] { g_result = writev(-1, &vec, 1); }},
      {"pread", [] { g_result = pread(-1, buffer, 1, 0); }},
      {"pwrite", [] { g_result = pwrite(-1, buffer, 1, 0); }},
      {"ioctl", [] { g_result = ioctl(-1, FIONREAD, buffer); }},
      {"poll", [] { g_result = poll(nullptr, 0, 0); }},
      {"ppoll", [] { g_result = ppoll(nullptr, 0, &g_zero, nullptr); }},
      {"select",
       [] {
         timeval t{};
         g_result = select(0, nullptr, nullptr, nullptr, &t);
       }},
      {"epoll_wait",
       [] {
         epoll_event e{};
         g_result = epoll_wait(-1, &e, 1, 0);
       }},
      {"send", [] { g_result = send(-1, buffer, 1, 0); }},
      {"recv", [] { g_result = recv(-1, buffer, 1, 0); }},
      {"sendto", [] { g_result = sendto(-1, buffer, 1, 0, nullptr, 0); }},
      {"recvfrom", [] { g_result = recvfrom(-1, buffer, 1, 0, nullptr, nullptr); }},
      {"sendmsg", [] { g_result = sendmsg(-1, &message, 0); }},
      {"recvmsg", [] { g_result = recvmsg(-1, &message, 0); }},
      {"accept", [] { g_result = accept(-1, nullptr, nullptr); }},
      {"connect", [] { g_result = connect(-1, nullptr, 0); }},
      {"nanosleep", [] { nanosleep(&g_zero, nullptr); }},
      {"clock_nanosleep", [] { clock_nanosleep(CLOCK_MONOTONIC, 0, &g_zero, nullptr); }},
      {"usleep", [] { usleep(0); }},
      {"sleep", [] { sleep(0); }},
      {"sched_yield", [] { sched_yield(); }},
      {"syscall", [] { g_result = syscall(SYS_getpid); }},
      {"clock_gettime",
       [] {
         timespec t;
         clock_gettime(CLOCK_MONOTONIC, &t);
       }},
      {"printf", [] { printf("%s %d\n", "x", 1); }},
      {"puts", [] { puts("x"); }},
      // Through pointers: compilers know these functions and would call one of the others.
      {"putc", [] { through<int(int, FILE*)>(putc)('x', stdout); }},
      {"fputc", [] { through<int(int, FILE*)>(fputc)('x', stdout); }},
      {"putchar", [] { through<int(int)>(putchar)('x'); }},
      {"fputs", [] { through<int(const char*, FILE*)>(fputs)("x", stdout); }},
      {"fwrite", [] { through<size_t(const void*, size_t, size_t, FILE*)>(fwrite)(buffer, 1, 1, stdout); }},
      {"fflush", [] { fflush(stdout); }},
      {"fopen", [] { g_keep = fopen("/dev/null", "r"); }},
      {"fread", [] { g_result = static_cast<long>(fread(buffer, 1, 1, stdin)); }},
  };
  return all;
}

class Trap : public testing::TestWithParam<std::string_view> {
 protected:
  void SetUp() override {
    if (!trap::is_set()) GTEST_SKIP() << "the trap is off in sanitizer builds, which replace the same calls";
  }
};

TEST_P(Trap, CallInsideAStepEndsTheProgramWithItsNameAndTheModule) {
  const auto culprit = culprits().find(GetParam());
  ASSERT_NE(culprit, culprits().end()) << "no step here makes this call";
  const std::function<void()> call = culprit->second;
  EXPECT_DEATH(
      {
        const rt::trap::Scope scope("doomed");
        call();
      },
      "trap: " + std::string(GetParam()) + " called inside a step of module 'doomed'");
}

INSTANTIATE_TEST_SUITE_P(EveryCall, Trap, testing::ValuesIn(trap::kCalls),
                         [](const auto& call) { return std::string(call.param); });

TEST(TrapScope, CallOfABestEffortModuleIsCounted) {
  if (!trap::is_set()) GTEST_SKIP() << "the trap is off in sanitizer builds, which replace the same calls";
  std::uint32_t count = 0;
  {
    const rt::trap::Scope scope("slow", &count);
    g_keep = std::malloc(8);
    std::free(g_keep);
  }
  EXPECT_EQ(count, 2u);
}

TEST(TrapScope, CallOutsideAStepPasses) {
  { const rt::trap::Scope scope("quick"); }
  g_keep = std::malloc(8);
  ASSERT_NE(g_keep, nullptr);
  std::free(g_keep);
}

}  // namespace
}  // namespace sinew::trap_test
