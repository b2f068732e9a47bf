#include "hal/linux/grab/grab_view.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>

#include "hal/linux/grab/grab_session.hpp"
#include "hal/linux/open_error.hpp"
#include "hal/linux/shared_memory.hpp"

namespace sinew::hal {
namespace {

constexpr std::size_t kMapUnit = 65536;  // a multiple of every kernel's pages
constexpr int kPatienceMs = 2000;

struct Connected {
  int socket = -1, memory = -1;
  grab::Head* head = nullptr;
  std::uint32_t view = grab::kNoNumber;
};

void close_all(const Connected& c) {
  if (c.head) ::munmap(c.head, grab::kPicturesAt);
  if (c.memory >= 0) ::close(c.memory);
  if (c.socket >= 0) ::close(c.socket);
}

int socket_of_session(const std::string& path) {
  sockaddr_un to{};
  to.sun_family = AF_UNIX;
  std::copy(path.begin(), path.end(), to.sun_path);
  const int fd = ::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0);
  if (fd < 0) return -1;
  if (::connect(fd, reinterpret_cast<const sockaddr*>(&to), sizeof to) == 0) return fd;
  const int error = errno;
  ::close(fd);
  errno = error;
  return -1;
}

/// The answer to our Hello; false: none came.
bool welcomed(int socket, grab::Welcome& welcome, int& memory) {
  pollfd ready{socket, POLLIN, 0};
  if (::poll(&ready, 1, kPatienceMs) != 1) return false;
  iovec part{&welcome, sizeof welcome};
  alignas(cmsghdr) char control[CMSG_SPACE(sizeof(int))] = {};
  msghdr message{};
  message.msg_iov = &part, message.msg_iovlen = 1;
  message.msg_control = control, message.msg_controllen = sizeof control;
  const ssize_t n = ::recvmsg(socket, &message, MSG_CMSG_CLOEXEC | MSG_DONTWAIT);
  for (cmsghdr* c = CMSG_FIRSTHDR(&message); n >= 0 && c; c = CMSG_NXTHDR(&message, c))
    if (c->cmsg_level == SOL_SOCKET && c->cmsg_type == SCM_RIGHTS) std::memcpy(&memory, CMSG_DATA(c), sizeof memory);
  return n == static_cast<ssize_t>(sizeof welcome) && welcome.magic == grab::kMagic;
}

grab::Head* mapped_head(int memory) {
  struct stat info {};
  const int seals = ::fcntl(memory, F_GET_SEALS);
  if (seals < 0 || (seals & F_SEAL_SHRINK) == 0 || ::fstat(memory, &info) != 0 ||
      static_cast<std::uint64_t>(info.st_size) < grab::kMemoryBytes)
    return nullptr;
  void* at = ::mmap(nullptr, grab::kPicturesAt, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_POPULATE, memory, 0);
  return at == MAP_FAILED ? nullptr : static_cast<grab::Head*>(at);
}

Result<Connected> connected(const std::string& session, grab::Hello::Role role, std::string& why) {
  const auto path = grab_socket_path(session, why);
  if (!path) return path.error();
  Connected c;
  c.socket = socket_of_session(*path);
  if (c.socket < 0) {
    const int error = errno;
    const bool none = error == ENOENT || error == ECONNREFUSED;
    why = none ? "no program is grabbed as '" + session + "': start it with `sinew grab --name " + session + " PROGRAM`"
               : *path + ": " + errno_text(error);
    return Error{none ? Errc::not_found : Errc::io, "grab session", error};
  }
  grab::Hello hello{
      grab::kMagic, grab::kVersion, static_cast<std::uint32_t>(role), static_cast<std::uint32_t>(::getpid()), {}};
  grab::Welcome welcome{};
  if (::send(c.socket, &hello, sizeof hello, MSG_NOSIGNAL) != static_cast<ssize_t>(sizeof hello) ||
      !welcomed(c.socket, welcome, c.memory)) {
    close_all(c);
    why = "the session '" + session + "' does not answer";
    return Error{Errc::io, "grab session"};
  }
  if (welcome.version != grab::kVersion || welcome.number == 0) {
    close_all(c);
    why = "the session '" + session + "' is one of another version of sinew";
    return Error{Errc::not_supported, "grab session", welcome.version};
  }
  if (role == grab::Hello::Role::reader && welcome.view >= grab::kMaxViews) {
    close_all(c);
    why = "the session '" + session + "' has " + std::to_string(grab::kMaxViews) + " readers already";
    return Error{Errc::busy, "grab session"};
  }
  c.view = welcome.view;
  c.head = mapped_head(c.memory);
  if (!c.head) {
    close_all(c);
    why = "the session '" + session + "' gave no memory that can be read";
    return Error{Errc::io, "grab memory"};
  }
  return c;
}

const char* api_name(std::uint32_t api) {
  switch (static_cast<grab::Api>(api)) {
    case grab::Api::glx:
      return "OpenGL (GLX)";
    case grab::Api::egl:
      return "OpenGL (EGL)";
    case grab::Api::vulkan:
      return "Vulkan";
    case grab::Api::none:
      break;
  }
  return "unknown";
}

/// A title's bytes, copied whole, with a final 0. False: the window has none.
bool read_title(const grab::Head& head, std::uint32_t number, std::array<char, 4 * grab::kTitleWords>& text) noexcept {
  const grab::Window& window = head.window[number];
  const grab::Title& title = head.title[number];
  constexpr int kTries = 4;
  for (int i = 0; i < kTries; ++i) {
    const std::uint32_t writes = title.writes.load(std::memory_order_acquire);
    const bool is_of_it =
        title.process.load(std::memory_order_acquire) == window.process.load(std::memory_order_relaxed) &&
        title.x11.load(std::memory_order_acquire) == window.x11;
    for (std::uint32_t w = 0; w < grab::kTitleWords; ++w) {
      const std::uint32_t word = title.text[w].load(std::memory_order_acquire);
      std::memcpy(text.data() + 4 * w, &word, sizeof word);
    }
    if (writes % 2 != 0 || title.writes.load(std::memory_order_relaxed) != writes) continue;
    text.back() = 0;
    return is_of_it && text.front() != 0;
  }
  return false;
}

/// The bytes of one character of UTF-8 at the beginning of `text`; 0: it is none.
std::size_t utf8_bytes(std::string_view text) noexcept {
  const auto first = static_cast<unsigned char>(text[0]);
  if (first < 0x80) return 1;
  const std::size_t count = first >= 0xC2 && first < 0xE0   ? 2
                            : first >= 0xE0 && first < 0xF0 ? 3
                            : first >= 0xF0 && first < 0xF5 ? 4
                                                            : 0;
  if (count == 0 || text.size() < count) return 0;
  for (std::size_t i = 1; i < count; ++i)
    if ((static_cast<unsigned char>(text[i]) & 0xC0) != 0x80) return 0;
  const auto second = static_cast<unsigned char>(text[1]);
  if ((first == 0xE0 && second < 0xA0) || (first == 0xED && second > 0x9F) || (first == 0xF0 && second < 0x90) ||
      (first == 0xF4 && second > 0x8F))
    return 0;  // longer than needed, half of a pair, beyond the last
  return count;
}

}  // namespace

