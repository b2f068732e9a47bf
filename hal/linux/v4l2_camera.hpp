#pragma once
#include <atomic>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "hal/camera_controls.hpp"
#include "hal/linux/fd_watch.hpp"
#include "hal/linux/frame_count.hpp"
#include "hal/linux/v4l2_session.hpp"
#include "hal/self_report.hpp"

namespace sinew::hal {

/// How a camera's own thread looks after it.
struct V4l2CameraOptions {
  Duration first_retry = std::chrono::milliseconds(100);  // after the device went away; then twice as long each time
  Duration longest_retry = std::chrono::seconds(2);
  Duration restart_after = std::chrono::seconds(5);  // without a frame, and ten periods: stream closed and opened anew
  Duration look_every = std::chrono::milliseconds(500);  // for silence, and for an exposure that the device changes
};

/// A camera of the kernel (Video4Linux2), streaming into mapped buffers; docs/camera.md has keys, stamps and limits.
/// read() copies the pixels once, from the driver's buffer into `out`, without the padding of its rows.
/// A device that is unplugged, fails or falls silent is opened again by a thread of low priority: meanwhile read() says
/// closed, then frames go on with higher numbers, the format and the controls as they were.
/// Stamps:  the driver's (CLOCK_MONOTONIC), moved to the middle of the exposure where its length is known.
/// Thread:  read(): owner. request(), stats(), state(): any.   RT: read(), request() yes (one DQBUF and QBUF a frame).
/// Errors:  read(): closed while the device is gone; bad_data when only faulty frames were waiting; bad_argument.
class V4l2Camera final : public Camera, public CameraControls, public SelfReport {
 public:
  /// Errors:  those of V4l2Session::open(), with its `why`; io when no thread can be started.
  static Result<std::unique_ptr<V4l2Camera>> open(V4l2Port& port, const CameraSpec& spec, Os& os,
                                                  std::shared_ptr<FdWatch> watch, const V4l2CameraOptions& options,
                                                  std::string& why);
  ~V4l2Camera() override;

  Time ready_at() const noexcept override { return line_.ready() ? Time{0} : kNever; }
  void set_wake(Wake* wake) noexcept override { line_.change_wake(wake); }
  Result<bool> read(msg::Image& out) noexcept override;

  const std::vector<CameraControl>& controls() const override { return controls_; }
  Status request(std::size_t control, double value) noexcept override;
  std::optional<Exposure> exposure() const override;
  std::optional<std::size_t> gain() const override;

  /// As it was opened; may stand for another node after the device was plugged in again.
  const V4l2Identity& identity() const { return identity_; }
  const V4l2Picture& picture() const { return picture_; }
  CameraStats stats() const { return count_.stats(); }
  /// How it does, in words for people: "streaming", "slow", "no frame for 3 s", "gone: No such device; ...". RT: no.
  std::string state() const;
  /// The part of state() that is no good news, in words that stay.
  std::string trouble() const override;

 private:
  // Whose the session is. The reader holds it during one read(); who finds it broken leaves it to the keeper as kLost.
  enum Holder : int { kNobody, kReader, kKeeper };
  struct Request {
    std::atomic<double> value{0};
    std::atomic<bool> pending{false};  // release after the value, acquire before it
  };

  V4l2Camera(V4l2Port& port, CameraSpec spec, Os& os, std::shared_ptr<FdWatch> watch, const V4l2CameraOptions& options);
  // v4l2_camera.cpp: the reader's side
  Result<bool> read_held(msg::Image& out, int& broken) noexcept;
  bool usable(const V4l2Session::Filled& filled) noexcept;
  Result<bool> copy(const V4l2Session::Filled& filled, msg::Image& out) noexcept;
  Time middle(const V4l2Session::Filled& filled, std::int64_t exposure_ns) noexcept;
  void call_keeper() noexcept;
  // v4l2_camera_keeper.cpp: its own thread's
  void keep() noexcept;
  Duration open_again(Duration retry);
  void look_after();
  void set_requested();
  void adopt(std::unique_ptr<V4l2Session> session);
  Duration silence() const;

  V4l2Port& port_;
  CameraSpec spec_;  // keeper: its controls follow what was requested
  Os& os_;
  std::shared_ptr<FdWatch> watch_;
  const V4l2CameraOptions options_;
  V4l2Identity identity_;
  V4l2Picture picture_;
  std::vector<CameraControl> controls_;
  std::unique_ptr<Request[]> requests_;  // as many as controls

  FdLine line_;
  std::unique_ptr<V4l2Session> session_;  // changed by the keeper while it holds it
  std::atomic<int> holder_{kNobody};
  std::atomic<int> broken_{0};  // errno that the session was left with
  std::atomic<std::int64_t> exposure_ns_{0}, last_frame_ns_{0};
  FrameCount count_;  // the reader's; the keeper's while it holds the session

  mutable std::mutex mutex_;  // keeper and state()
  std::string path_, trouble_, control_trouble_;
  WakeWord bell_{0};  // moves when there is something for the keeper
  std::atomic<bool> stop_{false};
  std::unique_ptr<Thread> keeper_;
};

/// A camera of this machine. `os` must outlive it.
Result<std::unique_ptr<V4l2Camera>> open_v4l2_camera(const CameraSpec& spec, Os& os, std::shared_ptr<FdWatch> watch,
                                                     std::string& why);

}  // namespace sinew::hal
