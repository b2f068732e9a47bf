#include "hal/linux/grab/grab_titles.hpp"

#include <dlfcn.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <condition_variable>
#include <cstdlib>
#include <cstring>
#include <mutex>
#include <string>
#include <thread>
#include <type_traits>
#include <vector>

#include "hal/linux/grab/grab_view.hpp"
#include "hal/linux/shared_memory.hpp"

namespace sinew::hal {
namespace {

using namespace std::chrono_literals;

constexpr auto kLookForTitlesEvery = 250ms;
constexpr auto kPatienceWithTheServer = 500ms;
constexpr int kMostParents = 8;
constexpr std::uint32_t kTitleBytes = 4 * grab::kTitleWords;
// X11's protocol: predefined atoms.
constexpr std::uint32_t kAtomString = 31, kAtomWmName = 39, kAnyType = 0;

/// The functions of libxcb that are used, without its headers: nothing of it is needed to build or to run.
struct Xcb {
  struct Cookie {
    unsigned sequence;
  };
  void* (*connect)(const char*, int*);
  int (*has_error)(void*);
  void (*disconnect)(void*);
  int (*descriptor)(void*);
  Cookie (*intern_atom)(void*, std::uint8_t, std::uint16_t, const char*);
  void* (*intern_atom_reply)(void*, Cookie, void**);
  Cookie (*get_property)(void*, std::uint8_t, std::uint32_t, std::uint32_t, std::uint32_t, std::uint32_t,
                         std::uint32_t);
  void* (*get_property_reply)(void*, Cookie, void**);
  Cookie (*query_tree)(void*, std::uint32_t);
  void* (*query_tree_reply)(void*, Cookie, void**);

  /// False: this machine has none.
  bool load() {
    void* library = ::dlopen("libxcb.so.1", RTLD_NOW | RTLD_LOCAL);
    if (!library) return false;
    bool all = true;
    const auto find = [&](auto& function, const char* name) {
      function = reinterpret_cast<std::remove_reference_t<decltype(function)>>(::dlsym(library, name));
      all = all && function;
    };
    find(connect, "xcb_connect");
    find(has_error, "xcb_connection_has_error");
    find(disconnect, "xcb_disconnect");
    find(descriptor, "xcb_get_file_descriptor");
    find(intern_atom, "xcb_intern_atom");
    find(intern_atom_reply, "xcb_intern_atom_reply");
    find(get_property, "xcb_get_property");
    find(get_property_reply, "xcb_get_property_reply");
    find(query_tree, "xcb_query_tree");
    find(query_tree_reply, "xcb_query_tree_reply");
    return all;
  }
};

/// A reply as it came from the server (X11 protocol, 8-byte header and what follows); freed at its end.
class Reply {
 public:
  explicit Reply(void* at) : at_(at) {}
  ~Reply() { std::free(at_); }
  Reply(const Reply&) = delete;
  Reply& operator=(const Reply&) = delete;
  explicit operator bool() const { return at_ != nullptr; }
  std::uint32_t word(std::size_t at) const {
    std::uint32_t value = 0;
    std::memcpy(&value, static_cast<const char*>(at_) + at, sizeof value);
    return value;
  }
  std::uint8_t byte(std::size_t at) const { return static_cast<const std::uint8_t*>(at_)[at]; }
  const char* bytes(std::size_t at) const { return static_cast<const char*>(at_) + at; }

 private:
  void* at_;
};

/// WM_NAME of type STRING is Latin-1.
std::string utf8_of_latin1(std::string_view text) {
  std::string all;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte < 0x80) {
      all += c;
    } else {
      all += static_cast<char>(0xC0 | byte >> 6);
      all += static_cast<char>(0x80 | (byte & 0x3F));
    }
  }
  return all;
}

/// One connection to the display server. Errors of requests (a window that is gone) are replies that are missing.
class Display {
 public:
  explicit Display(const Xcb& xcb) : xcb_(xcb), connection_(xcb.connect(nullptr, nullptr)) {
    if (!works()) return;
    net_wm_name_ = atom("_NET_WM_NAME");
  }
  ~Display() { xcb_.disconnect(connection_); }
  Display(const Display&) = delete;
  Display& operator=(const Display&) = delete;
  bool works() const { return connection_ && xcb_.has_error(connection_) == 0; }
  int descriptor() const { return xcb_.descriptor(connection_); }

  /// Of the window or of the nearest one around it that has a title: programs draw into a child of what has the title
  /// bar. Empty: there is none.
  std::string title_of(std::uint32_t window) const {
    for (int i = 0; i < kMostParents && window != 0; ++i) {
      std::string title = net_wm_name_ != 0 ? property(window, net_wm_name_) : std::string();
      if (title.empty()) title = property(window, kAtomWmName);
      if (!title.empty()) return title;
      const Reply tree(xcb_.query_tree_reply(connection_, xcb_.query_tree(connection_, window), nullptr));
      if (!tree) return {};
      const std::uint32_t root = tree.word(8), parent = tree.word(12);
      window = parent == root ? 0 : parent;
    }
    return {};
  }

