#pragma once
#include <cstddef>
#include <cstdint>

#include "grab/grab_memory.hpp"

// The program's side of the memory, without any graphics: OpenGL and Vulkan use it in the same way. It runs in programs
// of others, in whatever thread shows a picture, so it has no C++ library, no thread and no static object that needs
// construction, prints nothing, and leaves the program alone when anything is missing.
namespace sinew::grab {

/// A window of this process, as hooks know it.
struct Shown {
  Api api = Api::none;
  const void* display = nullptr;
  std::uint64_t key = 0;             // in `display`
  std::uint32_t number = kNoNumber;  // in the memory
  std::uint32_t swaps = 0;
};

/// A picture to be read, claimed by this process until finish() or refuse().
struct Job {
  std::uint32_t view = kNoNumber, number = 0;
  Answer answer{};                 // region and size are set
  std::uint8_t* pixels = nullptr;  // room for answer.height rows of answer.stride bytes
};

struct Size {
  std::uint32_t width = 0, height = 0;
};

std::int64_t now_ns() noexcept;

/// The memory; null: this process was not started by `sinew grab`, or that is gone. Connects at the first call.
Head* memory() noexcept;

/// True: `sinew grab --read buffered`.
bool reads_buffered() noexcept;

/// Counts a picture of a window and finds its number. False: there is no number left for it. `shown` is a copy.
bool count_picture(Head& head, Api api, const void* display, std::uint64_t key, Shown& shown) noexcept;
/// True until the window's size was told once.
bool wants_size(const Head& head, const Shown& shown) noexcept;
void tell_size(Head& head, const Shown& shown, Size size) noexcept;
/// The program has destroyed it.
void forget_window(Api api, const void* display, std::uint64_t key) noexcept;

/// The X11 window behind a drawable or surface that the program has just made. Where nothing was noted, the drawable of
/// GLX is the window itself.
void note_x11_window(Api api, const void* display, std::uint64_t key, std::uint64_t window) noexcept;

/// Whether a reader waits for a picture of this window that is shown at `now`. The first question, and while nobody
/// asks the last one.
bool is_asked(Head& head, const Shown& shown, std::int64_t now) noexcept;
/// Claims the next request for such a picture, and answers those that this size cannot serve. False: there is no more.
bool take_job(Head& head, const Shown& shown, std::int64_t now, Size size, Job& job) noexcept;
/// The pixels are there.
void finish(Head& head, Job& job, PixelOrder order, bool bottom_up) noexcept;
void refuse(Head& head, Job& job, AnswerStatus status) noexcept;

}  // namespace sinew::grab
