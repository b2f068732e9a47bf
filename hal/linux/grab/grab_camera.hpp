#pragma once
#include <atomic>
#include <memory>
#include <string>

#include "hal/connectors.hpp"
#include "hal/linux/fd_watch.hpp"
#include "hal/linux/grab/grab_pixels.hpp"
#include "hal/linux/grab/grab_view.hpp"
#include "hal/os.hpp"
#include "hal/self_report.hpp"
#include "hal/sensor_queue.hpp"
#include "hal/wide.hpp"

namespace sinew::hal {

/// Counted since it was opened.
struct GrabStats {
  std::uint64_t pictures = 0;  // handed on
  std::uint64_t refused = 0;   // the program could not read them: too large, outside of the window, ...
  std::uint64_t resized = 0;   // the window had another size than at the picture before
  std::uint64_t restarts = 0;  // the program ended and came again
};

/// The window of a program started by `sinew grab` as a camera (docs/grab.md). It asks for one picture a period, and
/// for no more while its reader takes none: the program then reads nothing back. A thread of its own sleeps until a
/// picture is in the shared memory, and looks for the program: it opens without one, and goes on when the program
/// comes, ends and comes again. read() turns the picture into the image's format and size, straight from the shared
/// memory. Stamps:  when the program showed the picture (CLOCK_MONOTONIC). frame_number counts this camera's pictures.
/// Thread:  read(): owner; stats(): any.
/// RT:      read() yes.
/// Errors:  read(): closed while the program is gone; bad_data for a picture that could not be read; bad_argument.
class GrabCamera final : public Camera, public SelfReport {
 public:
  /// Errors:  bad_argument: the spec; denied: the folder of sockets; io: no thread. `why` has it in words.
  static Result<std::unique_ptr<Camera>> open(const GrabSpec& spec, Os& os, std::string& why);
  ~GrabCamera() override;
  GrabCamera(const GrabCamera&) = delete;
  GrabCamera& operator=(const GrabCamera&) = delete;

  Time ready_at() const noexcept override { return line_.ready() ? Time{0} : kNever; }
  void set_wake(Wake* wake) noexcept override { line_.change_wake(wake); }
  Result<bool> read(msg::Image& out) noexcept override;

  GrabStats stats() const;
  std::string trouble() const override;
  std::string shortfall() const override { return thread_ ? thread_->shortfall() : std::string(); }

 private:
  // Who has the view: the reader during one read(), the thread while it makes another one.
  enum Holder : int { kNobody, kReader, kKeeper };
  GrabCamera(const GrabSpec& spec, Os& os) : spec_(spec), os_(os) {}
  void run() noexcept;
  bool connect_now();
  void lose();
  void ask_next(Time now) noexcept;
  std::uint32_t wanted_window() const noexcept;
  void follow_title();
  Result<bool> take_over(const GrabPicture& picture, msg::Image& out) noexcept;

  const GrabSpec spec_;
  Os& os_;
  FdLine line_;
  GrabPixels pixels_;               // the reader's
  std::unique_ptr<GrabView> view_;  // changed by the thread while it holds it; the thread may always wait on it
  std::atomic<int> holder_{kKeeper};
  Time due_{};                                      // of the last request; the holder's
  std::uint32_t number_ = 0;                        // of the next image; the reader's
  std::uint32_t last_width_ = 0, last_height_ = 0;  // the reader's
  std::atomic<std::uint32_t> last_status_{0};
  Wide<std::int64_t> last_ns_;
  Tally pictures_, refused_, resized_, restarts_;
  std::atomic<bool> connected_{false}, has_titled_{false};
  TroubleText missing_, untitled_;
  WakeWord stop_{0};
  std::unique_ptr<Thread> thread_;
};

}  // namespace sinew::hal