 private:
  std::uint32_t atom(const char* name) const {
    const auto asked = xcb_.intern_atom(connection_, 0, static_cast<std::uint16_t>(std::strlen(name)), name);
    const Reply reply(xcb_.intern_atom_reply(connection_, asked, nullptr));
    return reply ? reply.word(8) : 0;
  }
  std::string property(std::uint32_t window, std::uint32_t name) const {
    const auto asked = xcb_.get_property(connection_, 0, window, name, kAnyType, 0, grab::kTitleWords);
    const Reply reply(xcb_.get_property_reply(connection_, asked, nullptr));
    constexpr std::size_t kFormat = 1, kType = 8, kLength = 16, kValue = 32;
    if (!reply || reply.byte(kFormat) != 8 || reply.word(kLength) > kTitleBytes) return {};
    const std::string_view value(reply.bytes(kValue), reply.word(kLength));
    return reply.word(kType) == kAtomString ? utf8_of_latin1(value) : std::string(value);
  }

  const Xcb& xcb_;
  void* connection_;
  std::uint32_t net_wm_name_ = 0;
};

}  // namespace

bool write_grab_title(grab::Head& head, std::uint32_t window, std::uint32_t process, std::uint32_t x11,
                      std::string_view text) {
  grab::Title& title = head.title[window];
  const std::string clean = clean_title(text.substr(0, kTitleBytes - 1));
  std::array<std::uint32_t, grab::kTitleWords> words{};
  std::memcpy(words.data(), clean.data(), std::min<std::size_t>(clean.size(), kTitleBytes - 1));
  bool same =
      title.process.load(std::memory_order_relaxed) == process && title.x11.load(std::memory_order_relaxed) == x11;
  for (std::size_t i = 0; i < words.size(); ++i) same &= title.text[i].load(std::memory_order_relaxed) == words[i];
  if (same) return false;
  const std::uint32_t writes = title.writes.load(std::memory_order_relaxed);
  title.writes.store(writes + 1, std::memory_order_relaxed);
  title.process.store(process, std::memory_order_release);  // these stay behind the odd number: partner: read_title()
  title.x11.store(x11, std::memory_order_release);
  for (std::size_t i = 0; i < words.size(); ++i) title.text[i].store(words[i], std::memory_order_release);
  title.writes.store(writes + 2, std::memory_order_release);
  head.windows.fetch_add(1, std::memory_order_release);
  wake_shared(head.windows);
  return true;
}

/// What the thread and its owner share; the thread may outlive the owner when the display server does not answer.
struct GrabTitles::Shared {
  std::mutex mutex;
  std::condition_variable changed;
  grab::Head* head = nullptr;  // null: stop
  int descriptor = -1;         // of the display's connection while there is one
  bool ended = false;

  struct Asked {
    std::uint32_t window, process, x11;
  };
  std::vector<Asked> windows() {
    std::vector<Asked> all;
    for (std::uint32_t i = 0; i < grab::kMaxWindows; ++i) {
      const grab::Window& w = head->window[i];
      const std::uint32_t process = w.process.load(std::memory_order_acquire);
      if (process != 0 && w.ready.load(std::memory_order_acquire) != 0 && w.x11 != 0)
        all.push_back({i, process, w.x11});
    }
    return all;
  }
  void run();
};

void GrabTitles::Shared::run() {
  static Xcb xcb;
  static const bool loaded = xcb.load();
  std::unique_ptr<Display> display;
  std::unique_lock lock(mutex);
  while (head && loaded) {
    const std::vector<Asked> asked = windows();
    if (!asked.empty() && (!display || !display->works())) {
      descriptor = -1;  // the next connection may have its number before it is a connection
      lock.unlock();
      display.reset();
      display = std::make_unique<Display>(xcb);
      lock.lock();
    }
    descriptor = display && display->works() ? display->descriptor() : -1;
    for (const Asked& a : asked) {
      if (!head || descriptor < 0) break;
      lock.unlock();
      const std::string title = display->title_of(a.x11);
      lock.lock();
      if (head && display->works()) write_grab_title(*head, a.window, a.process, a.x11, title);
    }
    if (head) changed.wait_for(lock, kLookForTitlesEvery);
  }
  descriptor = -1;
  ended = true;
  changed.notify_all();
}

GrabTitles::GrabTitles(grab::Head& head) : shared_(std::make_shared<Shared>()) {
  shared_->head = &head;
  std::thread([shared = shared_] { shared->run(); }).detach();
}

GrabTitles::~GrabTitles() {
  std::unique_lock lock(shared_->mutex);
  shared_->head = nullptr;
  if (shared_->descriptor >= 0) ::shutdown(shared_->descriptor, SHUT_RDWR);  // a request that waits ends
  shared_->changed.notify_all();
  shared_->changed.wait_for(lock, kPatienceWithTheServer, [this] { return shared_->ended; });
}

}  // namespace sinew::hal
