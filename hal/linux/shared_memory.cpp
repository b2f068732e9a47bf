#include "hal/linux/shared_memory.hpp"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <climits>
#include <cstring>
#include <string>
#include <utility>

#include "hal/linux/futex.hpp"
#include "hal/platform.hpp"

#ifndef F_SEAL_FUTURE_WRITE
#define F_SEAL_FUTURE_WRITE 0x0010  // Linux 5.1; older C library headers do not name it
#endif

namespace sinew::hal {
namespace {

/// False: this kernel, or the headers that this was built with, has no such call.
bool futex_wait_any([[maybe_unused]] std::span<const SeenWord> words, [[maybe_unused]] Time deadline) noexcept {
#if defined(SYS_futex_waitv) && defined(FUTEX_WAITV_MAX)
  static_assert(kMostWords == FUTEX_WAITV_MAX);
  std::array<futex_waitv, kMostWords> waits;
  for (std::size_t i = 0; i < words.size(); ++i) {
    waits[i] = {};
    waits[i].val = words[i].seen, waits[i].uaddr = reinterpret_cast<std::uintptr_t>(words[i].word);
    waits[i].flags = FUTEX_32;
  }
  // The call knows the 64-bit time only.
  const struct { std::int64_t sec, nsec; } until{deadline.ns / 1'000'000'000, deadline.ns % 1'000'000'000};
  const long woken = ::syscall(SYS_futex_waitv, waits.data(), static_cast<unsigned>(words.size()), 0u,
                               deadline == kNever ? nullptr : &until, CLOCK_MONOTONIC);
  return woken >= 0 || errno != ENOSYS;
#else
  return false;
#endif
}

class MappedMemory final : public SharedMemory {
 public:
  MappedMemory(int fd, std::byte* data, std::size_t size) : fd_(fd), data_(data), size_(size) {}
  ~MappedMemory() override {
    ::munmap(data_, size_);
    ::close(fd_);
  }
  MappedMemory(const MappedMemory&) = delete;
  MappedMemory& operator=(const MappedMemory&) = delete;
  std::byte* data() override { return data_; }
  std::size_t size() const override { return size_; }
  std::intptr_t handle() const override { return fd_; }
  void wake_all(WakeWord& word) noexcept override { wake_shared(word); }
  bool copy(std::size_t offset, std::span<std::byte> into) const noexcept override {
    if (offset > size_ || into.size() > size_ - offset) return false;
    std::memcpy(into.data(), data_ + offset, into.size());
    return true;
  }

 private:
  int fd_;
  std::byte* data_;
  std::size_t size_;
};

class CopiedMemory final : public SharedMemory {
 public:
  CopiedMemory(int fd, std::size_t size) : fd_(fd), size_(size) {}
  ~CopiedMemory() override { ::close(fd_); }
  CopiedMemory(const CopiedMemory&) = delete;
  CopiedMemory& operator=(const CopiedMemory&) = delete;
  std::byte* data() override { return nullptr; }
  std::size_t size() const override { return size_; }
  std::intptr_t handle() const override { return fd_; }
  bool copy(std::size_t offset, std::span<std::byte> into) const noexcept override {
    while (!into.empty()) {
      const ssize_t n = ::pread(fd_, into.data(), into.size(), static_cast<off_t>(offset));
      if (n < 0 && errno == EINTR) continue;
      if (n <= 0) return false;
      offset += static_cast<std::size_t>(n);
      into = into.subspan(static_cast<std::size_t>(n));
    }
    return true;
  }

 private:
  int fd_;
  std::size_t size_;
};

Error shared_memory_error(int fd, const char* where) {
  const int why = errno;
  if (fd >= 0) ::close(fd);
  return Error{why == ENOMEM ? Errc::out_of_memory : Errc::io, where, why};
}

Result<std::unique_ptr<SharedMemory>> map(int fd, std::size_t bytes, int protection) {
  void* at = ::mmap(nullptr, bytes, protection, MAP_SHARED | MAP_POPULATE, fd, 0);
  if (at == MAP_FAILED) return shared_memory_error(fd, "shared memory: mmap");
  // Without the privilege the pages are merely not pinned; callers that need that guarantee call Os::lock_memory().
  static_cast<void>(::mlock(at, bytes));
  return std::unique_ptr<SharedMemory>(new MappedMemory(fd, static_cast<std::byte*>(at), bytes));
}

}  // namespace

Result<std::unique_ptr<SharedMemory>> create_shared_memory(std::string_view name, std::size_t bytes) {
  if (bytes == 0) return Error{Errc::bad_argument, "shared memory of no bytes"};
  if (bytes > std::size_t{PTRDIFF_MAX} / 2) return Error{Errc::out_of_memory, "shared memory: too large", EFBIG};
  const int fd = ::memfd_create(std::string(name).c_str(), MFD_CLOEXEC | MFD_ALLOW_SEALING);
  if (fd < 0) return shared_memory_error(fd, "shared memory: memfd_create");
  const auto page = static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
  const std::size_t rounded = (bytes + page - 1) / page * page;
  if (::ftruncate(fd, static_cast<off_t>(rounded)) != 0) return shared_memory_error(fd, "shared memory: ftruncate");
  if (::fcntl(fd, F_ADD_SEALS, F_SEAL_SHRINK | F_SEAL_GROW) != 0) return shared_memory_error(fd, "shared memory: seal");
  auto memory = map(fd, rounded, PROT_READ | PROT_WRITE);
  // Our mapping exists by now; later mappings may only read. Kernels before 5.1 refuse, and then peers are trusted.
  if (memory) static_cast<void>(::fcntl(fd, F_ADD_SEALS, F_SEAL_FUTURE_WRITE | F_SEAL_SEAL));
  return memory;
}

Result<std::unique_ptr<SharedMemory>> open_shared_memory(int fd, Stream::MemoryAccess access) {
  const int seals = ::fcntl(fd, F_GET_SEALS);
  struct stat info {};
  if (seals < 0 || (seals & F_SEAL_SHRINK) == 0 || ::fstat(fd, &info) != 0 || info.st_size <= 0) {
    ::close(fd);
    return Error{Errc::bad_data, "shared memory from the peer is not sealed against shrinking", seals};
  }
  if (!std::in_range<std::ptrdiff_t>(info.st_size)) {
    ::close(fd);
    return Error{Errc::out_of_memory, "shared memory from the peer is more than this machine can address", EFBIG};
  }
  const auto bytes = static_cast<std::size_t>(info.st_size);
  if (access == Stream::MemoryAccess::copied) return std::unique_ptr<SharedMemory>(new CopiedMemory(fd, bytes));
  return map(fd, bytes, PROT_READ);
}

void wait_shared(const WakeWord& word, std::uint32_t expected, Time deadline) noexcept {
  futex_wait(word, expected, deadline, FutexScope::machine);
}

void wait_any_shared(std::span<const SeenWord> words, Time deadline) noexcept {
  if (words.empty()) return;
  const std::size_t count = std::min(words.size(), kMostWords);
  if (count == words.size() && futex_wait_any(words, deadline)) return;
  const Time soon = system_os().now() + std::chrono::milliseconds(5);
  for (const SeenWord& w : words)
    if (w.word->load(std::memory_order_relaxed) != w.seen) return;
  wait_shared(*words.front().word, words.front().seen, std::min(deadline, soon));
}

void wake_shared(const WakeWord& word) noexcept { futex_wake(word, INT_MAX, FutexScope::machine); }

}  // namespace sinew::hal
