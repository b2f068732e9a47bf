#include "grab/preload/program_side.hpp"

#include <fcntl.h>
#include <linux/futex.h>
#include <pthread.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>
#include <climits>
#include <cstdlib>
#include <cstring>
#include <ctime>

#ifndef F_GET_SEALS
#define F_GET_SEALS 1034
#define F_SEAL_SHRINK 0x0002
#endif

namespace sinew::grab {
namespace {

constexpr std::size_t kMapUnit = 65536;   // a multiple of every kernel's pages
constexpr std::uint32_t kAliveMs = 1000;  // a window that showed nothing for so long is left for another
constexpr std::uint32_t kMostShown = kMaxWindows;

enum class Connection : int { none, off, on };

struct Mapping {
  std::uint8_t* at;
  std::size_t bytes;
};

// The whole state of this process. Everything but `connection` is under `mutex`, or belongs to the claimer of a view.
pthread_mutex_t mutex = PTHREAD_MUTEX_INITIALIZER;
std::atomic<Connection> connection{Connection::none};
Head* head_ = nullptr;
int memory_fd = -1, socket_fd = -1;
std::atomic<std::uint32_t> me{0};
bool buffered = false;
Shown windows[kMostShown];
Mapping slots[kMaxViews][kSlots];

/// What a drawable or surface is drawn into, where that is not the drawable itself.
struct Behind {
  Api api;
  const void* display;
  std::uint64_t key;
  std::uint32_t x11;
};
Behind behind[2 * kMaxWindows];

struct Locked {
  Locked() noexcept { pthread_mutex_lock(&mutex); }
  ~Locked() { pthread_mutex_unlock(&mutex); }
  Locked(const Locked&) = delete;
  Locked& operator=(const Locked&) = delete;
};

/// A hook leaves errno as the program had it.
struct ErrnoKept {
  int kept = errno;
  ErrnoKept() noexcept = default;
  ~ErrnoKept() { errno = kept; }
  ErrnoKept(const ErrnoKept&) = delete;
  ErrnoKept& operator=(const ErrnoKept&) = delete;
};

void program_name(char (&name)[kNameBytes]) noexcept {
  std::memset(name, 0, sizeof name);
  const int fd = ::open("/proc/self/comm", O_RDONLY | O_CLOEXEC);
  if (fd < 0) return;
  const ssize_t n = ::read(fd, name, sizeof name - 1);
  ::close(fd);
  for (ssize_t i = 0; i < n; ++i)
    if (name[i] == '\n') name[i] = 0;
}

/// The descriptor that came with a message; -1: none.
int descriptor_of(msghdr& message) noexcept {
  for (cmsghdr* c = CMSG_FIRSTHDR(&message); c != nullptr; c = CMSG_NXTHDR(&message, c)) {
    if (c->cmsg_level != SOL_SOCKET || c->cmsg_type != SCM_RIGHTS) continue;
    int fd = -1;
    std::memcpy(&fd, CMSG_DATA(c), sizeof fd);
    return fd;
  }
  return -1;
}

int connected_socket(const char* path) noexcept {
  sockaddr_un to{};
  to.sun_family = AF_UNIX;
  if (std::strlen(path) >= sizeof to.sun_path) return -1;
  std::strcpy(to.sun_path, path);
  const int fd = ::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0);
  if (fd < 0) return -1;
  const timeval patience{1, 0};
  if (::setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience) == 0 &&
      ::setsockopt(fd, SOL_SOCKET, SO_SNDTIMEO, &patience, sizeof patience) == 0 &&
      ::connect(fd, reinterpret_cast<const sockaddr*>(&to), sizeof to) == 0)
    return fd;
  ::close(fd);
  return -1;
}

