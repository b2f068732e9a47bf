#include "hal/linux/grab/grab_session.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <new>

#include "hal/linux/open_error.hpp"

namespace sinew::hal {
namespace {

using grab::Hello;

constexpr std::string_view kEnding = ".grab";
constexpr std::size_t kMostPeers = 64;
constexpr std::uint32_t kSessionItself = 0xFFFFFFFFu;  // in View::claimed
constexpr auto kLookAtLeftViews = std::chrono::milliseconds(20);

Error refused(const char* where, const std::string& what, std::string& why) {
  const int error = errno;
  why = what + ": " + errno_text(error);
  return {error == EACCES || error == EPERM ? Errc::denied : Errc::io, where, error};
}

/// A memory that nobody can shrink under the eyes of another. Its pages come when they are written.
int new_memory() {
  const int fd = ::memfd_create("sinew-grab", MFD_CLOEXEC | MFD_ALLOW_SEALING);
  if (fd < 0) return -1;
  if (::ftruncate(fd, static_cast<off_t>(grab::kMemoryBytes)) == 0 &&
      ::fcntl(fd, F_ADD_SEALS, F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_SEAL) == 0)
    return fd;
  const int error = errno;
  ::close(fd);
  errno = error;
  return -1;
}

int listening_socket(const std::string& path) {
  sockaddr_un at{};
  at.sun_family = AF_UNIX;
  std::copy(path.begin(), path.end(), at.sun_path);
  const int fd = ::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (fd < 0) return -1;
  ::unlink(path.c_str());  // left by a session that was killed: we hold its lock
  if (::bind(fd, reinterpret_cast<const sockaddr*>(&at), sizeof at) == 0 && ::listen(fd, 16) == 0) return fd;
  const int error = errno;
  ::close(fd);
  errno = error;
  return -1;
}

bool send_welcome(int fd, const grab::Welcome& welcome, int memory) {
  grab::Welcome text = welcome;
  iovec part{&text, sizeof text};
  alignas(cmsghdr) char control[CMSG_SPACE(sizeof(int))] = {};
  msghdr message{};
  message.msg_iov = &part, message.msg_iovlen = 1;
  if (welcome.number != 0) {
    message.msg_control = control, message.msg_controllen = sizeof control;
    cmsghdr* head = CMSG_FIRSTHDR(&message);
    head->cmsg_level = SOL_SOCKET, head->cmsg_type = SCM_RIGHTS, head->cmsg_len = CMSG_LEN(sizeof(int));
    std::memcpy(CMSG_DATA(head), &memory, sizeof memory);
  }
  return ::sendmsg(fd, &message, MSG_NOSIGNAL | MSG_DONTWAIT) == static_cast<ssize_t>(sizeof text);
}

}  // namespace

bool is_grab_name(std::string_view name) {
  return !name.empty() && name.size() <= 40 && name.front() != '.' && std::all_of(name.begin(), name.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-' ||
           c == '.' || c == '+';
  });
}

Result<std::string> grab_socket_path(const std::string& name, std::string& why) {
  if (!is_grab_name(name)) {
    why = "'" + name + "' is no name of a grabbed program: letters, digits, _, ., + and -, at most 40";
    return Error{Errc::bad_argument, "name of a grabbed program"};
  }
  std::string folder;
  if (const auto ok = run_dir(folder); !ok) {
    why = folder + ": " + ok.error().where;
    return ok.error();
  }
  std::string path = folder + "/" + name + std::string(kEnding);
  if (path.size() >= sizeof sockaddr_un::sun_path) {
    why = path + ": longer than a socket's path may be";
    return Error{Errc::bad_argument, "a socket's path"};
  }
  return path;
}

std::vector<std::string> grab_sessions() {
  std::vector<std::string> names;
  std::string folder;
  if (!run_dir(folder)) return names;
  std::error_code ignored;
  for (const auto& entry : std::filesystem::directory_iterator(folder, ignored)) {
    std::string name = entry.path().filename().string();
    if (!name.ends_with(kEnding)) continue;
    name.resize(name.size() - kEnding.size());
    if (is_grab_name(name) && FileLock::holder(entry.path().string() + ".lock")) names.push_back(std::move(name));
  }
  std::sort(names.begin(), names.end());
  return names;
}