std::string clean_title(std::string_view text) {
  std::string all;
  while (!text.empty()) {
    const std::size_t bytes = utf8_bytes(text);
    const auto first = static_cast<unsigned char>(text[0]);
    const bool is_control =
        first < 0x20 || first == 0x7F || (first == 0xC2 && bytes == 2 && static_cast<unsigned char>(text[1]) < 0xA0);
    all += bytes == 0 || is_control ? "?" : text.substr(0, bytes);
    text.remove_prefix(std::max<std::size_t>(bytes, 1));
  }
  return all;
}

TitledWindow window_titled(const grab::Head& head, std::string_view title) noexcept {
  TitledWindow found;
  std::array<char, 4 * grab::kTitleWords> text;
  for (std::uint32_t i = 0; i < grab::kMaxWindows; ++i) {
    const grab::Window& w = head.window[i];
    if (w.process.load(std::memory_order_acquire) == 0 || w.ready.load(std::memory_order_acquire) == 0) continue;
    if (!read_title(head, i, text)) continue;
    const std::string_view has(text.data());
    if (has == title) return {i, 1};
    if (has.find(title) == std::string_view::npos) continue;
    found = {found.count == 0 ? i : grab::kNoNumber, found.count + 1};
  }
  return found;
}

std::string titles_of(const std::vector<GrabWindow>& windows) {
  std::string all;
  for (const GrabWindow& w : windows)
    if (!w.title.empty()) all += (all.empty() ? "'" : ", '") + w.title + "'";
  return all.empty() ? "none" : all;
}

