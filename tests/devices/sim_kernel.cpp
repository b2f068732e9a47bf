#include "sim_kernel.hpp"

#include <asm/termbits.h>
#include <fcntl.h>
#include <grp.h>
#include <linux/i2c-dev.h>
#include <linux/i2c.h>
#include <linux/spi/spidev.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdarg>
#include <cstring>

#include "virtual_os.hpp"

namespace sinew::test {
namespace {

SimKernel* the_one = nullptr;
constexpr unsigned kGroup = 54321;  // the number of SimKernel::group

int errno_of(const hal::Error& error) {
  if (error.code == hal::Errc::not_found) return ENXIO;
  return error.code == hal::Errc::closed ? ENODEV : EIO;
}

bool below(const std::string& path, const std::string& folder) {
  return path == folder || (path.starts_with(folder) && path[folder.size()] == '/');
}

}  // namespace

SimKernel::SimKernel() { the_one = this; }
SimKernel::~SimKernel() { the_one = nullptr; }
SimKernel* SimKernel::current() { return the_one; }

bool SimKernel::knows(const std::string& path) const {
  for (const auto& [folder, error] : refused_)
    if (error != 0 && below(path, folder)) return true;
  return nodes_.contains(path);
}

void SimKernel::remove(const std::string& path) {
  struct Dead final : SimNode {
    int open() override { return -ENODEV; }
    int ioctl(unsigned long, void*) override { return -ENODEV; }
  };
  const auto node = nodes_.find(path);
  if (node == nodes_.end()) return;
  for (auto& [fd, open] : open_)
    if (open == node->second) open = std::make_shared<Dead>();
  nodes_.erase(node);
}

std::optional<int> SimKernel::open(const std::string& path) {
  for (const auto& [folder, error] : refused_)
    if (error != 0 && below(path, folder)) return -error;
  const auto node = nodes_.find(path);
  if (node == nodes_.end()) return std::nullopt;
  const int fd = node->second->open();
  if (fd >= 0) open_[fd] = node->second;
  return fd;
}

std::shared_ptr<SimNode> SimKernel::of(int fd) const {
  const auto it = open_.find(fd);
  return it == open_.end() ? nullptr : it->second;
}

int I2cNode::open() { return ::eventfd(0, EFD_CLOEXEC); }
int I2cNode::ioctl(unsigned long request, void* argument) {
  if (request == I2C_FUNCS) {
    *static_cast<unsigned long*>(argument) = I2C_FUNC_I2C;
    return 0;
  }
  if (request == I2C_SLAVE)
    return held.contains(static_cast<int>(reinterpret_cast<std::uintptr_t>(argument))) ? -EBUSY : 0;
  if (request != I2C_RDWR) return -ENOTTY;
  const auto& data = *static_cast<const i2c_rdwr_ioctl_data*>(argument);
  std::span<const std::uint8_t> write;
  std::span<std::uint8_t> read;
  for (unsigned i = 0; i < data.nmsgs; ++i) {
    if (data.msgs[i].flags & I2C_M_RD)
      read = {data.msgs[i].buf, data.msgs[i].len};
    else
      write = {data.msgs[i].buf, data.msgs[i].len};
  }
  const auto done = bus_->transfer(static_cast<std::uint8_t>(data.msgs[0].addr), write, read);
  return done ? static_cast<int>(data.nmsgs) : -errno_of(done.error());
}

int SpiNode::open() { return ::eventfd(0, EFD_CLOEXEC); }
int SpiNode::ioctl(unsigned long request, void* argument) {
  if (request != SPI_IOC_MESSAGE(1)) return 0;  // mode, bits and clock: it can do all
  const auto& t = *static_cast<const spi_ioc_transfer*>(argument);
  auto* in = reinterpret_cast<std::uint8_t*>(static_cast<std::uintptr_t>(t.rx_buf));
  const auto* out = reinterpret_cast<const std::uint8_t*>(static_cast<std::uintptr_t>(t.tx_buf));
  const auto done = chip_->transfer({out, t.len}, in ? std::span(in, t.len) : std::span<std::uint8_t>());
  return done ? static_cast<int>(t.len) : -errno_of(done.error());
}

int SerialNode::open() {
  if (held) return -EBUSY;
  int ends[2];
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0, ends) != 0) return -errno;
  if (far_ >= 0) ::close(far_);
  far_ = ends[1];
  return ends[0];
}
int SerialNode::ioctl(unsigned long request, void* argument) {
  auto* t = static_cast<termios2*>(argument);
  if (request == TCSETS2) rate_ = t->c_ospeed != 0 ? t->c_ospeed : rate_;
  if (request == TCGETS2) {
    *t = {};
    t->c_ispeed = t->c_ospeed = rate_;
  }
  return 0;
}
void SerialNode::send(std::span<const std::uint8_t> bytes) {
  // A line that nobody reads overflows in the kernel: lost, as there.
  if (far_ >= 0) (void)::send(far_, bytes.data(), bytes.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
}
std::vector<std::uint8_t> SerialNode::heard() {
  std::array<std::uint8_t, 512> bytes;
  const auto n = far_ < 0 ? 0 : ::recv(far_, bytes.data(), bytes.size(), MSG_DONTWAIT);
  return {bytes.data(), bytes.data() + std::max<ssize_t>(n, 0)};
}
void SerialNode::unplug() {
  if (far_ >= 0) ::close(far_);
  far_ = -1;
}

}  // namespace sinew::test