Result<std::unique_ptr<GrabSession>> GrabSession::open(const std::string& name, std::string& why) {
  auto path = grab_socket_path(name, why);
  if (!path) return path.error();
  std::unique_ptr<GrabSession> session(new GrabSession);
  session->path_ = std::move(*path);
  auto lock = FileLock::take(session->path_ + ".lock");
  if (!lock) {
    why = lock.error().code == Errc::busy
              ? "a program is grabbed as '" + name + "' already (process " + std::to_string(lock.error().detail) +
                    "): choose another --name"
              : session->path_ + ".lock: " + errno_text(static_cast<int>(lock.error().detail));
    return lock.error();
  }
  session->lock_ = std::move(*lock);
  session->memory_ = new_memory();
  if (session->memory_ < 0) return refused("grab memory", "no memory to share", why);
  void* at = ::mmap(nullptr, grab::kPicturesAt, PROT_READ | PROT_WRITE, MAP_SHARED, session->memory_, 0);
  if (at == MAP_FAILED) return refused("grab memory", "the memory to share cannot be mapped", why);
  session->head_ = new (at) grab::Head{};
  session->head_->magic = grab::kMagic, session->head_->version = grab::kVersion;
  session->listener_ = listening_socket(session->path_);
  if (session->listener_ < 0) return refused("grab socket", session->path_, why);
  return session;
}

GrabSession::~GrabSession() {
  titles_.reset();  // it writes into the memory
  if (listener_ >= 0) {
    ::unlink(path_.c_str());
    ::close(listener_);
  }
  for (const Peer& peer : peers_) ::close(peer.fd);
  if (head_) ::munmap(head_, grab::kPicturesAt);
  if (memory_ >= 0) ::close(memory_);
}

Status GrabSession::serve(Duration patience) {
  std::vector<pollfd> waiting{{listener_, static_cast<short>(peers_.size() < kMostPeers ? POLLIN : 0), 0}};
  for (const Peer& peer : peers_) waiting.push_back({peer.fd, POLLIN, 0});
  if (!left_.empty()) patience = std::min<Duration>(patience, kLookAtLeftViews);
  const auto ms = std::chrono::ceil<std::chrono::milliseconds>(std::max(patience, Duration{0})).count();
  const int ready = ::poll(waiting.data(), waiting.size(), static_cast<int>(std::min<std::int64_t>(ms, 3'600'000)));
  if (ready < 0 && errno != EINTR) return Error{Errc::io, "poll", errno};
  if (ready > 0) {
    if ((waiting[0].revents & (POLLERR | POLLNVAL)) != 0) return Error{Errc::io, "grab socket"};
    std::vector<Peer> stay;
    for (std::size_t i = 0; i < peers_.size(); ++i) {
      if (waiting[i + 1].revents == 0 || introduced(peers_[i]))
        stay.push_back(peers_[i]);
      else
        gone(peers_[i]);
    }
    peers_ = std::move(stay);
    if ((waiting[0].revents & POLLIN) != 0) accept_one();
  }
  free_left_views();
  return {};
}

std::size_t GrabSession::programs() const {
  return static_cast<std::size_t>(std::count_if(
      peers_.begin(), peers_.end(), [](const Peer& p) { return p.welcome && p.role == Hello::Role::program; }));
}

std::size_t GrabSession::readers() const {
  return static_cast<std::size_t>(std::count_if(
      peers_.begin(), peers_.end(), [](const Peer& p) { return p.welcome && p.role == Hello::Role::reader; }));
}

void GrabSession::accept_one() {
  const int fd = ::accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK);
  if (fd < 0) return;
  Peer peer;
  peer.fd = fd;
  peers_.push_back(peer);
}