/// Says who we are; the memory's descriptor and our number. -1: we are not welcome.
int introduce(int socket, std::uint32_t& number) noexcept {
  Hello hello{
      kMagic, kVersion, static_cast<std::uint32_t>(Hello::Role::program), static_cast<std::uint32_t>(getpid()), {}};
  program_name(hello.program);
  if (::send(socket, &hello, sizeof hello, MSG_NOSIGNAL) != static_cast<ssize_t>(sizeof hello)) return -1;
  Welcome welcome{};
  iovec part{&welcome, sizeof welcome};
  alignas(cmsghdr) char control[CMSG_SPACE(sizeof(int))] = {};
  msghdr message{};
  message.msg_iov = &part, message.msg_iovlen = 1;
  message.msg_control = control, message.msg_controllen = sizeof control;
  ssize_t n;
  do {
    n = ::recvmsg(socket, &message, MSG_CMSG_CLOEXEC);
  } while (n < 0 && errno == EINTR);
  if (n < 0) return -1;
  const int fd = descriptor_of(message);
  const bool good = n == static_cast<ssize_t>(sizeof welcome) && welcome.magic == kMagic &&
                    welcome.version == kVersion && welcome.number != 0;
  if (good) {
    number = welcome.number;
    return fd;
  }
  if (fd >= 0) ::close(fd);
  return -1;
}