// ---- replacements that the linker puts in the place of the C library's calls

using sinew::test::SimKernel;
using sinew::test::VirtualOs;

namespace {
int answer(int said) {
  if (said >= 0) return said;
  errno = -said;
  return -1;
}
}  // namespace

#ifdef __USE_TIME_BITS64  // other names there: see CMakeLists.txt
#define __real_open __real_open64
#define __wrap_open __wrap_open64
#define __real_ioctl __real___ioctl_time64
#define __wrap_ioctl __wrap___ioctl_time64
#define __real_stat __real___stat64_time64
#define __wrap_stat __wrap___stat64_time64
#define __real_ppoll __real___ppoll64
#define __wrap_ppoll __wrap___ppoll64
#define __real_clock_gettime __real___clock_gettime64
#define __wrap_clock_gettime __wrap___clock_gettime64
#endif

extern "C" {

int __real_open(const char* path, int flags, ...);
int __real_ioctl(int fd, unsigned long request, ...);
int __real_close(int fd);
int __real_flock(int fd, int how);
int __real_stat(const char* path, struct stat* out);
int __real_socket(int domain, int type, int protocol);
int __real_ppoll(pollfd* fds, nfds_t n, const timespec* limit, const sigset_t* mask);
int __real_clock_gettime(clockid_t id, timespec* out);
int __real_getgrgid_r(gid_t id, group* entry, char* space, std::size_t size, group** found);

int __wrap_open(const char* path, int flags, ...) {
  va_list list;
  va_start(list, flags);
  const auto mode = (flags & O_CREAT) ? va_arg(list, unsigned) : 0u;
  va_end(list);
  SimKernel* kernel = SimKernel::current();
  if (const auto fd = kernel ? kernel->open(path) : std::nullopt) return answer(*fd);
  return __real_open(path, flags, mode);
}

int __wrap_ioctl(int fd, unsigned long request, ...) {
  va_list list;
  va_start(list, request);
  void* argument = va_arg(list, void*);
  va_end(list);
  SimKernel* kernel = SimKernel::current();
  if (const auto node = kernel ? kernel->of(fd) : nullptr) return answer(node->ioctl(request, argument));
  return __real_ioctl(fd, request, argument);
}

int __wrap_close(int fd) {
  if (SimKernel* kernel = SimKernel::current()) kernel->close(fd);
  return __real_close(fd);
}

int __wrap_flock(int fd, int how) {
  SimKernel* kernel = SimKernel::current();
  if (const auto node = kernel ? kernel->of(fd) : nullptr) return answer(node->lock());
  return __real_flock(fd, how);
}

int __wrap_stat(const char* path, struct stat* out) {
  SimKernel* kernel = SimKernel::current();
  if (!kernel || !kernel->knows(path)) return __real_stat(path, out);
  *out = {};
  out->st_mode = S_IFCHR | 0660;
  out->st_gid = sinew::test::kGroup;
  return 0;
}

int __wrap_getgrgid_r(gid_t id, group* entry, char* space, std::size_t size, group** found) {
  SimKernel* kernel = SimKernel::current();
  if (!kernel || id != sinew::test::kGroup) return __real_getgrgid_r(id, entry, space, size, found);
  std::strncpy(space, kernel->group.c_str(), size);
  entry->gr_name = space;
  *found = entry;
  return 0;
}

int __wrap_socket(int domain, int type, int protocol) {
  SimKernel* kernel = SimKernel::current();
  if (!kernel || domain != PF_CAN) return __real_socket(domain, type, protocol);
  if (kernel->can_socket_errno != 0) return answer(-kernel->can_socket_errno);
  return __real_socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
}

int __wrap_ppoll(pollfd* fds, nfds_t n, const timespec* limit, const sigset_t* mask) {
  VirtualOs* os = VirtualOs::current();
  if (!os) return __real_ppoll(fds, n, limit, mask);
  const auto until =
      limit ? os->now() + sinew::hal::Duration{limit->tv_sec * 1'000'000'000 + limit->tv_nsec} : sinew::hal::kNever;
  if (const auto said = os->poll(fds, n, until)) return *said;
  return __real_ppoll(fds, n, limit, mask);
}

int __wrap_clock_gettime(clockid_t id, timespec* out) {
  VirtualOs* os = VirtualOs::current();
  if (!os || id != CLOCK_MONOTONIC) return __real_clock_gettime(id, out);
  const std::int64_t ns = os->now().ns;
  out->tv_sec = ns / 1'000'000'000;
  out->tv_nsec = static_cast<long>(ns % 1'000'000'000);
  return 0;
}

}  // extern "C"
