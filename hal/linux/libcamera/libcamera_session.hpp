#pragma once
// The only header that shows libcamera's types: for the files of this folder.
#include <libcamera/camera.h>
#include <libcamera/camera_manager.h>
#include <libcamera/framebuffer_allocator.h>
#include <libcamera/request.h>

#include <array>
#include <atomic>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "hal/camera_controls.hpp"
#include "hal/connectors.hpp"

namespace sinew::hal {

/// The process's one CameraManager, started; libcamera allows no second one. Lives as long as a caller holds it. Null:
/// it could not be started.
std::shared_ptr<libcamera::CameraManager> libcamera_manager();

/// One camera that streams: acquired, configured, its buffers mapped, one request per buffer on its way. A finished
/// request goes from libcamera's thread to take(), from give_back() to requeue(), and round again.
/// Thread:  open(), requeue(), destructor: owner. take(), give_back(): one other.
class LibcameraSession {
 public:
  struct Frame {
    std::uint32_t request = 0, sequence = 0;
    bool good = false;
    std::int64_t stamp_ns = 0;  // start of the exposure of the first row; 0: none
    std::int64_t exposure_ns = 0;
    std::span<const std::uint8_t> bytes;
  };
  using Wanted = std::map<std::string, double, std::less<>>;

  /// `arrived` is called in libcamera's thread for each finished request and when the camera goes away.
  static Result<std::unique_ptr<LibcameraSession>> open(const CameraSpec& spec, std::function<void()> arrived,
                                                        std::string& why);
  ~LibcameraSession();
  LibcameraSession(const LibcameraSession&) = delete;
  LibcameraSession& operator=(const LibcameraSession&) = delete;

  /// False: nothing has come. RT: yes.
  bool take(Frame& frame) noexcept;
  void give_back(std::uint32_t request) noexcept { back_[request].store(true, std::memory_order_release); }
  /// Sends returned requests on their way again; the first one carries these controls, which are then removed from the
  /// list. Errors: closed, io.
  Status requeue(Wanted& controls);
  /// True if a device of libcamera's has left /dev and libcamera has not reported it: it does so for its USB pipeline
  /// only, and from udevd. To stop such a camera ends the process: libcamera 0.0.3 asserts that all requests come back,
  /// and none do (seen with vimc). So a session in that state is not stopped, and its destructor leaks it.
  bool vanished() const;
  bool gone() const noexcept { return gone_.load(std::memory_order_acquire); }
  /// Begins and ends reading of the buffers by the processor, for the caches. RT: two short calls of the kernel.
  void begin_access(std::uint32_t request) noexcept;
  void end_access(std::uint32_t request) noexcept;

  const std::string& id() const { return id_; }
  std::uint32_t stride() const { return stride_; }
  std::uint32_t image_bytes() const { return image_bytes_; }
  bool rate_set() const { return rate_set_; }
  const std::vector<CameraControl>& controls() const { return controls_; }

 private:
  static constexpr std::size_t kRing = 64;  // more than there can be requests
  struct Mapping {
    void* start = nullptr;
    std::size_t length = 0;
    std::span<const std::uint8_t> bytes;
    int fd = -1;
  };

  explicit LibcameraSession(std::function<void()> arrived) : arrived_(std::move(arrived)) {}
  Status find(const std::string& name, std::string& why);
  Status configure(const CameraSpec& spec, std::string& why);
  Status map_buffers(std::string& why);
  Status start(const CameraSpec& spec, std::string& why);
  void list_controls();
  Status check(const Wanted& wanted, std::string& why) const;
  void put(libcamera::ControlList& list, const Wanted& wanted) const;
  void completed(libcamera::Request* request);
  void disconnected();

  std::function<void()> arrived_;
  std::shared_ptr<libcamera::CameraManager> manager_;
  std::shared_ptr<libcamera::Camera> camera_;
  bool acquired_ = false, running_ = false, rate_set_ = false;
  std::string id_;
  libcamera::Stream* stream_ = nullptr;
  std::uint32_t stride_ = 0, image_bytes_ = 0;
  std::unique_ptr<libcamera::FrameBufferAllocator> allocator_;
  std::vector<Mapping> mapped_;
  std::vector<std::unique_ptr<libcamera::Request>> requests_;
  std::vector<CameraControl> controls_;
  std::vector<const libcamera::ControlId*> codes_;  // same order

  std::array<Frame, kRing> ring_{};
  std::atomic<std::uint32_t> written_{0}, read_{0};  // written_: release in completed(), acquire in take()
  std::unique_ptr<std::atomic<bool>[]> back_;
  std::atomic<bool> gone_{false};
};

}  // namespace sinew::hal
