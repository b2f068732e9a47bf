#pragma once
// What a program whose pictures are taken shares with those who ask for them: one memory per `sinew grab`, and the two
// messages by which both sides come to it. docs/grab.md has the picture as a whole.
//
// `sinew grab` makes the memory (a memfd that nobody can shrink) and hands it out on a socket. Inside of the program,
// libsinew_grab.so writes windows and answers; a reader (a robot's camera) has a view and writes requests. Nobody
// trusts what the others write: a reader copies an answer and checks the copy, the program clamps what it was asked
// for. The layout is the same for 32 and 64 bits, which may share one memory.
#include <atomic>
#include <cstddef>
#include <cstdint>

namespace sinew::grab {

inline constexpr std::uint32_t kMagic = 0x62617247;  // "Grab"
inline constexpr std::uint32_t kVersion = 2;         // of layout and messages; both sides refuse another one
inline constexpr std::uint32_t kMaxWindows = 16, kMaxViews = 16;
inline constexpr std::uint32_t kSlots = 2;               // pictures that a view may have asked for and not taken yet
inline constexpr std::uint32_t kMaxSide = 16384;         // of a window, pixels
inline constexpr std::uint32_t kNameBytes = 32;          // with the final 0
inline constexpr std::uint32_t kTitleWords = 32;         // of 4 bytes, with the final 0
inline constexpr std::uint32_t kNoNumber = 0xFFFFFFFFu;  // no window, no view
inline constexpr std::uint32_t kBytesPerPixel = 4;
/// Room for one picture: 3840 x 2400. Only pages that were written take memory.
inline constexpr std::uint32_t kSlotBytes = 36u << 20;
/// Environment variables of the program: the path of the socket, and how pictures are read ("direct", "buffered").
inline constexpr char kSocketVariable[] = "SINEW_GRAB", kReadVariable[] = "SINEW_GRAB_READ";

enum class Api : std::uint32_t { none, glx, egl, vulkan };

/// Bytes of a pixel in memory, first to last; the fourth has no meaning.
enum class PixelOrder : std::uint32_t { rgbx, bgrx };

enum class AnswerStatus : std::uint32_t {
  ok,
  too_large,     // the region does not fit a slot
  outside,       // nothing of the region is inside of the window
  not_readable,  // the window's pixel format, or its swapchain, cannot be read
  lost,          // it was read, but the program dropped its graphics context before the pixels came
};

/// 64 bits that 32-bit machines need not read at once: the word beside it says when both halves are there.
struct Wide {
  std::uint32_t low, high;
  std::int64_t get() const noexcept { return static_cast<std::int64_t>(static_cast<std::uint64_t>(high) << 32 | low); }
  void set(std::int64_t value) noexcept {
    low = static_cast<std::uint32_t>(static_cast<std::uint64_t>(value));
    high = static_cast<std::uint32_t>(static_cast<std::uint64_t>(value) >> 32);
  }
};

using Word = std::atomic<std::uint32_t>;
static_assert(sizeof(Word) == 4 && Word::is_always_lock_free);

/// A window that shows pictures. Written by the program that has it; emptied by `sinew grab` when that program ends.
struct Window {
  Word process;         // number of the program's connection, 0: free. Taken by compare and swap
  Word ready;           // 1: the fields below are there
  Word width, height;   // when it was looked at last: at its first picture, and at each that is asked for
  Word swaps;           // pictures shown so far; wraps
  Word alive_ms;        // when it was swapped last, while a view waits for any window; wraps
  std::uint32_t api;    // Api
  std::uint32_t pid;    // as the program itself sees it
  std::uint32_t id[2];  // the window system's number of it (X11 window), or what the program has instead; low, high
  std::uint32_t x11;    // the X11 window that it is drawn into; 0: not known
  char program[kNameBytes];
};

/// The title of a window. Written by `sinew grab`, which asks the display server for it: a program that changes its
/// title pays nothing for that. A title counts only while the window has the process and the X11 window that it names.
struct Title {
  Word writes;  // odd while it is written; look again when it has changed
  Word process, x11;
  Word text[kTitleWords];  // UTF-8, 4 bytes a word as they stand in memory
};

/// What a reader wants next. The reader writes it before it raises View::asked.
struct Request {
  Wide due;                     // ns of CLOCK_MONOTONIC: the first picture shown from then on; 0: the next one
  std::uint32_t window;         // number of a window; kNoNumber: the one that shows pictures
  std::int32_t x, y;            // region, pixels from the top left
  std::uint32_t width, height;  // 0: to the border
};

/// A picture, or why there is none. The program writes it before it raises View::answered.
struct Answer {
  std::uint32_t status;  // AnswerStatus
  std::uint32_t window;
  std::uint32_t swap;                         // which of the window's pictures, as Window::swaps counts them
  std::uint32_t window_width, window_height;  // when it was shown
  std::int32_t x, y;                          // the part of the region that is inside of the window
  std::uint32_t width, height;
  std::uint32_t stride;     // bytes from row to row
  std::uint32_t order;      // PixelOrder
  std::uint32_t bottom_up;  // 1: the first row in memory is the lowest
  Wide shown;               // ns of CLOCK_MONOTONIC: the program called the swap or present
  Wide there;               // and the pixels were in the slot
};

/// Pictures of one reader. Request and answer number n (0, 1, ...) use element n % kSlots.
struct View {
  Word reader;    // number of the reader's connection, 0: free. Set by `sinew grab`
  Word asked;     // requests so far. The reader raises it (release), at most kSlots beyond what it has taken
  Word answered;  // answers so far. The program raises it (release) and wakes sleepers on it
  Word claimed;   // number of the connection that works on an answer; 0: none. One thread at a time
  Word bound;     // 1 + the window that answers requests for kNoNumber; 0: none yet
  Request requests[kSlots];
  Answer answers[kSlots];
};

struct Head {
  std::uint32_t magic, version;
  Word views;    // bit v: views[v] has a reader. All that a program looks at while nobody asks
  Word windows;  // raised when a window comes or goes; readers may sleep on it
  Window window[kMaxWindows];
  View view[kMaxViews];
  Title title[kMaxWindows];
};

inline constexpr std::uint32_t kPicturesAt = 65536;  // the head before it; a multiple of every kernel's pages
static_assert(sizeof(Head) <= kPicturesAt);
static_assert(sizeof(Window) == 76 && sizeof(Request) == 28 && sizeof(Answer) == 64 && sizeof(View) == 204 &&
              sizeof(Title) == 140);

/// Where a slot is in the memory. 64 bits: beyond what 32-bit programs map at once.
constexpr std::uint64_t slot_at(std::uint32_t view, std::uint32_t slot) {
  return kPicturesAt + (std::uint64_t{view} * kSlots + slot) * kSlotBytes;
}
inline constexpr std::uint64_t kMemoryBytes = slot_at(kMaxViews, 0);

/// First message on the socket (SOCK_SEQPACKET): who comes.
struct Hello {
  enum class Role : std::uint32_t { program = 1, reader = 2, watcher = 3 };  // a watcher only looks
  std::uint32_t magic, version, role, pid;
  char program[kNameBytes];
};

/// The answer to it, with the memory's descriptor (SCM_RIGHTS) when it is welcome.
struct Welcome {
  std::uint32_t magic, version;
  std::uint32_t number;  // of this connection, from 1; 0: refused
  std::uint32_t view;    // a reader's view; kNoNumber: all are taken, or it is no reader
};

}  // namespace sinew::grab
