// Two programs on two hosts of their own (network namespaces), and between them a link that delays and loses packets:
// two TUN devices, and this process that carries the packets from one to the other.
//   lossy_link [--delay-ms D] [--jitter-ms J] [--loss SHARE] [--seed N] [--cut-after S --cut-for S]
//              [--rate-kbps R [--queue-ms Q]] -- A ... --- B ...
// A has 10.77.0.1, B 10.77.0.2. Ends with B, with its exit code; A is ended then (SIGTERM). 77: a privilege is missing.
// Delay is per packet and direction, order is kept; a cut loses everything for its time. A rate is of each direction:
// packets wait for the ones before them, and are lost when they would have to wait longer than Q (200).
#include <arpa/inet.h>
#include <fcntl.h>
#include <linux/if.h>
#include <linux/if_tun.h>
#include <poll.h>
#include <sched.h>
#include <signal.h>
#include <sys/ioctl.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <deque>
#include <random>
#include <string>
#include <vector>

namespace {

using Clock = std::chrono::steady_clock;
using Seconds = std::chrono::duration<double>;

constexpr int kSkip = 77;
constexpr std::size_t kMtu = 1500, kMaxQueued = 4000;  // packets under way in one direction

struct Settings {
  double delay_ms = 0, jitter_ms = 0, loss = 0, cut_after_s = -1, cut_for_s = 0;
  double rate_kbps = 0, queue_ms = 200;  // 0: any
  unsigned seed = 1;
  std::vector<char*> a, b;
};

Clock::duration ms(double value) {
  return std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double, std::milli>(value));
}

bool read_settings(int argc, char** argv, Settings& s) {
  int i = 1;
  for (; i + 1 < argc && std::strcmp(argv[i], "--") != 0; i += 2) {
    const std::string key = argv[i];
    const double value = std::atof(argv[i + 1]);
    if (key == "--delay-ms")
      s.delay_ms = value;
    else if (key == "--jitter-ms")
      s.jitter_ms = value;
    else if (key == "--loss")
      s.loss = value;
    else if (key == "--seed")
      s.seed = static_cast<unsigned>(value);
    else if (key == "--cut-after")
      s.cut_after_s = value;
    else if (key == "--cut-for")
      s.cut_for_s = value;
    else if (key == "--rate-kbps")
      s.rate_kbps = value;
    else if (key == "--queue-ms")
      s.queue_ms = value;
    else
      return false;
  }
  std::vector<char*>* into = &s.a;
  for (++i; i < argc; ++i) {
    if (std::strcmp(argv[i], "---") == 0)
      into = &s.b;
    else
      into->push_back(argv[i]);
  }
  if (s.a.empty() || s.b.empty()) return false;
  s.a.push_back(nullptr), s.b.push_back(nullptr);
  return true;
}

int missing(const char* what) {
  std::fprintf(stderr, "lossy_link: skipped: %s: %s\n", what, std::strerror(errno));
  return kSkip;
}

bool bring_up(int socket, const char* name, const char* address) {
  ifreq r{};
  std::strncpy(r.ifr_name, name, IFNAMSIZ - 1);
  auto set = [&](unsigned long what, const char* text) {
    sockaddr_in in{};
    in.sin_family = AF_INET;
    inet_pton(AF_INET, text, &in.sin_addr);
    std::memcpy(&r.ifr_addr, &in, sizeof in);
    return ioctl(socket, what, &r) == 0;
  };
  if (address && (!set(SIOCSIFADDR, address) || !set(SIOCSIFNETMASK, "255.255.255.0"))) return false;
  r.ifr_flags = IFF_UP | IFF_RUNNING;
  return ioctl(socket, SIOCSIFFLAGS, &r) == 0;
}

void hand_over(int socket, int fd) {
  alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof fd)> control{};
  char byte = 0;
  iovec part{&byte, 1};
  msghdr m{};
  m.msg_iov = &part, m.msg_iovlen = 1, m.msg_control = control.data(), m.msg_controllen = control.size();
  cmsghdr* item = CMSG_FIRSTHDR(&m);
  item->cmsg_level = SOL_SOCKET, item->cmsg_type = SCM_RIGHTS, item->cmsg_len = CMSG_LEN(sizeof fd);
  std::memcpy(CMSG_DATA(item), &fd, sizeof fd);
  if (sendmsg(socket, &m, 0) < 0) _exit(kSkip);
}

int take_over(int socket) {
  alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof(int))> control{};
  char byte = 0;
  iovec part{&byte, 1};
  msghdr m{};
  m.msg_iov = &part, m.msg_iovlen = 1, m.msg_control = control.data(), m.msg_controllen = control.size();
  if (recvmsg(socket, &m, MSG_CMSG_CLOEXEC) <= 0 || !CMSG_FIRSTHDR(&m)) return -1;
  int fd = -1;
  std::memcpy(&fd, CMSG_DATA(CMSG_FIRSTHDR(&m)), sizeof fd);
  return fd;
}