/// Reads what a peer says: its Hello, once. More than that, or its end, and it goes.
bool GrabSession::introduced(Peer& peer) {
  Hello hello{};
  const ssize_t n = ::recv(peer.fd, &hello, sizeof hello, MSG_DONTWAIT | MSG_TRUNC);
  if (n < 0) return errno == EAGAIN || errno == EINTR;
  grab::Welcome welcome{grab::kMagic, grab::kVersion, 0, grab::kNoNumber};
  const bool known = hello.role >= static_cast<std::uint32_t>(Hello::Role::program) &&
                     hello.role <= static_cast<std::uint32_t>(Hello::Role::watcher);
  if (n != static_cast<ssize_t>(sizeof hello) || peer.welcome || hello.magic != grab::kMagic) return false;
  if (hello.version != grab::kVersion || !known) {
    static_cast<void>(send_welcome(peer.fd, welcome, -1));  // so that it knows why
    return false;
  }
  peer.role = static_cast<Hello::Role>(hello.role);
  peer.number = next_number_;
  next_number_ = next_number_ + 1 == kSessionItself ? 1 : next_number_ + 1;
  if (peer.role == Hello::Role::reader) {
    for (std::uint32_t v = 0; v < grab::kMaxViews && peer.view == grab::kNoNumber; ++v)
      if (head_->view[v].reader.load(std::memory_order_relaxed) == 0) peer.view = v;
    if (peer.view != grab::kNoNumber) {
      head_->view[peer.view].reader.store(peer.number, std::memory_order_relaxed);
      head_->views.fetch_or(1u << peer.view, std::memory_order_release);  // partner: the program's acquire
    }
  }
  peer.welcome = true;
  welcome.number = peer.number, welcome.view = peer.view;
  if (peer.role == Hello::Role::program) {
    ++programs_seen_;
    if (!titles_) titles_ = std::make_unique<GrabTitles>(*head_);
  }
  return send_welcome(peer.fd, welcome, memory_);
}

void GrabSession::gone(const Peer& peer) {
  ::close(peer.fd);
  if (!peer.welcome) return;
  if (peer.role == Hello::Role::program) free_windows(peer.number);
  if (peer.view != grab::kNoNumber) {
    head_->views.fetch_and(~(1u << peer.view), std::memory_order_release);
    left_.push_back(peer.view);
  }
}

void GrabSession::free_windows(std::uint32_t process) {
  for (grab::Window& window : head_->window) {
    if (window.process.load(std::memory_order_acquire) != process) continue;
    window.ready.store(0, std::memory_order_relaxed);
    window.process.store(0, std::memory_order_release);
  }
  // What it had begun for a reader will not be finished: the reader is answered by another window.
  for (grab::View& view : head_->view) {
    std::uint32_t claimed = process;
    view.claimed.compare_exchange_strong(claimed, 0, std::memory_order_release);
  }
  head_->windows.fetch_add(1, std::memory_order_release);
}

/// False: a program is writing there.
bool GrabSession::free_view(std::uint32_t v) {
  grab::View& view = head_->view[v];
  std::uint32_t nobody = 0;
  if (!view.claimed.compare_exchange_strong(nobody, kSessionItself, std::memory_order_acquire)) return false;
  view.asked.store(0, std::memory_order_relaxed), view.answered.store(0, std::memory_order_relaxed);
  view.bound.store(0, std::memory_order_relaxed);
  for (auto& request : view.requests) request = {};
  for (auto& answer : view.answers) answer = {};
  for (std::uint32_t slot = 0; slot < grab::kSlots; ++slot)  // a kernel that cannot keeps the pages for the next reader
    static_cast<void>(::fallocate(memory_, FALLOC_FL_PUNCH_HOLE | FALLOC_FL_KEEP_SIZE,
                                  static_cast<off_t>(grab::slot_at(v, slot)), static_cast<off_t>(grab::kSlotBytes)));
  view.claimed.store(0, std::memory_order_release);
  view.reader.store(0, std::memory_order_release);
  return true;
}

void GrabSession::free_left_views() {
  std::erase_if(left_, [this](std::uint32_t view) { return free_view(view); });
}

}  // namespace sinew::hal
