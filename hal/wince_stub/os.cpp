#include <algorithm>
#include <array>
#include <cstring>

#include "hal/platform.hpp"
#include "hal/wince_stub/coredll.hpp"

namespace sinew::hal {
namespace {

using namespace ce;

constexpr std::int64_t kNsPerSecond = 1'000'000'000, kNsPerMs = 1'000'000;

/// The longest wait of one call; the caller looks at the clock again.
constexpr std::int64_t kLongestMs = 3'600'000;

class Lock {
 public:
  explicit Lock(CriticalSection& section) : section_(section) { EnterCriticalSection(&section_); }
  ~Lock() { LeaveCriticalSection(&section_); }
  Lock(const Lock&) = delete;
  Lock& operator=(const Lock&) = delete;

 private:
  CriticalSection& section_;
};

/// The event that a thread sleeps on: one per thread, made when it first sleeps and given back when it ends. Threads
/// that this room did not start keep theirs until the process ends.
class OwnEvent {
 public:
  OwnEvent() : index_(TlsAlloc()) {}
  /// Null: the system has no event left.
  Handle get() noexcept {
    if (index_ == kTlsOutOfIndexes) return nullptr;
    Handle event = TlsGetValue(index_);
    if (event == nullptr) {
      event = CreateEventW(nullptr, 0, 0, nullptr);
      TlsSetValue(index_, event);
    }
    return event;
  }
  void give_back() noexcept {
    Handle event = index_ == kTlsOutOfIndexes ? nullptr : TlsGetValue(index_);
    if (event == nullptr) return;
    TlsSetValue(index_, nullptr);
    CloseHandle(event);
  }

 private:
  Dword index_;
};

OwnEvent& own_event() {
  static OwnEvent event;
  return event;
}

/// Sleeping on words: Windows CE has no futex. Each word belongs to one of a few lists; a waker takes one sleeper out
/// of the list under its lock, so none is woken twice and none is missed.
class ParkingLot {
 public:
  ParkingLot() {
    for (Bucket& b : buckets_) InitializeCriticalSection(&b.section);
  }

  /// At most `ms`.
  void wait(const WakeWord& word, std::uint32_t expected, Dword ms) noexcept {
    Sleeper self{&word, own_event().get(), nullptr, false};
    if (self.event == nullptr) return Sleep(ms > 0 ? 1 : 0);  // may return early: callers look again
    Bucket& bucket = bucket_of(word);
    {
      const Lock lock(bucket.section);
      if (word.load(std::memory_order_acquire) != expected) return;
      self.next = bucket.first;
      bucket.first = &self;
    }
    WaitForSingleObject(self.event, ms);
    const Lock lock(bucket.section);
    if (self.woken) {
      ResetEvent(self.event);  // an event set between the time-out and the lock is not for the next sleep
      return;
    }
    for (Sleeper** at = &bucket.first; *at != nullptr; at = &(*at)->next)
      if (*at == &self) {
        *at = self.next;
        return;
      }
  }

  void wake(const WakeWord& word) noexcept {
    Bucket& bucket = bucket_of(word);
    const Lock lock(bucket.section);
    Sleeper** last = nullptr;  // the list is in order of arrival, the newest first: the oldest is woken
    for (Sleeper** at = &bucket.first; *at != nullptr; at = &(*at)->next)
      if ((*at)->word == &word) last = at;
    if (last == nullptr) return;
    Sleeper& sleeper = **last;
    *last = sleeper.next;
    sleeper.woken = true;
    SetEvent(sleeper.event);  // under the lock: the sleeper owns the event, and needs the lock to leave
  }

 private:
  struct Sleeper {
    const WakeWord* word;
    Handle event;
    Sleeper* next;
    bool woken;
  };
  struct Bucket {
    CriticalSection section;
    Sleeper* first = nullptr;
  };

  Bucket& bucket_of(const WakeWord& word) {
    return buckets_[reinterpret_cast<std::uintptr_t>(&word) / sizeof(WakeWord) / 4 % buckets_.size()];
  }

  std::array<Bucket, 32> buckets_;
};

std::int64_t ticks_per_second() {
  std::int64_t per_second = 0;
  QueryPerformanceFrequency(&per_second);
  return per_second > 0 ? per_second : 1000;
}

/// 99 priorities on three levels, since both systems have seven, of which three are below an ordinary thread. CE's own
/// 256 (CeSetThreadPriority) are not on desktop Windows.
int level_of(const ThreadOptions& options) {
  const int p = options.fifo_priority;
  if (p >= 70) return time_critical;
  if (p >= 40) return highest;
  if (p > 0) return above_normal;
  return options.nice < 0 ? above_normal : options.nice == 0 ? normal : options.nice < 10 ? below_normal : lowest;
}

class CeThread final : public Thread {
 public:
  CeThread(const ThreadOptions& options, std::function<void()> body) : options_(options), body_(std::move(body)) {}
  ~CeThread() override { CeThread::join(); }
  CeThread(const CeThread&) = delete;
  CeThread& operator=(const CeThread&) = delete;

  Status start() {
    constexpr std::size_t kOwnStackUse = 64 * 1024;  // the C library's and the system's
    const Dword flags = kCreateSuspended | kStackSizeParamIsAReservation;
    thread_ = CreateThread(nullptr, options_.stack_bytes + kOwnStackUse, &CeThread::entry, this, flags, nullptr);
    if (thread_ == nullptr) return Error{Errc::io, "CreateThread", GetLastError()};
    if (!SetThreadPriority(thread_, level_of(options_))) fall_short("priority refused");
    if (options_.fifo_priority > 0)
      fall_short("SCHED_FIFO: one of Windows' levels instead, which many priorities share");
    if (!options_.cpus.empty()) fall_short("CPU set: the system has none");
    if (ResumeThread(thread_) != static_cast<Dword>(-1)) return {};
    const Dword why = GetLastError();
    CloseHandle(thread_);  // it never runs, and no one may wait for it
    thread_ = nullptr;
    return Error{Errc::io, "ResumeThread", why};
  }