/// The child's side: its own host with one TUN device, whose end goes to the parent; then the program.
[[noreturn]] void be_host(const char* address, char** program, int line) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (unshare(CLONE_NEWNET) != 0 && unshare(CLONE_NEWUSER | CLONE_NEWNET) != 0) _exit(missing("a network namespace"));
  const int tun = open("/dev/net/tun", O_RDWR | O_NONBLOCK | O_CLOEXEC);
  if (tun < 0) _exit(missing("/dev/net/tun"));
  ifreq r{};
  std::strncpy(r.ifr_name, "link0", IFNAMSIZ - 1);
  r.ifr_flags = IFF_TUN | IFF_NO_PI;
  if (ioctl(tun, TUNSETIFF, &r) != 0) _exit(missing("a TUN device"));
  const int s = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (!bring_up(s, "lo", nullptr) || !bring_up(s, "link0", address)) _exit(missing("an address"));
  hand_over(line, tun);
  char go = 0;
  if (read(line, &go, 1) != 1) _exit(kSkip);  // the other host is there as well
  execvp(program[0], program);
  std::fprintf(stderr, "lossy_link: %s: %s\n", program[0], std::strerror(errno));
  _exit(127);
}

struct Host {
  pid_t pid = -1;
  int line = -1, tun = -1;
};

Host start_host(const char* address, char** program) {
  Host h;
  std::array<int, 2> ends{};
  if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0) return h;
  h.pid = fork();
  if (h.pid == 0) be_host(address, program, ends[1]);
  close(ends[1]);
  h.line = ends[0];
  h.tun = take_over(h.line);
  return h;
}

/// One direction of the link.
class Wire {
 public:
  Wire(int from, int to, const Settings& s, unsigned seed) : from_(from), to_(to), s_(s), random_(seed) {}
  int from() const { return from_; }

  void take(Clock::time_point now, bool cut) {
    std::array<char, kMtu + 64> packet;
    for (;;) {
      const ssize_t n = read(from_, packet.data(), packet.size());
      if (n <= 0) return;
      const double draw = share(), jitter = share();
      if (cut || draw < s_.loss || queue_.size() >= kMaxQueued) continue;
      Clock::time_point sent = now;
      if (s_.rate_kbps > 0) {
        if (free_ > now + ms(s_.queue_ms)) continue;
        sent = free_ = std::max(free_, now) + ms(static_cast<double>(n) * 8 / s_.rate_kbps);
      }
      Clock::time_point due = sent + ms(s_.delay_ms + jitter * s_.jitter_ms);
      if (!queue_.empty() && due < queue_.back().due) due = queue_.back().due;
      queue_.push_back({due, {packet.data(), packet.data() + n}});
    }
  }
  void deliver(Clock::time_point now) {
    for (; !queue_.empty() && queue_.front().due <= now; queue_.pop_front()) {
      const auto& bytes = queue_.front().bytes;
      if (write(to_, bytes.data(), bytes.size()) < 0) ++full_;  // the device is full: lost as well
    }
  }
  Clock::time_point next() const { return queue_.empty() ? Clock::time_point::max() : queue_.front().due; }

 private:
  struct Packet {
    Clock::time_point due;
    std::vector<char> bytes;
  };
  double share() { return static_cast<double>(random_() >> 11) * 0x1p-53; }

  int from_, to_;
  const Settings& s_;
  std::mt19937_64 random_;
  std::deque<Packet> queue_;
  Clock::time_point free_{};  // when the line has sent what it has
  unsigned full_ = 0;
};

/// Until B has ended; its exit code.
int carry(const Host& a, const Host& b, const Settings& s) {
  Wire there(a.tun, b.tun, s, s.seed), back(b.tun, a.tun, s, s.seed + 1);
  const auto begin = Clock::now();
  for (;;) {
    int status = 0;
    if (waitpid(b.pid, &status, WNOHANG) == b.pid)
      return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    const auto now = Clock::now();
    const auto wake = std::min({there.next(), back.next(), now + std::chrono::milliseconds(20)});
    const auto ns = std::max<std::int64_t>(0, std::chrono::nanoseconds(wake - now).count());
    const timespec limit{0, static_cast<long>(ns)};
    std::array<pollfd, 2> ready{{{a.tun, POLLIN, 0}, {b.tun, POLLIN, 0}}};
    ppoll(ready.data(), ready.size(), &limit, nullptr);
    const auto woken = Clock::now();
    const double t = Seconds(woken - begin).count();
    const bool cut = s.cut_after_s >= 0 && t >= s.cut_after_s && t < s.cut_after_s + s.cut_for_s;
    for (Wire* wire : {&there, &back}) {
      wire->take(woken, cut);
      wire->deliver(woken);
    }
  }
}

}  // namespace

int main(int argc, char** argv) {
  Settings s;
  if (!read_settings(argc, argv, s)) {
    std::fprintf(stderr,
                 "usage: lossy_link [--delay-ms D] [--jitter-ms J] [--loss SHARE] [--seed N] [--cut-after S "
                 "--cut-for S] [--rate-kbps R [--queue-ms Q]] -- PROGRAM_A ... --- PROGRAM_B ...\n");
    return 2;
  }
  const Host a = start_host("10.77.0.1", s.a.data());
  const Host b = a.tun < 0 ? Host{} : start_host("10.77.0.2", s.b.data());
  int code = kSkip;
  if (a.tun >= 0 && b.tun >= 0 && write(a.line, "g", 1) == 1 && write(b.line, "g", 1) == 1) code = carry(a, b, s);
  for (const Host& h : {a, b})
    if (h.pid > 0) kill(h.pid, SIGTERM);
  int status = 0;
  if (a.pid > 0) waitpid(a.pid, &status, 0);
  return code;
}
