#include "grab/preload/gl_pictures.hpp"

#include <pthread.h>

#include <cstddef>
#include <cstring>

namespace sinew::grab {
namespace {

// Names and numbers of OpenGL's registry; its headers are not needed for so few.
using Enum = unsigned;
using Int = int;
constexpr Enum kVersionString = 0x1F02, kReadBuffer = 0x0C02, kBack = 0x0405, kDoubleBuffer = 0x0C32;
constexpr Enum kPackSwapBytes = 0x0D00, kPackLsbFirst = 0x0D01, kPackRowLength = 0x0D02, kPackSkipRows = 0x0D03,
               kPackSkipPixels = 0x0D04, kPackAlignment = 0x0D05;
constexpr Enum kRgba = 0x1908, kBgra = 0x80E1, kUnsignedByte = 0x1401;
constexpr Enum kFramebuffer = 0x8D40, kReadFramebuffer = 0x8CA8, kFramebufferBinding = 0x8CA6,
               kReadFramebufferBinding = 0x8CAA;
constexpr Enum kPixelPackBuffer = 0x88EB, kPixelPackBufferBinding = 0x88ED, kStreamRead = 0x88E1, kMapReadBit = 1,
               kReadOnly = 0x88B8;

struct Functions {
  const unsigned char* (*get_string)(Enum);
  void (*get_integer)(Enum, Int*);
  void (*read_pixels)(Int, Int, Int, Int, Enum, Enum, void*);
  void (*pixel_store)(Enum, Int);
  void (*read_buffer)(Enum);                 // null in OpenGL ES 2
  void (*bind_framebuffer)(Enum, unsigned);  // null in old OpenGL, here and below
  void (*gen_buffers)(Int, unsigned*);
  void (*delete_buffers)(Int, const unsigned*);
  void (*bind_buffer)(Enum, unsigned);
  void (*buffer_data)(Enum, std::ptrdiff_t, const void*, Enum);
  void* (*map_buffer)(Enum, Enum);
  void* (*map_buffer_range)(Enum, std::ptrdiff_t, std::ptrdiff_t, unsigned);
  unsigned char (*unmap_buffer)(Enum);
  bool usable;
};

template <class F>
void find(const GlPlace& place, const char* name, F& function) noexcept {
  function = reinterpret_cast<F>(place.function(name));
}

/// Looked up once for each window system: with libglvnd, and with the drivers of Mesa and NVIDIA, the functions are the
/// same for all contexts.
const Functions& functions_of(const GlPlace& place) noexcept {
  static pthread_mutex_t mutex = PTHREAD_MUTEX_INITIALIZER;
  static Functions all[2];
  static bool found[2];
  const int which = place.api == Api::egl ? 1 : 0;
  pthread_mutex_lock(&mutex);
  Functions& f = all[which];
  if (!found[which]) {
    find(place, "glGetString", f.get_string);
    find(place, "glGetIntegerv", f.get_integer);
    find(place, "glReadPixels", f.read_pixels);
    find(place, "glPixelStorei", f.pixel_store);
    find(place, "glReadBuffer", f.read_buffer);
    find(place, "glBindFramebuffer", f.bind_framebuffer);
    find(place, "glGenBuffers", f.gen_buffers);
    find(place, "glDeleteBuffers", f.delete_buffers);
    find(place, "glBindBuffer", f.bind_buffer);
    find(place, "glBufferData", f.buffer_data);
    find(place, "glMapBuffer", f.map_buffer);
    find(place, "glMapBufferRange", f.map_buffer_range);
    find(place, "glUnmapBuffer", f.unmap_buffer);
    f.usable =
        f.get_string != nullptr && f.get_integer != nullptr && f.read_pixels != nullptr && f.pixel_store != nullptr;
    found[which] = true;
  }
  pthread_mutex_unlock(&mutex);
  return f;
}

/// What the current context is.
struct Context {
  bool es = false;
  int version = 0;  // 30 for 3.0
  bool has_read_framebuffer() const noexcept { return version >= 30; }
  bool has_framebuffer() const noexcept { return es ? version >= 20 : version >= 30; }
  bool has_pack_buffer() const noexcept { return es ? version >= 30 : version >= 21; }
  bool has_row_length() const noexcept { return !es || version >= 30; }
  bool has_read_buffer() const noexcept { return !es || version >= 30; }
};

/// "4.5 (Compatibility Profile) Mesa", "OpenGL ES 3.2 Mesa", "OpenGL ES-CM 1.1". Version 0: it is none of these.
Context context_of(const Functions& f) noexcept {
  Context c;
  const auto* text = reinterpret_cast<const char*>(f.get_string(kVersionString));
  if (text == nullptr) return c;
  c.es = std::strncmp(text, "OpenGL ES", 9) == 0;
  while (*text != 0 && (*text < '0' || *text > '9')) ++text;
  int major = 0;
  while (*text >= '0' && *text <= '9' && major < 1000) major = 10 * major + (*text++ - '0');
  const int minor = text[0] == '.' && text[1] >= '0' && text[1] <= '9' ? text[1] - '0' : 0;
  c.version = 10 * major + minor;
  return c;
}

/// Sets the context to read the back buffer into memory without gaps, and everything back at its end.
class ReadState {
 public:
  ReadState(const Functions& f, const Context& c) noexcept : f_(f), c_(c) {
    f_.get_integer(kPackAlignment, &alignment_);
    if (alignment_ != 4) f_.pixel_store(kPackAlignment, 4);
    if (c_.has_row_length())
      for (Kept& kept : kept_) {
        f_.get_integer(kept.name, &kept.value);
        if (kept.value != 0 && in_context(kept)) f_.pixel_store(kept.name, 0);
      }
    if (c_.has_pack_buffer() && f_.bind_buffer != nullptr) {
      f_.get_integer(kPixelPackBufferBinding, &pack_buffer_);
      if (pack_buffer_ != 0) f_.bind_buffer(kPixelPackBuffer, 0);
    }
    if (c_.has_framebuffer() && f_.bind_framebuffer != nullptr) {
      f_.get_integer(c_.has_read_framebuffer() ? kReadFramebufferBinding : kFramebufferBinding, &framebuffer_);
      if (framebuffer_ != 0) bind_framebuffer(0);
    }
    if (c_.has_read_buffer() && f_.read_buffer != nullptr) {
      f_.get_integer(kReadBuffer, &read_buffer_);
      Int is_double = 1;
      if (!c_.es) f_.get_integer(kDoubleBuffer, &is_double);
      changes_read_buffer_ = is_double != 0 && static_cast<Enum>(read_buffer_) != kBack;
      if (changes_read_buffer_) f_.read_buffer(kBack);
    }
  }
  ~ReadState() {
    if (changes_read_buffer_) f_.read_buffer(static_cast<Enum>(read_buffer_));
    if (framebuffer_ != 0) bind_framebuffer(static_cast<unsigned>(framebuffer_));
    if (pack_buffer_ != 0) f_.bind_buffer(kPixelPackBuffer, static_cast<unsigned>(pack_buffer_));
    if (c_.has_row_length())
      for (const Kept& kept : kept_)
        if (kept.value != 0 && in_context(kept)) f_.pixel_store(kept.name, kept.value);
    if (alignment_ != 4) f_.pixel_store(kPackAlignment, alignment_);
  }
  ReadState(const ReadState&) = delete;
  ReadState& operator=(const ReadState&) = delete;