const char* words_of(grab::AnswerStatus status) {
  switch (status) {
    case grab::AnswerStatus::ok:
      return "";
    case grab::AnswerStatus::too_large:
      return "the region is larger than a picture may be (3840x2400)";
    case grab::AnswerStatus::outside:
      return "nothing of the region is inside of the window";
    case grab::AnswerStatus::not_readable:
      return "the window's pixel format, or its swapchain, cannot be read";
    case grab::AnswerStatus::lost:
      return "the program lost a picture while it was read";
  }
  return "";
}

GrabPicture checked_picture(const grab::Answer& a, std::uint32_t number) noexcept {
  GrabPicture p;
  p.number = number;
  p.window = a.window, p.swap = a.swap, p.shown = Time{a.shown.get()}, p.there = Time{a.there.get()};
  p.window_width = a.window_width, p.window_height = a.window_height;
  p.status = a.status <= static_cast<std::uint32_t>(grab::AnswerStatus::lost)
                 ? static_cast<grab::AnswerStatus>(a.status)
                 : grab::AnswerStatus::lost;
  if (p.status != grab::AnswerStatus::ok) return p;
  const bool inside = a.x >= 0 && a.y >= 0 && a.width > 0 && a.height > 0 && a.width <= grab::kMaxSide &&
                      a.height <= grab::kMaxSide && static_cast<std::uint32_t>(a.x) <= grab::kMaxSide &&
                      static_cast<std::uint32_t>(a.y) <= grab::kMaxSide;
  const bool fits =
      inside && a.stride >= a.width * grab::kBytesPerPixel && std::uint64_t{a.stride} * a.height <= grab::kSlotBytes;
  if (!fits || a.order > static_cast<std::uint32_t>(grab::PixelOrder::bgrx)) {
    p.status = grab::AnswerStatus::lost;
    return p;
  }
  p.x = a.x, p.y = a.y, p.width = a.width, p.height = a.height, p.stride = a.stride;
  p.order = static_cast<grab::PixelOrder>(a.order), p.bottom_up = a.bottom_up != 0;
  return p;
}

std::vector<GrabWindow> windows_of(const grab::Head& head) {
  std::vector<GrabWindow> all;
  for (std::uint32_t i = 0; i < grab::kMaxWindows; ++i) {
    const grab::Window& w = head.window[i];
    if (w.process.load(std::memory_order_acquire) == 0 || w.ready.load(std::memory_order_acquire) == 0) continue;
    GrabWindow out;
    out.number = i, out.api = api_name(w.api), out.pid = w.pid;
    const char* end = std::find(w.program, w.program + grab::kNameBytes, '\0');
    out.program.assign(w.program, end);
    for (char& c : out.program)
      if (static_cast<unsigned char>(c) < 0x20 || static_cast<unsigned char>(c) > 0x7E) c = '?';
    out.width = w.width.load(std::memory_order_relaxed), out.height = w.height.load(std::memory_order_relaxed);
    out.pictures = w.swaps.load(std::memory_order_relaxed);
    out.id = std::uint64_t{w.id[1]} << 32 | w.id[0];
    if (std::array<char, 4 * grab::kTitleWords> title; read_title(head, i, title))
      out.title = clean_title(title.data());
    all.push_back(std::move(out));
  }
  return all;
}

