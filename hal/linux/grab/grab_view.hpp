#pragma once
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "grab/grab_memory.hpp"
#include "hal/clock.hpp"
#include "hal/result.hpp"

namespace sinew::hal {

/// A window of a grabbed program, for people.
struct GrabWindow {
  std::uint32_t number = 0;
  std::string program, api;
  std::uint32_t pid = 0, width = 0, height = 0, pictures = 0;
  std::uint64_t id = 0;  // X11's, for OpenGL on X11
  std::string title;     // UTF-8; empty: it has none, or none that is known
};

/// A picture in the shared memory, checked: `pixels` may be read as far as the fields say.
struct GrabPicture {
  Time shown{}, there{};     // the program's swap, and when the pixels were in memory
  std::uint32_t number = 0;  // of this view: 0, 1, ...
  std::uint32_t window = 0, swap = 0, window_width = 0, window_height = 0;
  std::int32_t x = 0, y = 0;  // in the window
  std::uint32_t width = 0, height = 0, stride = 0;
  grab::PixelOrder order = grab::PixelOrder::bgrx;
  bool bottom_up = false;
  grab::AnswerStatus status = grab::AnswerStatus::ok;  // not ok: no pixels
  const std::uint8_t* pixels = nullptr;                // row 0 in memory

  const std::uint8_t* row(std::uint32_t y_from_top) const {
    return pixels + std::size_t{bottom_up ? height - 1 - y_from_top : y_from_top} * stride;
  }
};

/// Why there are no pixels, for people; empty: ok.
const char* words_of(grab::AnswerStatus status);

/// What to ask for.
struct GrabRegion {
  std::int32_t x = 0, y = 0;
  std::uint32_t width = 0, height = 0;  // 0: to the border
};

/// Which window a title means: the one that has exactly this title, else the only one whose title contains it.
struct TitledWindow {
  std::uint32_t window = grab::kNoNumber;  // none, or none alone
  std::uint32_t count = 0;                 // whose title contains it
};

/// One reader of a session of `sinew grab`: asks for pictures of one window, at most two ahead, and reads them in
/// place.
///
///   view->ask(kAnyWindow, {}, now);        // the first picture shown from now on
///   view->wait(deadline);
///   if (const auto picture = view->oldest()) { ...; view->take(); }
///
/// Thread:  owner; wait(), is_connected(): one other thread besides.
/// RT:      ask(), point_at(), titled(), oldest(), take() yes.
class GrabView {
 public:
  static constexpr std::uint32_t kAnyWindow = grab::kNoNumber;  // the one that shows pictures
  /// Errors:  not_found: no such session; busy: it has as many readers as it can; not_supported: of another version;
  ///          bad_argument, io. `why` has it in words.
  static Result<std::unique_ptr<GrabView>> open(const std::string& session, std::string& why);
  ~GrabView();
  GrabView(const GrabView&) = delete;
  GrabView& operator=(const GrabView&) = delete;

  /// False: two are asked for and not taken yet.
  bool ask(std::uint32_t window, const GrabRegion& region, Time due) noexcept;
  /// Points the requests that are open at another window.
  void point_at(std::uint32_t window) noexcept;
  TitledWindow titled(std::string_view title) const noexcept;
  std::vector<GrabWindow> windows() const;
  std::uint32_t asked() const noexcept { return asked_; }
  std::uint32_t open_asks() const noexcept { return asked_ - taken_; }
  /// The oldest picture that has come and was not taken; nothing: none. What the program wrote is checked here: a
  /// picture that cannot be is answered as `lost`.
  std::optional<GrabPicture> oldest() noexcept;
  /// Gives its memory back for the next request.
  void take() noexcept { ++taken_; }
  /// Sleeps until a picture has come that oldest() did not see yet, at most until `deadline`.
  void wait(Time deadline) const noexcept;
  /// Whether one has come that was not taken.
  bool has_come() const noexcept;
  /// False: `sinew grab` ended.
  bool is_connected() const noexcept;

 private:
  GrabView(int socket, int memory, grab::Head* head, std::uint32_t view)
      : socket_(socket), memory_(memory), head_(head), view_(view) {}
  const std::uint8_t* mapped(std::uint32_t slot, std::size_t bytes) noexcept;

  int socket_, memory_;
  grab::Head* head_;
  std::uint32_t view_;
  std::uint32_t asked_ = 0;
  std::atomic<std::uint32_t> taken_{0};
  struct Mapping {
    std::uint8_t* at = nullptr;
    std::size_t bytes = 0;
  } mappings_[grab::kSlots];
};

/// The windows of a session. Errors: as GrabView::open().
Result<std::vector<GrabWindow>> grab_windows(const std::string& session, std::string& why);

/// One answer of the shared memory, checked; for GrabView, and the fuzzer.
GrabPicture checked_picture(const grab::Answer& answer, std::uint32_t number) noexcept;
/// Whether any program shows pictures in this memory; its windows.
std::vector<GrabWindow> windows_of(const grab::Head& head);
/// RT: yes.
TitledWindow window_titled(const grab::Head& head, std::string_view title) noexcept;
/// "'Front', 'Rear'": for people; "none" where no window has a title.
std::string titles_of(const std::vector<GrabWindow>& windows);
/// A title without what is no UTF-8 and without control characters: these become '?'.
std::string clean_title(std::string_view text);

}  // namespace sinew::hal