 private:
  struct Kept {
    Enum name;
    bool in_es;
    Int value;
  };
  bool in_context(const Kept& kept) const noexcept { return kept.in_es || !c_.es; }
  void bind_framebuffer(unsigned name) const noexcept {
    f_.bind_framebuffer(c_.has_read_framebuffer() ? kReadFramebuffer : kFramebuffer, name);
  }
  const Functions& f_;
  const Context& c_;
  Int alignment_ = 4, pack_buffer_ = 0, framebuffer_ = 0, read_buffer_ = 0;
  bool changes_read_buffer_ = false;
  Kept kept_[5] = {{kPackRowLength, true, 0},
                   {kPackSkipRows, true, 0},
                   {kPackSkipPixels, true, 0},
                   {kPackSwapBytes, false, 0},
                   {kPackLsbFirst, false, 0}};
};

struct Order {
  Enum format;
  PixelOrder order;
};

/// The order that needs no conversion on most drivers; OpenGL ES promises the other one only.
Order order_in(const Context& c) noexcept {
  return c.es ? Order{kRgba, PixelOrder::rgbx} : Order{kBgra, PixelOrder::bgrx};
}

void read(const Functions& f, const Context& c, const Answer& a, void* into) noexcept {
  const auto bottom = static_cast<Int>(a.window_height) - a.y - static_cast<Int>(a.height);
  f.read_pixels(a.x, bottom, static_cast<Int>(a.width), static_cast<Int>(a.height), order_in(c).format, kUnsignedByte,
                into);
}

/// A picture on its way: the driver copies it into a buffer of its own while the program draws on.
struct Pending {
  const void* context;  // null: none
  std::uint64_t key;
  const void* display;
  unsigned buffer;
  Job job;
};
pthread_mutex_t pending_mutex = PTHREAD_MUTEX_INITIALIZER;
Pending pending[kMaxViews * kSlots];
std::atomic<std::uint32_t> pending_count{0};

void begin_buffered(Head& head, const Functions& f, const Context& c, const GlPlace& place, Job& job) noexcept {
  pthread_mutex_lock(&pending_mutex);
  Pending* free = nullptr;
  for (Pending& p : pending)
    if (p.context == nullptr) free = &p;
  if (free != nullptr) {
    unsigned buffer = 0;
    f.gen_buffers(1, &buffer);
    f.bind_buffer(kPixelPackBuffer, buffer);
    f.buffer_data(kPixelPackBuffer, static_cast<std::ptrdiff_t>(job.answer.stride) * job.answer.height, nullptr,
                  kStreamRead);
    read(f, c, job.answer, nullptr);
    f.bind_buffer(kPixelPackBuffer, 0);
    *free = Pending{place.context, place.key, place.display, buffer, job};
    pending_count.fetch_add(1, std::memory_order_relaxed);
  }
  pthread_mutex_unlock(&pending_mutex);
  if (free == nullptr) refuse(head, job, AnswerStatus::lost);
}

bool can_buffer(const Functions& f, const Context& c) noexcept {
  return c.has_pack_buffer() && f.gen_buffers != nullptr && f.delete_buffers != nullptr && f.bind_buffer != nullptr &&
         f.buffer_data != nullptr && f.unmap_buffer != nullptr &&
         (f.map_buffer_range != nullptr || f.map_buffer != nullptr);
}

/// Needs the reading state of the context: hands over what was begun at the swap before.
void end_buffered(Head& head, const Functions& f, const Context& c, const GlPlace& place) noexcept {
  pthread_mutex_lock(&pending_mutex);
  for (Pending& p : pending) {
    if (p.context == nullptr || p.key != place.key || p.display != place.display) continue;
    const auto bytes = static_cast<std::size_t>(p.job.answer.stride) * p.job.answer.height;
    const void* at = nullptr;
    if (p.context == place.context) {
      f.bind_buffer(kPixelPackBuffer, p.buffer);
      at = f.map_buffer_range != nullptr
               ? f.map_buffer_range(kPixelPackBuffer, 0, static_cast<std::ptrdiff_t>(bytes), kMapReadBit)
               : f.map_buffer(kPixelPackBuffer, kReadOnly);
      if (at != nullptr) {
        std::memcpy(p.job.pixels, at, bytes);
        f.unmap_buffer(kPixelPackBuffer);
      }
      f.bind_buffer(kPixelPackBuffer, 0);
      f.delete_buffers(1, &p.buffer);
    }
    if (at != nullptr)
      finish(head, p.job, order_in(c).order, true);
    else
      refuse(head, p.job, AnswerStatus::lost);
    p = Pending{};
    pending_count.fetch_sub(1, std::memory_order_relaxed);
  }
  pthread_mutex_unlock(&pending_mutex);
}

}  // namespace

void picture_of_gl(const GlPlace& place) noexcept {
  Head* head = memory();
  if (head == nullptr) return;
  Shown shown;
  if (!count_picture(*head, place.api, place.display, place.key, shown)) return;
  Size size;
  if (wants_size(*head, shown) && place.size(place, size)) tell_size(*head, shown, size);
  const bool waiting = pending_count.load(std::memory_order_relaxed) != 0;
  if (head->views.load(std::memory_order_relaxed) == 0 && !waiting) return;
  const std::int64_t now = now_ns();
  if (!is_asked(*head, shown, now) && !waiting) return;
  const Functions& f = functions_of(place);
  if (!f.usable || !place.size(place, size) || size.width == 0 || size.height == 0 || size.width > kMaxSide ||
      size.height > kMaxSide)
    return;
  tell_size(*head, shown, size);
  const Context context = context_of(f);
  if (context.version == 0) return;
  const ReadState state(f, context);
  if (waiting) end_buffered(*head, f, context, place);
  const bool buffers = reads_buffered() && can_buffer(f, context);
  Job job;
  while (take_job(*head, shown, now, size, job)) {
    if (buffers) {
      begin_buffered(*head, f, context, place, job);
    } else {
      read(f, context, job.answer, job.pixels);
      finish(*head, job, order_in(context).order, true);
    }
  }
}

}  // namespace sinew::grab