Result<std::vector<GrabWindow>> grab_windows(const std::string& session, std::string& why) {
  const auto c = connected(session, grab::Hello::Role::watcher, why);
  if (!c) return c.error();
  auto all = windows_of(*c->head);
  close_all(*c);
  return all;
}

Result<std::unique_ptr<GrabView>> GrabView::open(const std::string& session, std::string& why) {
  const auto c = connected(session, grab::Hello::Role::reader, why);
  if (!c) return c.error();
  return std::unique_ptr<GrabView>(new GrabView(c->socket, c->memory, c->head, c->view));
}

GrabView::~GrabView() {
  for (const Mapping& m : mappings_)
    if (m.at) ::munmap(m.at, m.bytes);
  close_all({socket_, memory_, head_, view_});
}

bool GrabView::ask(std::uint32_t window, const GrabRegion& region, Time due) noexcept {
  if (open_asks() >= grab::kSlots) return false;
  grab::View& view = head_->view[view_];
  grab::Request& request = view.requests[asked_ % grab::kSlots];
  request.due.set(due.ns);
  request.window = window, request.x = region.x, request.y = region.y;
  request.width = region.width, request.height = region.height;
  view.asked.store(++asked_, std::memory_order_release);  // partner: the program's acquire
  return true;
}

void GrabView::point_at(std::uint32_t window) noexcept {
  grab::View& view = head_->view[view_];
  for (std::uint32_t n = taken_; n != asked_; ++n)  // the program may look at it now: one word, the old one or the new
    std::atomic_ref<std::uint32_t>(view.requests[n % grab::kSlots].window).store(window, std::memory_order_relaxed);
}

TitledWindow GrabView::titled(std::string_view title) const noexcept { return window_titled(*head_, title); }

std::vector<GrabWindow> GrabView::windows() const { return windows_of(*head_); }

const std::uint8_t* GrabView::mapped(std::uint32_t slot, std::size_t bytes) noexcept {
  Mapping& m = mappings_[slot];
  if (m.bytes >= bytes) return m.at;
  if (m.at) ::munmap(m.at, m.bytes);
  m = {};
  const std::size_t rounded = (bytes + kMapUnit - 1) / kMapUnit * kMapUnit;
  void* at = ::mmap(nullptr, rounded, PROT_READ, MAP_SHARED | MAP_POPULATE, memory_,
                    static_cast<off_t>(grab::slot_at(view_, slot)));
  if (at == MAP_FAILED) return nullptr;
  m.at = static_cast<std::uint8_t*>(at), m.bytes = rounded;
  return m.at;
}

std::optional<GrabPicture> GrabView::oldest() noexcept {
  if (!has_come()) return std::nullopt;
  const std::uint32_t number = taken_;
  const grab::Answer answer = head_->view[view_].answers[number % grab::kSlots];
  GrabPicture picture = checked_picture(answer, number);
  if (picture.status != grab::AnswerStatus::ok) return picture;
  picture.pixels = mapped(number % grab::kSlots, std::size_t{picture.stride} * picture.height);
  if (!picture.pixels) picture.status = grab::AnswerStatus::too_large;
  return picture;
}

bool GrabView::has_come() const noexcept {
  // What the program wrote counts only as far as it was asked.
  const std::uint32_t came = head_->view[view_].answered.load(std::memory_order_acquire) - taken_.load();
  return came != 0 && came <= grab::kSlots;
}

void GrabView::wait(Time deadline) const noexcept {
  const grab::Word& word = head_->view[view_].answered;
  const std::uint32_t seen = word.load(std::memory_order_acquire);
  if (!has_come()) wait_shared(word, seen, deadline);
}

bool GrabView::is_connected() const noexcept {
  char byte = 0;
  const ssize_t n = ::recv(socket_, &byte, 1, MSG_DONTWAIT | MSG_PEEK);
  return n > 0 || (n < 0 && (errno == EAGAIN || errno == EINTR));
}

}  // namespace sinew::hal
