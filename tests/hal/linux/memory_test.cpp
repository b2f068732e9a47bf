#include "hal/linux/memory.hpp"

#include <gtest/gtest.h>
#include <link.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <cstring>
#include <memory>

#include "hal/linux/system_files.hpp"
#include "hal/platform.hpp"
#include "qemu_user.hpp"

namespace sinew::hal::memory_test {
namespace {

constexpr std::uint64_t kMiB = 1 << 20;

// Locking stays for the life of a process, so each case has its own process. Exit codes:
constexpr int kGood = 0, kNotPermitted = 100;

/// False also where a sanitizer makes locking do nothing.
bool lock() {
  if (!lock_process_memory()) return false;
  return SystemFiles("/").field("proc/self/status", "VmLck:").value_or("0 kB") != "0 kB";
}

/// A block of 16 MiB that the compiler cannot leave out.
std::unique_ptr<char[]> untouched() {
  auto block = std::make_unique_for_overwrite<char[]>(16 * kMiB);
  asm volatile("" : : "r"(block.get()) : "memory");
  return block;
}

template <class Case>
int in_a_child(Case&& run) {
  const pid_t child = ::fork();
  if (child == 0) ::_exit(run());
  int status = 0;
  ::waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

TEST(MemoryUse, PartsAreTheWhole) {
  const MemoryUse use = memory_use();
  EXPECT_GT(use.program, 0u);
  EXPECT_GT(use.libraries, 0u);
  EXPECT_GT(use.heap, 0u);
  EXPECT_GT(use.stacks, 0u);
  EXPECT_EQ(use.total, use.slots + use.peers + use.program + use.libraries + use.heap + use.stacks + use.other);
}

TEST(MemoryUse, SlotsAreTheSharedMemoryThatWeMade) {
  const std::uint64_t before = memory_use().slots;
  auto memory = system_os().shared_memory("sinew-test", 3 * kMiB);
  ASSERT_TRUE(memory);
  EXPECT_EQ(memory_use().slots - before, 3 * kMiB);
  EXPECT_EQ(memory_use().peers, 0u);
}

TEST(MemoryUse, AllocatedBlocksAreHeapOnceTheyAreTouched) {
  SINEW_SKIP_UNDER_QEMU_USER("/proc/self/smaps is not of the program alone");
  const std::uint64_t before = memory_use().heap;
  const auto block = std::make_unique<char[]>(16 * kMiB);
  std::memset(block.get(), 1, 16 * kMiB);          // zeroes alone may come from pages that nobody has touched
  asm volatile("" ::"r"(block.get()) : "memory");  // and bytes that nobody reads need not be written
  EXPECT_GE(memory_use().heap - before, 15 * kMiB);
}

TEST(LockMemory, WhatWasAllocatedIsInMemoryBeforeAnybodyTouchesIt) {
  const int code = in_a_child([] {
    const auto block = untouched();
    const std::uint64_t before = memory_use().heap;
    if (!lock()) return kNotPermitted;
    return memory_use().heap - before >= 15 * kMiB ? kGood : 1;
  });
  if (code == kNotPermitted) GTEST_SKIP() << "memory may not be locked here";
  EXPECT_EQ(code, kGood);
}

TEST(LockMemory, AlsoWhatStandsBesideAStack) {
  const int code = in_a_child([] {
    const auto block = untouched();
    std::atomic<bool> end{false};
    auto idle =
        system_os().start_thread({.name = "idle", .fifo_priority = 1, .cpus = {}, .stack_bytes = 64 * 1024}, [&] {
          while (!end) ::usleep(1000);
        });
    const std::uint64_t before = memory_use().heap;
    const bool locked = lock();
    const MemoryUse use = memory_use();
    end = true;
    if (idle) (*idle)->join();
    return !locked ? kNotPermitted : use.heap - before >= 15 * kMiB && use.stacks >= 64 * 1024 ? kGood : 1;
  });
  if (code == kNotPermitted) GTEST_SKIP() << "memory may not be locked here";
  EXPECT_EQ(code, kGood);
}

TEST(LockMemory, AThreadsStackIsFilledAsFarAsItAskedFor) {
  SINEW_SKIP_UNDER_QEMU_USER("/proc/self/smaps of the program: it shows its own");
  const int code = in_a_child([] {
    const std::uint64_t before = memory_use().stacks;
    std::atomic<bool> end{false};
    auto idle =
        system_os().start_thread({.name = "idle", .fifo_priority = 1, .cpus = {}, .stack_bytes = 512 * 1024}, [&] {
          while (!end) ::usleep(1000);
        });
    const bool locked = lock();
    const std::uint64_t stack = memory_use().stacks - before;
    end = true;
    if (idle) (*idle)->join();
    return !locked ? kNotPermitted : stack >= 512 * 1024 && stack < 560 * 1024 ? kGood : 1;
  });
  if (code == kNotPermitted) GTEST_SKIP() << "memory may not be locked here";
  EXPECT_EQ(code, kGood);
}

/// Bytes of the program file's own segments.
std::uint64_t program_size() {
  std::uint64_t size = 0;
  ::dl_iterate_phdr(
      [](dl_phdr_info* program, std::size_t, void* to) {
        for (int i = 0; i < program->dlpi_phnum; ++i)
          if (program->dlpi_phdr[i].p_type == PT_LOAD)
            *static_cast<std::uint64_t*>(to) += program->dlpi_phdr[i].p_filesz;
        return 1;  // the first is the program
      },
      &size);
  return size;
}

TEST(LockMemory, TablesOfSymbolsAndExceptionsAreLeftOutAndComeBackWhenTheyAreUsed) {
  SINEW_SKIP_UNDER_QEMU_USER("/proc/self/smaps is not of the program alone");
  const int code = in_a_child([] {
    if (!lock()) return kNotPermitted;
    if (memory_use().program >= program_size() * 9 / 10) return 1;
    const std::uint64_t before = memory_use().program;
    try {
      throw std::uint64_t{7};
    } catch (std::uint64_t n) {
      if (n != 7) return 2;
    }
    return memory_use().program > before ? kGood : 3;
  });
  if (code == kNotPermitted) GTEST_SKIP() << "memory may not be locked here";
  EXPECT_EQ(code, kGood);
}

TEST(LockMemory, WhatIsTouchedLaterStays) {
  const int code = in_a_child([] {
    if (!lock()) return kNotPermitted;
    auto* page =
        static_cast<char*>(::mmap(nullptr, 64 * 4096, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0));
    page[0] = 1;
    // Only unlocked pages may be thrown away.
    return ::madvise(page, 4096, MADV_DONTNEED) != 0 ? kGood : 1;
  });
  if (code == kNotPermitted) GTEST_SKIP() << "memory may not be locked here";
  EXPECT_EQ(code, kGood);
}

}  // namespace
}  // namespace sinew::hal::memory_test
