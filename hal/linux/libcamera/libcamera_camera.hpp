#pragma once
#include <atomic>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "hal/camera_controls.hpp"
#include "hal/connectors.hpp"
#include "hal/linux/camera/frame_count.hpp"
#include "hal/os.hpp"
#include "hal/self_report.hpp"
#include "hal/wake_slot.hpp"

namespace sinew::hal {

class LibcameraSession;

/// A camera behind libcamera 0.0.3 (Debian 12): a camera on the board's own connector that needs more than one kernel
/// device to give a picture. docs/camera.md has keys, stamps and limits.
/// Requests finish in libcamera's thread; read() copies the pixels of the oldest once. A thread of low priority sends
/// the request round again, sets controls, and restarts a silent stream.
/// A camera that goes away is opened again when libcamera reports its loss (the USB pipeline does). For other pipelines
/// state() reports the loss, and the program has to be started again: see LibcameraSession::vanished().
/// Stamps:  SensorTimestamp (start of the exposure) plus half of ExposureTime, where the pipeline reports them.
/// Thread:  read(): owner. request(), stats(), state(): any.   RT: read(), request() yes.
/// Errors:  read(): closed while the camera is away; bad_data for a faulty frame; bad_argument: too large.
class LibcameraCamera final : public Camera, public CameraControls, public SelfReport {
 public:
  /// Errors:  not_found, busy, denied, not_supported, bad_argument, io; `why` says it with the camera's name.
  static Result<std::unique_ptr<LibcameraCamera>> open(const CameraSpec& spec, Os& os, std::string& why);
  ~LibcameraCamera() override;

  Time ready_at() const noexcept override { return ready_.load(std::memory_order_acquire) ? Time{0} : kNever; }
  void set_wake(Wake* wake) noexcept override { wake_.change(wake); }
  Result<bool> read(msg::Image& out) noexcept override;

  const std::vector<CameraControl>& controls() const override { return controls_; }
  Status request(std::size_t control, double value) noexcept override;
  std::optional<Exposure> exposure() const override;
  std::optional<std::size_t> gain() const override { return find("AnalogueGain"); }
  CameraStats stats() const { return count_.stats(); }
  /// The state in words for people. RT: no.
  std::string state() const;
  /// The bad news of state(), in words that do not change with time.
  std::string trouble() const override;

 private:
  enum Holder : int { kNobody, kReader, kKeeper };  // the session's holder; see V4l2Camera
  struct Request {
    AnybodysNumber value{0};
    std::atomic<bool> pending{false};  // release after the value, acquire before it
  };

  LibcameraCamera(CameraSpec spec, Os& os);
  Result<std::unique_ptr<LibcameraSession>> open_session(std::string& why);
  Result<bool> read_held(msg::Image& out) noexcept;
  void call_keeper() noexcept;
  void keep() noexcept;
  bool serve();
  void adopt(std::unique_ptr<LibcameraSession> session);

  CameraSpec spec_;  // the keeper's; its controls follow the requests
  Os& os_;
  std::vector<CameraControl> controls_;
  std::unique_ptr<Request[]> requests_;
  bool rate_set_ = false;
  std::map<std::string, double, std::less<>> unsent_;  // keeper: controls that no request has carried yet

  WakeSlot wake_;                   // rung in libcamera's thread
  std::atomic<bool> ready_{false};  // something has come since read() last found nothing
  std::unique_ptr<LibcameraSession> session_;
  std::atomic<int> holder_{kNobody};
  Wide<std::int64_t> last_frame_ns_;
  FrameCount count_;
  mutable std::mutex mutex_;  // keeper and state()
  std::string trouble_;
  WakeWord bell_{0};
  std::atomic<bool> stop_{false};
  std::unique_ptr<Thread> keeper_;
};

/// `os` must outlive it.
Result<std::unique_ptr<LibcameraCamera>> open_libcamera_camera(const CameraSpec& spec, Os& os, std::string& why);

/// libcamera's names of the cameras of this machine.
std::vector<std::string> libcamera_names();

}  // namespace sinew::hal