  void join() override {
    if (thread_ == nullptr) return;
    WaitForSingleObject(thread_, kInfinite);
    CloseHandle(thread_);
    thread_ = nullptr;
  }
  const std::string& shortfall() const override { return shortfall_; }

 private:
  static Dword __stdcall entry(void* self) {
    static_cast<CeThread*>(self)->body_();
    own_event().give_back();
    return 0;
  }
  void fall_short(const char* what) {
    if (!shortfall_.empty()) shortfall_ += "; ";
    shortfall_ += what;
  }

  ThreadOptions options_;
  std::function<void()> body_;
  std::string shortfall_;
  Handle thread_ = nullptr;
};

/// Pages without a file. Other processes cannot be given them: CE maps by name only, and any process can use a name.
class CeMemory final : public SharedMemory {
 public:
  CeMemory(Handle mapping, std::byte* at, std::size_t bytes) : mapping_(mapping), at_(at), bytes_(bytes) {}
  ~CeMemory() override {
    UnmapViewOfFile(at_);
    CloseHandle(mapping_);
  }
  CeMemory(const CeMemory&) = delete;
  CeMemory& operator=(const CeMemory&) = delete;
  std::byte* data() override { return at_; }
  std::size_t size() const override { return bytes_; }
  bool copy(std::size_t offset, std::span<std::byte> into) const noexcept override {
    if (offset > bytes_ || into.size() > bytes_ - offset) return false;
    std::memcpy(into.data(), at_ + offset, into.size());
    return true;
  }

 private:
  Handle mapping_;
  std::byte* at_;
  std::size_t bytes_;
};

class CeOs final : public Os {
 public:
  CeOs() : per_second_(ticks_per_second()) {}

  Time now() const noexcept override {
    std::int64_t ticks = 0;
    QueryPerformanceCounter(&ticks);
    return {ticks / per_second_ * kNsPerSecond + ticks % per_second_ * kNsPerSecond / per_second_};
  }

  // Never early, and late by up to a tick of the system (1 ms on CE, 1 to 16 ms on a desktop): both have no finer
  // timer, and busy waiting would keep lower priorities from the processor.
  void sleep_until(Time t) noexcept override {
    for (Time here = now(); here < t; here = now()) Sleep(ms_until(t, here));
  }

  void wait(WakeWord& word, std::uint32_t expected, Time deadline) noexcept override {
    if (deadline == kNever) return lot_.wait(word, expected, kInfinite);
    const Time here = now();
    if (here < deadline) lot_.wait(word, expected, ms_until(deadline, here));
  }

  void wake(WakeWord& word) noexcept override { lot_.wake(word); }

  Duration thread_cpu_time() noexcept override {
    FileTime created{}, ended{}, kernel{}, user{};
    if (!GetThreadTimes(GetCurrentThread(), &created, &ended, &kernel, &user)) return Duration{0};
    const auto ns = [](const FileTime& t) { return ((std::int64_t{t.high} << 32) + t.low) * 100; };
    return Duration{ns(kernel) + ns(user)};
  }

  Result<std::unique_ptr<Thread>> start_thread(const ThreadOptions& options, std::function<void()> body) override {
    auto thread = std::make_unique<CeThread>(options, std::move(body));
    if (auto status = thread->start(); !status) return status.error();
    return std::unique_ptr<Thread>(std::move(thread));
  }

  Result<std::unique_ptr<SharedMemory>> shared_memory(std::string_view, std::size_t bytes) override {
    if (bytes == 0) return Error{Errc::bad_argument, "shared memory of 0 bytes"};
    // More than the address space is not even asked for: Wine's 32-bit half refuses it and then hangs, with a lock
    // held.
    if (bytes > std::size_t{PTRDIFF_MAX} / 2) return Error{Errc::out_of_memory, "shared memory: too large"};
    const Handle mapping = CreateFileMappingW(kInvalidHandle, nullptr, kPageReadWrite,
                                              static_cast<Dword>(static_cast<std::uint64_t>(bytes) >> 32),
                                              static_cast<Dword>(bytes), nullptr);
    if (mapping == nullptr) return Error{Errc::out_of_memory, "CreateFileMapping", GetLastError()};
    void* at = MapViewOfFile(mapping, kFileMapRead | kFileMapWrite, 0, 0, bytes);
    if (at == nullptr) {
      const Dword why = GetLastError();
      CloseHandle(mapping);
      return Error{Errc::out_of_memory, "MapViewOfFile", why};
    }
    return std::unique_ptr<SharedMemory>(new CeMemory(mapping, static_cast<std::byte*>(at), bytes));
  }

  // CE swaps no memory to disk; LockPages, which keeps programs' own pages in, is not on desktop Windows.
  Status lock_memory() override { return Error{Errc::not_supported, "locking memory"}; }

 private:
  static Dword ms_until(Time t, Time here) {
    return static_cast<Dword>(std::min((t.ns - here.ns + kNsPerMs - 1) / kNsPerMs, kLongestMs));
  }

  std::int64_t per_second_;
  ParkingLot lot_;
};

}  // namespace

Os& system_os() {
  static CeOs os;
  return os;
}

}  // namespace sinew::hal