/// Maps the head. Null: this is not the memory that it should be, or its owner could shrink it (a bus error for us).
Head* mapped_head(int fd) noexcept {
  struct stat info {};
  const int seals = ::fcntl(fd, F_GET_SEALS);
  if (seals < 0 || (seals & F_SEAL_SHRINK) == 0 || ::fstat(fd, &info) != 0 ||
      static_cast<std::uint64_t>(info.st_size) < kMemoryBytes)
    return nullptr;
  void* at = ::mmap(nullptr, kPicturesAt, PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
  if (at == MAP_FAILED) return nullptr;
  auto* head = static_cast<Head*>(at);
  if (head->magic == kMagic && head->version == kVersion) return head;
  ::munmap(at, kPicturesAt);
  return nullptr;
}

/// Needs the lock.
void connect_now() noexcept {
  const char* path = ::getenv(kSocketVariable);
  if (path == nullptr || *path == 0) return;
  const int socket = connected_socket(path);
  if (socket < 0) return;
  std::uint32_t number = 0;
  const int fd = introduce(socket, number);
  Head* head = fd >= 0 ? mapped_head(fd) : nullptr;
  if (head == nullptr) {
    if (fd >= 0) ::close(fd);
    ::close(socket);
    return;
  }
  const char* how = ::getenv(kReadVariable);
  buffered = how != nullptr && std::strcmp(how, "buffered") == 0;
  for (Shown& shown : windows) shown = Shown{};
  head_ = head, memory_fd = fd, socket_fd = socket;
  me.store(number, std::memory_order_relaxed);
}

/// `sinew grab` ended, or took this process for dead since the program closed our socket: no more pictures. Mappings
/// stay, since another thread may be writing there.
void leave() noexcept { connection.store(Connection::off, std::memory_order_release); }

std::uint32_t milliseconds(std::int64_t ns) noexcept {
  return static_cast<std::uint32_t>(static_cast<std::uint64_t>(ns) / 1000000u);
}

/// X11's numbers have 29 bits; a window of Wayland is a pointer instead.
std::uint32_t x11_number(std::uint64_t window) noexcept {
  constexpr std::uint64_t kMost = 0x1FFFFFFF;
  return window <= kMost ? static_cast<std::uint32_t>(window) : 0;
}

/// Needs the lock.
std::uint32_t x11_behind(Api api, const void* display, std::uint64_t key) noexcept {
  for (const Behind& b : behind)
    if (b.api == api && b.key == key && b.display == display) return b.x11;
  return api == Api::glx ? x11_number(key) : 0;
}

/// Needs the lock: takes a free window of the memory.
std::uint32_t take_window(Head& head, Api api, const void* display, std::uint64_t key) noexcept {
  const std::uint32_t number = me.load(std::memory_order_relaxed);
  for (std::uint32_t i = 0; i < kMaxWindows; ++i) {
    Window& w = head.window[i];
    std::uint32_t nobody = 0;
    if (!w.process.compare_exchange_strong(nobody, number, std::memory_order_acquire)) continue;
    w.ready.store(0, std::memory_order_relaxed);
    w.width.store(0, std::memory_order_relaxed), w.height.store(0, std::memory_order_relaxed);
    w.swaps.store(0, std::memory_order_relaxed);
    w.alive_ms.store(milliseconds(now_ns()), std::memory_order_relaxed);
    w.api = static_cast<std::uint32_t>(api), w.pid = static_cast<std::uint32_t>(getpid());
    w.id[0] = static_cast<std::uint32_t>(key), w.id[1] = static_cast<std::uint32_t>(key >> 32);
    w.x11 = x11_behind(api, display, key);
    head.title[i].process.store(0, std::memory_order_relaxed);  // the title of the window that had this number
    program_name(w.program);
    return i;
  }
  return kNoNumber;
}

void wake_all(Word& word) noexcept {
  ::syscall(SYS_futex, reinterpret_cast<std::uint32_t*>(&word), FUTEX_WAKE, INT_MAX, nullptr, nullptr, 0);
}

/// Needs the claim on the view. Null: this process has no room for it.
std::uint8_t* mapped_slot(std::uint32_t view, std::uint32_t slot, std::size_t bytes) noexcept {
  Mapping& m = slots[view][slot];
  if (m.bytes >= bytes) return m.at;
  if (m.at != nullptr) ::munmap(m.at, m.bytes);
  m = Mapping{};
  const std::size_t rounded = (bytes + kMapUnit - 1) / kMapUnit * kMapUnit;
  void* at = ::mmap64(nullptr, rounded, PROT_READ | PROT_WRITE, MAP_SHARED, memory_fd,
                      static_cast<off64_t>(slot_at(view, slot)));
  if (at == MAP_FAILED) return nullptr;
  m = Mapping{static_cast<std::uint8_t*>(at), rounded};
  return m.at;
}

/// Whether this window answers a request for any window. It stays the same one while it shows pictures.
bool is_bound(Head& head, View& view, const Shown& shown, std::uint32_t now_ms) noexcept {
  std::uint32_t bound = view.bound.load(std::memory_order_relaxed);
  if (bound == shown.number + 1) return true;
  if (bound > 0 && bound <= kMaxWindows) {
    const Window& other = head.window[bound - 1];
    if (other.process.load(std::memory_order_relaxed) != 0 &&
        now_ms - other.alive_ms.load(std::memory_order_relaxed) < kAliveMs)
      return false;
  }
  return view.bound.compare_exchange_strong(bound, shown.number + 1, std::memory_order_relaxed);
}

/// Whether request `number` of the view is one for this window, now.
bool is_due(Head& head, View& view, std::uint32_t& number, Request& request, const Shown& shown,
            std::int64_t now) noexcept {
  number = view.answered.load(std::memory_order_acquire);
  if (view.asked.load(std::memory_order_acquire) == number) return false;  // partner: the reader's release
  const Answer& last = view.answers[(number + kSlots - 1) % kSlots];
  if (last.swap == shown.swaps && last.window == shown.number) return false;  // one picture is no two
  request = view.requests[number % kSlots];
  if (request.due.get() > now) return false;
  if (request.window == kNoNumber) return is_bound(head, view, shown, milliseconds(now));
  return request.window == shown.number;
}

template <class Act>
void for_each_view(std::uint32_t views, Act&& act) noexcept {
  for (; views != 0; views &= views - 1) {
    const auto v = static_cast<std::uint32_t>(__builtin_ctz(views));
    if (v >= kMaxViews || act(v)) return;
  }
}

/// The part of a region that is inside; false: nothing.
bool clip(const Request& r, Size size, Answer& a) noexcept {
  const std::int64_t left = r.x, top = r.y;
  const std::int64_t right = r.width == 0 ? std::int64_t{size.width} : left + r.width;
  const std::int64_t bottom = r.height == 0 ? std::int64_t{size.height} : top + r.height;
  const std::int64_t x0 = left < 0 ? 0 : left, y0 = top < 0 ? 0 : top;
  const std::int64_t x1 = right < size.width ? right : size.width, y1 = bottom < size.height ? bottom : size.height;
  if (x1 <= x0 || y1 <= y0) return false;
  a.x = static_cast<std::int32_t>(x0), a.y = static_cast<std::int32_t>(y0);
  a.width = static_cast<std::uint32_t>(x1 - x0), a.height = static_cast<std::uint32_t>(y1 - y0);
  a.stride = a.width * kBytesPerPixel;
  return true;
}

void publish(View& view, const Job& job) noexcept {
  view.answers[job.number % kSlots] = job.answer;
  view.answered.store(job.number + 1, std::memory_order_release);  // partner: the reader's acquire
  view.claimed.store(0, std::memory_order_release);
  wake_all(view.answered);
}

}  // namespace

