#include "hal/linux/beyond_posix.hpp"

#include <fcntl.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sched.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <string>

#include "hal/linux/process.hpp"
#include "hal/platform.hpp"

namespace sinew::hal {
namespace beyond_posix {
namespace {

void set(int socket, int level, int option, int value) noexcept {
  ::setsockopt(socket, level, option, &value, sizeof value);
}

struct flock whole_file() {
  struct flock lock {};
  lock.l_type = F_WRLCK;
  lock.l_whence = SEEK_SET;
  return lock;
}

}  // namespace

void give_up_on_a_silent_peer(int socket, Duration silence) noexcept {
  set(socket, IPPROTO_TCP, TCP_USER_TIMEOUT, static_cast<int>(silence / std::chrono::milliseconds(1)));
  set(socket, SOL_SOCKET, SO_KEEPALIVE, 1);
  set(socket, IPPROTO_TCP, TCP_KEEPIDLE, 2);
  set(socket, IPPROTO_TCP, TCP_KEEPINTVL, 1);
}

Result<Peer> peer_of(int socket) noexcept {
  ucred who{};
  socklen_t size = sizeof who;
  if (::getsockopt(socket, SOL_SOCKET, SO_PEERCRED, &who, &size) != 0)
    return Error{Errc::not_supported, "peer of this connection"};
  return Peer{who.pid, who.uid};
}

// Linux gives the file the socket's own mode.
bool bind_for_its_owner(int socket, const sockaddr* address, unsigned bytes) noexcept {
  return ::fchmod(socket, S_IRUSR | S_IWUSR) == 0 && ::bind(socket, address, bytes) == 0;
}

bool lock_file(int file) noexcept {
  struct flock lock = whole_file();
  return ::fcntl(file, F_OFD_SETLK, &lock) == 0;
}

bool is_locked_by_another(int file) noexcept {
  struct flock lock = whole_file();
  return ::fcntl(file, F_OFD_GETLK, &lock) == 0 && lock.l_type != F_UNLCK;
}

void end_with_parent(int signal) noexcept { ::prctl(PR_SET_PDEATHSIG, signal); }

// A system call, since the C library has pidfd_open() only from 2.36 on. A toolchain's older headers lack its number.
int end_of_child([[maybe_unused]] int pid) noexcept {
#ifdef SYS_pidfd_open
  return static_cast<int>(::syscall(SYS_pidfd_open, pid, 0));
#else
  return -1;
#endif
}

std::size_t threads() noexcept {
  std::error_code unreadable;
  std::size_t count = 0;
  for (std::filesystem::directory_iterator task("/proc/self/task", unreadable), end; !unreadable && task != end;
       task.increment(unreadable))
    ++count;
  return count;
}

std::uint64_t resident_bytes() noexcept {
  std::FILE* f = std::fopen("/proc/self/statm", "r");
  if (!f) return 0;
  unsigned long total = 0, resident = 0;
  const bool read = std::fscanf(f, "%lu %lu", &total, &resident) == 2;
  std::fclose(f);
  return read ? resident * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE)) : 0;
}

int open_again(int file, int flags) noexcept {
  return ::open(("/proc/self/fd/" + std::to_string(file)).c_str(), flags);
}

}  // namespace beyond_posix

std::optional<Time> process_start() {
  std::FILE* f = std::fopen("/proc/self/stat", "r");
  if (!f) return std::nullopt;
  char text[1024];
  text[std::fread(text, 1, sizeof(text) - 1, f)] = '\0';
  std::fclose(f);
  // The program's name is in parentheses and may contain some; field 3 follows the last, field 22 is wanted.
  const char* field = std::strrchr(text, ')');
  for (int i = 2; field && i < 22; ++i) field = std::strchr(field + 1, ' ');
  timespec since_boot{};
  if (!field || clock_gettime(CLOCK_BOOTTIME, &since_boot) != 0) return std::nullopt;
  const std::int64_t ticks = std::strtoll(field, nullptr, 10);
  const Duration began{ticks * (1'000'000'000 / sysconf(_SC_CLK_TCK))};
  const Duration now{std::int64_t{since_boot.tv_sec} * 1'000'000'000 + since_boot.tv_nsec};
  return system_os().now() - (now - began);
}

std::string program_path() {
  char path[4096];
  const auto n = readlink("/proc/self/exe", path, sizeof(path));
  return n > 0 ? std::string(path, static_cast<std::size_t>(n)) : std::string();
}

std::uint32_t usable_cpus() {
  cpu_set_t set;
  CPU_ZERO(&set);
  if (sched_getaffinity(0, sizeof(set), &set) != 0) return 1;
  return static_cast<std::uint32_t>(CPU_COUNT(&set));
}

}  // namespace sinew::hal
