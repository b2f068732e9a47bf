#pragma once
#include <array>
#include <atomic>
#include <memory>
#include <string>
#include <vector>

#include "hal/connectors.hpp"
#include "hal/linux/camera/jpeg_decoder.hpp"
#include "hal/os.hpp"
#include "hal/self_report.hpp"
#include "hal/sensor_queue.hpp"
#include "hal/stream.hpp"
#include "hal/wake_slot.hpp"
#include "hal/wide.hpp"
#include "msg/image_buffer.hpp"
#include "wire/text/usarsim_images.hpp"

namespace sinew::hal {

/// Counted since it was opened.
struct ImageServerStats {
  std::uint64_t pictures = 0;     // handed on
  std::uint64_t refused = 0;      // of another size, or not decodable
  std::uint64_t broken = 0;       // what came was no picture: the connection was made anew
  std::uint64_t connections = 0;  // made
};

/// The picture of a simulator's image server (USARSim's, TCP port 5003) as a camera. A thread of its own asks for one
/// picture a period, receives and decodes it; while the robot takes none it asks for none. It opens without a server,
/// and goes on when the server comes, ends and comes again (after 0.1 s, later each 2 s).
/// Stamps:  the server says none: the middle between the request and the first byte of the answer. frame_number counts
///          this camera's pictures.
/// Thread:  read(): owner; stats(), trouble(): any.
/// RT:      read() yes: one copy of the pixels.
/// Errors:  read(): closed while there is no server, or it has sent nothing for `silent`; bad_argument when the topic's
///          images are too small.
class ImageServerCamera final : public Camera, public SelfReport {
 public:
  /// Errors:  bad_argument: the spec; not_supported: JPEG only, and this build has no decoder; io: no thread. `why` has
  ///          it in words.
  static Result<std::unique_ptr<Camera>> open(const ImageServerSpec& spec, Os& os, std::string& why);
  ~ImageServerCamera() override;
  ImageServerCamera(const ImageServerCamera&) = delete;
  ImageServerCamera& operator=(const ImageServerCamera&) = delete;

  Time ready_at() const noexcept override { return full_.load(std::memory_order_acquire) != 0 ? Time{0} : kNever; }
  void set_wake(Wake* wake) noexcept override { wake_.change(wake); }
  Result<bool> read(msg::Image& out) noexcept override;

  ImageServerStats stats() const;
  std::string trouble() const override { return trouble_.get(); }
  std::string shortfall() const override { return thread_ ? thread_->shortfall() : std::string(); }

 private:
  ImageServerCamera(const ImageServerSpec& spec, Os& os);
  bool stopping() const noexcept { return stop_.load(std::memory_order_acquire) != 0; }
  void run() noexcept;
  bool connect();
  void lose(const std::string& why);
  void tell(const std::string& what);
  void wait_for_turn();
  /// False: the connection is lost.
  bool fetch();
  bool receive(std::span<std::uint8_t> into, Time& first);
  bool take_raw();
  bool take_jpeg();

  const ImageServerSpec spec_;
  Os& os_;
  JpegDecoder decoder_;
  msg::ImageBuffer picture_;  // the thread's while full_ is 0, then the reader's
  WakeWord full_{0};
  WakeSlot wake_;
  std::atomic<bool> there_{false};
  WakeWord stop_{0};

  // The thread's own.
  std::unique_ptr<Stream> stream_;
  std::vector<std::uint8_t> bytes_;
  Duration pause_{};
  Time due_{};
  std::uint32_t number_ = 0;

  Tally pictures_, refused_, broken_, connections_;
  TroubleText trouble_;
  std::unique_ptr<Thread> thread_;  // last: ends before what it uses
};

}  // namespace sinew::hal