std::int64_t now_ns() noexcept {
  timespec t{};
  ::clock_gettime(CLOCK_MONOTONIC, &t);
  return static_cast<std::int64_t>(t.tv_sec) * 1000000000 + t.tv_nsec;
}

Head* memory() noexcept {
  switch (connection.load(std::memory_order_acquire)) {
    case Connection::on:
      return head_;
    case Connection::off:
      return nullptr;
    case Connection::none:
      break;
  }
  const ErrnoKept kept;
  const Locked locked;
  if (connection.load(std::memory_order_relaxed) == Connection::none) {
    connect_now();
    connection.store(head_ != nullptr ? Connection::on : Connection::off, std::memory_order_release);
  }
  return connection.load(std::memory_order_relaxed) == Connection::on ? head_ : nullptr;
}

bool reads_buffered() noexcept { return buffered; }

bool count_picture(Head& head, Api api, const void* display, std::uint64_t key, Shown& shown) noexcept {
  const std::uint32_t number = me.load(std::memory_order_relaxed);
  {
    const Locked locked;
    Shown* found = nullptr;
    Shown* free = nullptr;
    for (Shown& w : windows) {
      if (w.api == api && w.key == key && w.display == display) found = &w;
      if (w.api == Api::none && free == nullptr) free = &w;
    }
    if (found == nullptr) {
      if (free == nullptr) return false;
      const ErrnoKept kept;
      const std::uint32_t taken = take_window(head, api, display, key);
      if (taken == kNoNumber) return false;
      *free = Shown{api, display, key, taken, 0};
      found = free;
    }
    ++found->swaps;
    shown = *found;
  }
  Window& window = head.window[shown.number];
  if (window.process.load(std::memory_order_relaxed) != number) {
    leave();
    return false;
  }
  window.swaps.store(shown.swaps, std::memory_order_relaxed);
  return true;
}

bool wants_size(const Head& head, const Shown& shown) noexcept {
  return head.window[shown.number].ready.load(std::memory_order_relaxed) == 0;
}

void tell_size(Head& head, const Shown& shown, Size size) noexcept {
  Window& window = head.window[shown.number];
  window.width.store(size.width, std::memory_order_relaxed);
  window.height.store(size.height, std::memory_order_relaxed);
  if (window.ready.load(std::memory_order_relaxed) != 0) return;
  window.ready.store(1, std::memory_order_release);
  head.windows.fetch_add(1, std::memory_order_release);
  const ErrnoKept kept;
  wake_all(head.windows);
}

