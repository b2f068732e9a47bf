#pragma once
#include <atomic>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "hal/camera_controls.hpp"
#include "hal/camera_memory.hpp"
#include "hal/linux/camera/frame_count.hpp"
#include "hal/linux/camera/jpeg_decoder.hpp"
#include "hal/linux/camera/v4l2_session.hpp"
#include "hal/linux/fd_watch.hpp"
#include "hal/self_report.hpp"

namespace sinew::hal {

/// Settings of the camera's own thread.
struct V4l2CameraOptions {
  Duration first_retry = std::chrono::milliseconds(100);  // after the device went away; then twice as long each time
  Duration longest_retry = std::chrono::seconds(2);
  Duration restart_after = std::chrono::seconds(5);  // without a frame, and ten periods: stream closed and opened anew
  Duration look_every = std::chrono::milliseconds(500);  // for silence, and for an exposure that the device changes
};

/// A camera of the kernel (Video4Linux2); docs/camera.md has keys, stamps and limits. It streams into mapped buffers,
/// and read() copies the pixels once, from the driver's buffer into `out`, without the padding of its rows. Where the
/// driver can, it streams into memory lent by the reader (CameraMemory), and no pixels are copied.
/// A device that is unplugged, fails or falls silent is opened again by a thread of low priority: meanwhile read() says
/// closed, then frames go on with higher numbers, the format and the controls as they were.
/// Stamps:  the driver's (CLOCK_MONOTONIC), moved to the middle of the exposure where its length is known.
/// Thread:  read(), CameraMemory: owner. request(), stats(), state(): any.
/// RT:      read(), request() yes (one DQBUF and QBUF a frame).
/// Errors:  read(): closed while the device is gone; bad_data when only faulty frames were waiting; bad_argument.
class V4l2Camera final : public Camera, public CameraControls, public CameraMemory, public SelfReport {
 public:
  /// Errors:  those of V4l2Session::open(), with its `why`; io when no thread can be started.
  static Result<std::unique_ptr<V4l2Camera>> open(V4l2Port& port, const CameraSpec& spec, Os& os,
                                                  std::shared_ptr<FdWatch> watch, const V4l2CameraOptions& options,
                                                  std::string& why);
  ~V4l2Camera() override;

  Time ready_at() const noexcept override { return line_.ready() ? Time{0} : kNever; }
  void set_wake(Wake* wake) noexcept override { line_.change_wake(wake); }
  Result<bool> read(msg::Image& out) noexcept override;

  Result<std::uint32_t> begin_lending(std::uint32_t room_bytes, std::string& why) override;
  Status lend(msg::Image& image) noexcept override;
  Result<msg::Image*> take_filled() noexcept override;
  msg::Image* take_back() noexcept override;
  void stop_lending() noexcept override;
  std::string path_of_pixels() const override;

  const std::vector<CameraControl>& controls() const override { return controls_; }
  Status request(std::size_t control, double value) noexcept override;
  std::optional<Exposure> exposure() const override;
  std::optional<std::size_t> gain() const override;

  /// As it was opened; the node may change when the device is plugged in again.
  const V4l2Identity& identity() const { return identity_; }
  const V4l2Picture& picture() const { return picture_; }
  CameraStats stats() const { return count_.stats(); }
  /// The state in words for people: "streaming", "slow", "no frame for 3 s", "gone: No such device; ...". RT: no.
  std::string state() const;
  /// The bad news of state(), in words that do not change with time.
  std::string trouble() const override;

 private:
  // The session's holder. The reader holds it during one read(); a holder that finds it broken leaves it as kLost to
  // the keeper.
  enum Holder : int { kNobody, kReader, kKeeper };
  struct Request {
    AnybodysNumber value{0};
    std::atomic<bool> pending{false};  // release after the value, acquire before it
  };

  V4l2Camera(V4l2Port& port, CameraSpec spec, Os& os, std::shared_ptr<FdWatch> watch, const V4l2CameraOptions& options);
  // v4l2_camera.cpp: the reader's side
  bool take_session() noexcept;
  void leave_session(int broken) noexcept;
  Result<bool> next_frame(V4l2Session::Filled& filled, int& broken) noexcept;
  bool usable(const V4l2Session::Filled& filled) noexcept;
  bool describe(const V4l2Session::Filled& filled, msg::Image& out) noexcept;
  Result<bool> copy(const V4l2Session::Filled& filled, msg::Image& out) noexcept;
  Time middle(const V4l2Session::Filled& filled, std::int64_t exposure_ns) noexcept;
  void call_keeper() noexcept;
  // v4l2_camera_lending.cpp: the reader's side of lent memory
  int queue_lent() noexcept;
  Status cannot_lend(int error) noexcept;
  // v4l2_camera_keeper.cpp: its own thread's
  void keep() noexcept;
  Duration open_again(Duration retry);
  void look_after();
  void start_or_stop();
  void end_stream() noexcept;
  std::string words_for_pixels() const;
  void set_requested();
  void adopt(std::unique_ptr<V4l2Session> session);
  Duration silence() const;
  Duration only_faulty() const;

  V4l2Port& port_;
  CameraSpec spec_;  // the keeper's; its controls follow the requests
  Os& os_;
  std::shared_ptr<FdWatch> watch_;
  const V4l2CameraOptions options_;
  V4l2Identity identity_;
  V4l2Picture picture_;
  std::vector<CameraControl> controls_;
  std::unique_ptr<Request[]> requests_;  // as many as controls

  FdLine line_;
  std::unique_ptr<JpegDecoder> jpeg_;     // of a session with JPEG pictures; it stays when the session goes
  std::unique_ptr<V4l2Session> session_;  // changed by the keeper while it holds it
  std::atomic<int> holder_{kNobody};
  std::atomic<int> broken_{0};  // errno with which the session was left
  Wide<std::int64_t> exposure_ns_, last_frame_ns_, last_good_ns_;

  // Lent memory. The list is the reader's alone; the keeper closes and opens streams, and never queues.
  enum class Wish : int { none, start, stop };
  std::vector<msg::Image*> lent_;             // lent by the reader, in a stream or waiting for one
  std::uint32_t lent_count_ = 0;              // so many images make a stream
  std::atomic<std::uint32_t> room_bytes_{0};  // of each; 0: nothing is lent, the stream is into mapped buffers
  std::atomic<bool> kernel_has_lent_{false};  // set by the reader before it queues; cleared when a stream has ended
  std::atomic<bool> streams_{true};           // false: a stream into lent memory has not begun
  std::atomic<bool> resting_{false};          // and the reader does not want it now
  std::atomic<Wish> wish_{Wish::none};        // from the reader to the keeper; the fulfilling thread clears it
  std::string copies_because_;                // under mutex_; empty: lending was not asked for
  std::atomic<int> lending_error_{0};         // errno of the driver's refusal of memory that begin_lending() promised

  FrameCount count_;  // the reader's; the keeper's while the keeper holds the session

  mutable std::mutex mutex_;  // keeper and state()
  std::string path_, trouble_, control_trouble_;
  WakeWord bell_{0};  // changes when there is work for the keeper
  std::atomic<bool> stop_{false};
  std::unique_ptr<Thread> keeper_;
};

/// A camera of this machine. `os` must outlive it.
Result<std::unique_ptr<V4l2Camera>> open_v4l2_camera(const CameraSpec& spec, Os& os, std::shared_ptr<FdWatch> watch,
                                                     std::string& why);

}  // namespace sinew::hal
