#include "hal/linux/fd_watch.hpp"

#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>

namespace sinew::hal {

Result<std::shared_ptr<FdWatch>> FdWatch::start(Os& os, const ThreadOptions& options) {
  const int epoll = epoll_create1(EPOLL_CLOEXEC), stop = eventfd(0, EFD_CLOEXEC);
  std::shared_ptr<FdWatch> watch(new FdWatch(epoll, stop));
  if (epoll < 0 || stop < 0) return Error{Errc::io, "epoll_create1", errno};
  epoll_event event{};
  event.events = EPOLLIN;
  event.data.fd = stop;
  if (epoll_ctl(epoll, EPOLL_CTL_ADD, stop, &event) != 0) return Error{Errc::io, "epoll_ctl", errno};
  auto thread = os.start_thread(options, [w = watch.get()] { w->loop(); });
  if (!thread) return thread.error();
  watch->thread_ = std::move(*thread);
  return watch;
}

FdWatch::FdWatch(int epoll, int stop) : epoll_(epoll), stop_(stop) {}

FdWatch::~FdWatch() {
  if (thread_) {
    const std::uint64_t one = 1;
    while (write(stop_, &one, sizeof one) < 0 && errno == EINTR) {
    }
    thread_.reset();
  }
  if (epoll_ >= 0) close(epoll_);
  if (stop_ >= 0) close(stop_);
}

Status FdWatch::add(int fd, FdLine& line) {
  if (epoll_ < 0) return {};
  const std::lock_guard lock(mutex_);
  entries_.push_back({fd, &line});
  epoll_event event{};
  event.events = EPOLLIN | EPOLLPRI | EPOLLRDHUP | EPOLLET;
  event.data.fd = fd;
  if (epoll_ctl(epoll_, EPOLL_CTL_ADD, fd, &event) == 0) return {};
  const int why = errno;
  entries_.pop_back();
  return Error{Errc::io, "epoll_ctl", why};
}

void FdWatch::remove(int fd) noexcept {
  if (epoll_ < 0) return;
  const std::lock_guard lock(mutex_);
  epoll_ctl(epoll_, EPOLL_CTL_DEL, fd, nullptr);
  std::erase_if(entries_, [fd](const Entry& e) { return e.fd == fd; });
}

void FdWatch::loop() noexcept {
  std::array<epoll_event, 16> events{};
  for (;;) {
    const int n = epoll_wait(epoll_, events.data(), static_cast<int>(events.size()), -1);
    if (n < 0 && errno != EINTR) return;
    for (int i = 0; i < n; ++i) {
      const int fd = events[static_cast<std::size_t>(i)].data.fd;
      if (fd == stop_) return;
      const std::lock_guard lock(mutex_);  // remove() waits until its line was rung
      const auto entry = std::find_if(entries_.begin(), entries_.end(), [fd](const Entry& e) { return e.fd == fd; });
      if (entry != entries_.end()) entry->line->ring();
    }
  }
}

}  // namespace sinew::hal