void note_x11_window(Api api, const void* display, std::uint64_t key, std::uint64_t window) noexcept {
  const Locked locked;
  Behind* to = nullptr;
  for (Behind& b : behind) {
    if (b.api == api && b.key == key && b.display == display) to = &b;  // the program had destroyed that one unseen
    if (to == nullptr && b.api == Api::none) to = &b;
  }
  if (to != nullptr) *to = Behind{api, display, key, x11_number(window)};
}

void forget_window(Api api, const void* display, std::uint64_t key) noexcept {
  {
    const Locked locked;
    for (Behind& b : behind)
      if (b.api == api && b.key == key && b.display == display) b = Behind{};
  }
  if (connection.load(std::memory_order_acquire) != Connection::on) return;
  const ErrnoKept kept;
  const Locked locked;
  for (Shown& w : windows) {
    if (w.api != api || w.key != key || w.display != display) continue;
    Window& window = head_->window[w.number];
    if (window.process.load(std::memory_order_relaxed) == me.load(std::memory_order_relaxed)) {
      window.ready.store(0, std::memory_order_relaxed);
      window.process.store(0, std::memory_order_release);
    }
    w = Shown{};
    head_->windows.fetch_add(1, std::memory_order_release);
    wake_all(head_->windows);
  }
}

bool is_asked(Head& head, const Shown& shown, std::int64_t now) noexcept {
  head.window[shown.number].alive_ms.store(milliseconds(now), std::memory_order_relaxed);
  bool asked = false;
  for_each_view(head.views.load(std::memory_order_acquire), [&](std::uint32_t v) {
    std::uint32_t number = 0;
    Request request{};
    asked = is_due(head, head.view[v], number, request, shown, now);
    return asked;
  });
  return asked;
}

bool take_job(Head& head, const Shown& shown, std::int64_t now, Size size, Job& job) noexcept {
  const ErrnoKept kept;
  bool taken = false;
  for_each_view(head.views.load(std::memory_order_acquire), [&](std::uint32_t v) {
    View& view = head.view[v];
    std::uint32_t number = 0, nobody = 0;
    Request request{};
    if (!is_due(head, view, number, request, shown, now)) return false;
    if (!view.claimed.compare_exchange_strong(nobody, me.load(std::memory_order_relaxed), std::memory_order_acquire))
      return false;
    // Another thread may have answered it meanwhile, or `sinew grab` given the view to another reader.
    std::uint32_t still = 0;
    if (!is_due(head, view, still, request, shown, now) || still != number) {
      view.claimed.store(0, std::memory_order_release);
      return false;
    }
    job = Job{};
    job.view = v, job.number = number;
    job.answer.window = shown.number, job.answer.swap = shown.swaps;
    job.answer.window_width = size.width, job.answer.window_height = size.height;
    job.answer.shown.set(now);
    if (!clip(request, size, job.answer)) {
      refuse(head, job, AnswerStatus::outside);
      return false;
    }
    const std::uint64_t bytes = std::uint64_t{job.answer.stride} * job.answer.height;
    if (bytes <= kSlotBytes) job.pixels = mapped_slot(v, number % kSlots, static_cast<std::size_t>(bytes));
    if (job.pixels == nullptr) {
      refuse(head, job, AnswerStatus::too_large);
      return false;
    }
    taken = true;
    return true;
  });
  return taken;
}

void finish(Head& head, Job& job, PixelOrder order, bool bottom_up) noexcept {
  const ErrnoKept kept;
  job.answer.status = static_cast<std::uint32_t>(AnswerStatus::ok);
  job.answer.order = static_cast<std::uint32_t>(order);
  job.answer.bottom_up = bottom_up ? 1 : 0;
  job.answer.there.set(now_ns());
  publish(head.view[job.view], job);
  job.view = kNoNumber;
}

void refuse(Head& head, Job& job, AnswerStatus status) noexcept {
  const ErrnoKept kept;
  job.answer.status = static_cast<std::uint32_t>(status);
  job.answer.there.set(now_ns());
  publish(head.view[job.view], job);
  job.view = kNoNumber;
}

}  // namespace sinew::grab
