// A program that treats a robot as badly as a program of the same user can without a debugger: hostile_test.cpp and
// bench/hostile_bench.cpp start it beside robots.
//   tap_hostile write|garbage|half|flood|sit|spin|wake|killed|burn|stranger SOCKET, hold NAME [SECONDS or COUNT]
// Prints what it did, exit code 0; "broken: ..." and 1 when the robot let something through.
#include <fcntl.h>
#include <linux/futex.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <climits>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include "hal/linux/socket.hpp"
#include "tap/frames.hpp"
#include "tap/names.hpp"
#include "tap/segment_reader.hpp"
#include "tap_graph.hpp"

namespace sinew::tap {
namespace {

#ifndef F_SEAL_FUTURE_WRITE
#define F_SEAL_FUTURE_WRITE 0x0010
#endif

std::string g_socket;
std::uint32_t g_random = 1;

std::uint32_t draw() {
  g_random = g_random * 1664525 + 1013904223;
  return g_random >> 8;
}

[[noreturn]] void broken(const std::string& what) {
  std::printf("broken: %s (%s)\n", what.c_str(), std::strerror(errno));
  std::fflush(stdout);
  std::_Exit(1);
}

/// Negative when the robot does not let us in just now.
int open_socket() {
  const int fd = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::strncpy(address.sun_path, g_socket.c_str(), sizeof address.sun_path - 1);
  if (::connect(fd, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0) return fd;
  ::close(fd);
  return -1;
}

bool send_all(int fd, const void* data, std::size_t n) {
  return ::send(fd, data, n, MSG_NOSIGNAL) == static_cast<ssize_t>(n);
}

bool send_frame(int fd, const std::string& text) {
  const auto head = frame_head(text.size());
  std::string all(reinterpret_cast<const char*>(head.data()), head.size());
  all += text;
  return send_all(fd, all.data(), all.size());
}

/// The handle that comes with a reply; negative when the robot hung up.
int request_handle(int fd, const char* request) {
  if (!send_frame(fd, std::string("{\"request\":\"") + request + "\"}")) return -1;
  alignas(cmsghdr) char control[CMSG_SPACE(sizeof(int))] = {};
  char text[4096];
  iovec part{text, sizeof text};
  msghdr message{};
  message.msg_iov = &part, message.msg_iovlen = 1;
  message.msg_control = control, message.msg_controllen = sizeof control;
  if (::recvmsg(fd, &message, 0) <= 0) return -1;
  const cmsghdr* item = CMSG_FIRSTHDR(&message);
  if (!item) return -1;
  int handle = -1;
  std::memcpy(&handle, CMSG_DATA(item), sizeof handle);
  return handle;
}

struct Mapped {
  int fd = -1;
  std::byte* data = nullptr;
  std::size_t size = 0;
};

Mapped map(int fd) {
  struct stat info {};
  if (fd < 0 || ::fstat(fd, &info) != 0) return {};
  const auto size = static_cast<std::size_t>(info.st_size);
  void* at = ::mmap(nullptr, size, PROT_READ, MAP_SHARED, fd, 0);
  if (at == MAP_FAILED) return {};
  return {fd, static_cast<std::byte*>(at), size};
}

/// Tries all calls that could change another program's memory; each must fail.
void try_to_write(const Mapped& m, const char* name) {
  const std::string of = std::string(" of the ") + name;
  const auto refused = [&of](bool yes, const char* what) {
    if (!yes) broken(what + of + " works");
  };
  const char byte = 'x';
  const auto try_fd = [&](int fd, const char* what) {
    refused(::pwrite(fd, &byte, 1, 0) < 0, (std::string("write through ") + what).c_str());
    refused(::ftruncate(fd, 0) < 0, (std::string("shrink through ") + what).c_str());
    refused(::ftruncate(fd, static_cast<off_t>(m.size + 4096)) < 0, (std::string("grow through ") + what).c_str());
    refused(::mmap(nullptr, 4096, PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0) == MAP_FAILED,
            (std::string("writable mapping through ") + what).c_str());
    refused(::fallocate(fd, FALLOC_FL_PUNCH_HOLE | FALLOC_FL_KEEP_SIZE, 0, 4096) < 0,
            (std::string("hole through ") + what).c_str());
    refused(::fcntl(fd, F_ADD_SEALS, F_SEAL_WRITE) < 0, (std::string("seal through ") + what).c_str());
  };
  try_fd(m.fd, "the handle");
  const int copy = ::dup(m.fd);
  try_fd(copy, "a copy");
  const std::string path = "/proc/self/fd/" + std::to_string(m.fd);
  ::fchmod(m.fd, 0777);
  if (const int again = ::open(path.c_str(), O_RDWR | O_CLOEXEC); again >= 0) try_fd(again, "/proc");
  if (const int shorter = ::open(path.c_str(), O_RDWR | O_TRUNC | O_CLOEXEC); shorter >= 0) broken("O_TRUNC" + of);
  ::fchmod(m.fd, 0);
  refused(::mprotect(m.data, 4096, PROT_READ | PROT_WRITE) < 0, "mprotect");
  if (!std::getenv("SINEW_QEMU_USER"))  // that answers 0 to such advice, and does nothing
    refused(::madvise(m.data, 4096, MADV_REMOVE) < 0, "MADV_REMOVE");
  if (const int memory = ::open("/proc/self/mem", O_RDWR | O_CLOEXEC); memory >= 0)
    refused(::pwrite(memory, &byte, 1, static_cast<off_t>(reinterpret_cast<std::uintptr_t>(m.data))) < 0,
            "write through /proc/self/mem");
  const iovec from{const_cast<char*>(&byte), 1}, to{m.data, 1};
  refused(::process_vm_writev(::getpid(), &from, 1, &to, 1, 0) < 0, "process_vm_writev");
  struct stat info {};
  if (::fstat(m.fd, &info) != 0 || static_cast<std::size_t>(info.st_size) != m.size)
    broken("the size" + of + " changed");
}

/// A private writable mapping is a copy: the robot's pages stay as they are.
void write_privately(const Mapped& m) {
  void* mine = ::mmap(nullptr, m.size, PROT_READ | PROT_WRITE, MAP_PRIVATE, m.fd, 0);
  if (mine == MAP_FAILED) return;
  std::memset(mine, 0xFF, m.size);
  if (std::to_integer<int>(m.data[0]) == 0xFF) broken("a private copy is the robot's memory");
  ::munmap(mine, m.size);
}

int write() {
  const int fd = open_socket();
  const Mapped topics = map(request_handle(fd, "memory")), bells = map(request_handle(fd, "doorbells"));
  if (!topics.data || !bells.data) broken("no memory came");
  try_to_write(topics, "topics");
  try_to_write(bells, "doorbells");
  write_privately(topics);
  write_privately(bells);
  std::printf("nothing could be written\n");
  return 0;
}

/// Looks at a frame in place, as slowly as a reader may.
bool is_torn(const Message& m) {
  const volatile std::byte* frame = m.data();
  std::uint32_t number = 0;
  std::memcpy(&number, m.data() + offsetof(msg::Image, frame_number), sizeof number);
  for (std::size_t i = sizeof(msg::Image); i < sizeof(msg::Image) + Eye::kWidth * Eye::kHeight; ++i)
    if (frame[i] != static_cast<std::byte>(number)) return true;
  return false;
}

/// Reads everything and checks that messages reported as whole are whole.
void look(const SegmentReader& reader, std::vector<std::byte>& copy, std::uint64_t& whole, std::uint64_t& overtaken) {
  for (std::uint32_t t = 0; t < reader.topics().size(); ++t) {
    copy.resize(reader.bytes(t));
    const auto m = reader.newest(t);
    if (!m) continue;
    const bool torn = reader.topics()[t].name == "eye.image" && is_torn(*m);
    if (!reader.copy(*m, copy)) {
      ++overtaken;
      continue;
    }
    if (torn) broken("a torn frame was taken for whole");
    ++whole;
  }
}

int spin(double seconds) {
  const Mapped m = map(request_handle(open_socket(), "memory"));
  const auto reader = SegmentReader::open({m.data, m.size});
  if (!reader) broken("the directory is refused");
  std::uint64_t whole = 0, overtaken = 0;
  std::vector<std::byte> copy;
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
  while (std::chrono::steady_clock::now() < end)
    for (int i = 0; i < 100; ++i) look(*reader, copy, whole, overtaken);
  std::printf("%llu whole messages, %llu overtaken\n", static_cast<unsigned long long>(whole),
              static_cast<unsigned long long>(overtaken));
  return whole > 0 ? 0 : 1;
}

/// Only uses up a processor and its caches, as any program may.
int burn(double seconds) {
  std::vector<char> a(8 << 20, 1), b(8 << 20);
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
  while (std::chrono::steady_clock::now() < end) std::memcpy(b.data(), a.data(), a.size());
  return b[0] == 1 ? 0 : 1;
}

int wake(double seconds) {
  const int fd = open_socket();
  send_frame(fd, R"({"request":"subscribe","topics":["counter.range","eye.image"]})");
  char reply[4096];
  if (::recv(fd, reply, sizeof reply, 0) <= 0) broken("no reply");
  const Mapped topics = map(request_handle(fd, "memory")), bells = map(request_handle(fd, "doorbells"));
  std::uint64_t wakes = 0;
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
  const auto over = [&] { return std::chrono::steady_clock::now() >= end; };
  while (!over())  // the doorbells first: a robot's pictures are a million words
    for (const Mapped& m : {bells, topics})
      for (std::size_t at = 0; at < m.size && (at % 4096 != 0 || !over()); at += 4, ++wakes)
        ::syscall(SYS_futex, m.data + at, FUTEX_WAKE, INT_MAX, nullptr, nullptr, 0);
  std::printf("%llu wakes\n", static_cast<unsigned long long>(wakes));
  return 0;
}

/// Frames that are no requests, heads that are no lengths, and plain noise, until the robot hangs up; then again.
int garbage(int count) {
  const char* texts[] = {"{",
                         "[]",
                         "null",
                         "{\"request\":1}",
                         "{\"request\":\"fly\"}",
                         "\xFF\xFE",
                         "{\"request\":\"param.set\",\"module\":{},\"param\":[],\"value\":\"\"}",
                         "{\"request\":\"subscribe\",\"topics\":[[[[[[[]]]]]]]}",
                         "{\"request\":\"publish\",\"topic\":\"operator.range\",\"message\":{\"stamp\":1e999}}"};
  int closed = 0;
  for (int i = 0; i < count; ++i) {
    const int fd = open_socket();
    if (fd < 0) continue;
    for (int k = 0; k < 20; ++k) {
      std::string text;
      if (draw() % 3 == 0) {
        for (std::uint32_t n = 1 + draw() % 300; n > 0; --n) text += static_cast<char>(draw());
      } else {
        text = texts[draw() % std::size(texts)];
      }
      const bool sent = draw() % 4 == 0 ? send_all(fd, text.data(), text.size()) : send_frame(fd, text);
      if (!sent) {
        ++closed;
        break;
      }
    }
    const int handles[] = {fd, fd, fd};
    alignas(cmsghdr) char control[CMSG_SPACE(sizeof handles)] = {};
    char x = 'x';
    iovec part{&x, 1};
    msghdr message{};
    message.msg_iov = &part, message.msg_iovlen = 1;
    message.msg_control = control, message.msg_controllen = sizeof control;
    cmsghdr* item = CMSG_FIRSTHDR(&message);
    item->cmsg_level = SOL_SOCKET, item->cmsg_type = SCM_RIGHTS, item->cmsg_len = CMSG_LEN(sizeof handles);
    std::memcpy(CMSG_DATA(item), handles, sizeof handles);
    ::sendmsg(fd, &message, MSG_NOSIGNAL);  // and handles that nobody asked for
    ::close(fd);
  }
  std::printf("%d connections of garbage, %d closed by the robot\n", count, closed);
  return 0;
}

/// Half a request, and silence.
int half(double seconds) {
  for (int i = 0; i < 4; ++i) {
    const int fd = open_socket();
    const auto head = frame_head(60'000);
    send_all(fd, head.data(), i == 0 ? 2 : 4);
    if (i > 1) send_all(fd, "{\"request\":", 11);
  }
  ::usleep(static_cast<useconds_t>(seconds * 1e6));
  std::printf("half requests\n");
  return 0;
}

/// As many requests as the socket takes; the replies of the first connection are read, the others never.
int flood(double seconds) {
  std::vector<int> fds;
  for (int i = 0; i < 4; ++i) fds.push_back(open_socket());
  std::uint64_t sent = 0;
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
  const std::string text = R"({"request":"status"})";
  const auto head = frame_head(text.size());
  std::string frame(reinterpret_cast<const char*>(head.data()), head.size());
  frame += text;
  char reply[64 * 1024];
  while (std::chrono::steady_clock::now() < end)
    for (int& fd : fds) {
      if (fd == fds[0]) static_cast<void>(::recv(fd, reply, sizeof reply, MSG_DONTWAIT) > 0);
      if (::send(fd, frame.data(), frame.size(), MSG_NOSIGNAL | MSG_DONTWAIT) == static_cast<ssize_t>(frame.size())) {
        ++sent;
      } else if (errno != EAGAIN) {
        ::close(fd);
        fd = open_socket();
      }
    }
  std::printf("%llu requests at once\n", static_cast<unsigned long long>(sent));
  return 0;
}

/// Four processes that take four connections each, all that there are, and keep them.
int sit(double seconds) {
  for (int i = 0; i < 3; ++i)
    if (::fork() == 0) {
      ::prctl(PR_SET_PDEATHSIG, SIGKILL);
      break;
    }
  for (int i = 0; i < 6; ++i) open_socket();
  ::usleep(static_cast<useconds_t>(seconds * 1e6));
  while (::wait(nullptr) > 0) {
  }
  std::printf("sat there\n");
  return 0;
}

/// A child in the middle of anything, until it is killed. Says when it is in.
[[noreturn]] void be_busy(std::uint32_t seed, int in, pid_t parent) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);  // not inherited; nobody may be left behind when the parent is killed itself
  if (::getppid() != parent) std::_Exit(1);
  g_random = seed * 2654435761U + 1;
  std::vector<std::byte> copy;
  std::uint64_t whole = 0, overtaken = 0;
  for (;;) {
    const int fd = open_socket();
    if (fd < 0) continue;
    if (::write(in, "x", 1) < 0) std::_Exit(1);
    if (draw() % 3 == 0) send_frame(fd, R"({"request":"subscribe","topics":["counter.range"]})");
    if (draw() % 2 == 0) send_frame(fd, R"({"request":"status"})");
    const Mapped m = map(request_handle(fd, "memory"));
    const auto reader = m.data ? SegmentReader::open({m.data, m.size}) : hal::Result<SegmentReader>(hal::Error{});
    for (std::uint32_t i = draw() % 100; reader && i > 0; --i) look(*reader, copy, whole, overtaken);
    if (draw() % 3 == 0) send_all(fd, "\x10\0\0", 3);
    if (m.data) ::munmap(m.data, m.size);
    if (m.fd >= 0) ::close(m.fd);
    ::close(fd);
  }
}

int killed(int count) {
  int died = 0;
  const pid_t self = ::getpid();
  for (int i = 0; i < count; ++i) {
    int in[2];
    if (::pipe2(in, O_CLOEXEC) != 0) broken("pipe");
    const pid_t child = ::fork();
    if (child < 0) broken("fork");
    if (child == 0) be_busy(static_cast<std::uint32_t>(i), in[1], self);
    char x = 0;
    if (::read(in[0], &x, 1) != 1) broken("no child came in");
    ::usleep(draw() % 1500);
    ::kill(child, SIGKILL);
    int status = 0;
    ::waitpid(child, &status, 0);
    ::close(in[0]), ::close(in[1]);
    died += WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL;
  }
  std::printf("killed %d times\n", died);
  return died == count ? 0 : 1;
}

/// Another user, who was let into the folder: the robot hangs up.
int stranger() {
  if (::setgid(65534) != 0 || ::setuid(65534) != 0) broken("setuid");
  const int fd = open_socket();
  if (fd < 0) broken("the test did not open the folder");
  send_frame(fd, R"({"request":"hello"})");
  char reply[256];
  if (::recv(fd, reply, sizeof reply, 0) > 0) broken("the robot talks to another user");
  std::printf("a stranger is not answered\n");
  return 0;
}

/// Is a robot as far as its name and socket go; the socket's path is the robot's name.
int hold() {
  std::string why;
  const auto name = Name::take(g_socket, why);
  if (!name) broken(why);
  const auto listener = hal::listen_stream("unix:" + (*name)->path());
  if (!listener) broken("listen");
  for (;;) ::pause();
}

int run(const std::string& what, double amount) {
  if (what == "stranger") return stranger();
  if (what == "hold") return hold();
  if (what == "write") return write();
  if (what == "spin") return spin(amount);
  if (what == "burn") return burn(amount);
  if (what == "wake") return wake(amount);
  if (what == "garbage") return garbage(static_cast<int>(amount));
  if (what == "half") return half(amount);
  if (what == "flood") return flood(amount);
  if (what == "sit") return sit(amount);
  if (what == "killed") return killed(static_cast<int>(amount));
  return 2;
}

}  // namespace
}  // namespace sinew::tap

int main(int argc, char** argv) {
  if (argc < 3) return 2;
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  sinew::tap::g_socket = argv[2];
  return sinew::tap::run(argv[1], argc > 3 ? std::atof(argv[3]) : 1);
}
