#pragma once
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "hal/linux/camera/v4l2_controls.hpp"
#include "hal/linux/camera/v4l2_format.hpp"

namespace sinew::hal {

/// The node for `name`: a path ("/dev/video0", "/dev/v4l/by-path/..."), a name of udev's ("usb-ACME_Cam-...", with or
/// without "-video-index0"), the bus ("usb-0000:00:14.0-3") or the device's own name ("ACME Cam"). Looked up again at
/// each opening, since a camera that is plugged in again may get another number.
/// Errors:  not_found, also when two devices fit; `why` names the devices that are there.
Result<std::string> v4l2_find(V4l2Port& port, const std::string& name, std::string& why);

/// A device that streams: opened, brought to its format, its buffers queued and filled by the driver. The buffers are
/// the driver's, mapped; or, after begin_lending(), memory of the caller (V4L2_MEMORY_USERPTR).
/// Thread:  owner; take(), give_back() and lend() may run on another thread, if one thread owns the session at a time.
class V4l2Session {
 public:
  /// Finds and opens spec.path, sets format and controls, starts the stream. With `room_bytes` it begins lending
  /// instead of starting the stream.
  /// Errors:  not_found, denied, busy, not_supported, bad_argument, bad_data, closed, io; nothing stays open. `why`
  ///          says it with the path and the remedy.
  static Result<std::unique_ptr<V4l2Session>> open(V4l2Port& port, const CameraSpec& spec, std::string& why,
                                                   std::uint32_t room_bytes = 0);
  ~V4l2Session();  // stops the stream, frees everything
  V4l2Session(const V4l2Session&) = delete;
  V4l2Session& operator=(const V4l2Session&) = delete;

  /// A buffer that the driver has filled.
  struct Filled {
    std::uint32_t index = 0, sequence = 0, flags = 0;
    std::int64_t stamp_ns = 0;  // the flags say which clock
    std::span<const std::uint8_t> bytes;
  };
  /// 1: one was taken; give it back. 0: none is ready; negative errno. RT: yes, never blocks.
  int take(Filled& filled) noexcept;
  /// 0 or negative errno. RT: yes.
  int give_back(std::uint32_t index) noexcept;

  // ---- memory of the caller: v4l2_lending.cpp
  /// Ends the stream into mapped buffers; from now on only lent memory is filled, after start(). Tries with a piece of
  /// memory whether the driver takes such memory. `room_bytes`: of each piece.
  /// Errors:  not_supported, bad_argument, io: unchanged, or broken: see streams(). `why` says it.
  Status begin_lending(const CameraSpec& spec, std::uint32_t room_bytes, std::string& why);
  /// Queues `memory`, unless it is queued already. 0 or negative errno. RT: yes.
  int lend(std::uint8_t* memory) noexcept;
  /// 0 or negative errno. Starting may take long on some cameras. RT: no.
  int start() noexcept;
  /// Afterwards nothing is filled or queued. RT: no.
  void stop() noexcept;
  bool lends() const { return lends_; }
  bool streams() const { return streaming_; }
  std::uint32_t queued() const { return queued_; }

  int fd() const { return fd_; }
  const std::string& path() const { return path_; }
  const V4l2Identity& identity() const { return identity_; }
  const V4l2Picture& picture() const { return picture_; }
  const V4l2Controls& controls() const { return controls_; }
  std::uint32_t buffers() const { return static_cast<std::uint32_t>(memory_.size()); }

 private:
  explicit V4l2Session(V4l2Port& port) : port_(port) {}
  Status begin(const CameraSpec& spec, std::uint32_t room_bytes, std::string& why);
  Status open_node(const std::string& name, std::string& why);
  Status start_stream(std::uint32_t buffers, std::string& why);
  void end_mapping() noexcept;
  Status may_lend(const CameraSpec& spec, std::uint32_t room_bytes, std::string& why) const;
  Status take_user_pointers(std::uint32_t buffers, std::string& why);
  int request_buffers(std::uint32_t memory, std::uint32_t& count) noexcept;
  int try_memory();
  int queue(std::uint32_t index) noexcept;

  V4l2Port& port_;
  int fd_ = -1;
  bool streaming_ = false, lends_ = false;
  std::string path_;
  V4l2Identity identity_;
  V4l2Picture picture_;
  V4l2Controls controls_;
  std::vector<std::span<std::uint8_t>> memory_;  // by the driver's index; lent: the last memory, or nothing
  std::vector<bool> is_queued_;                  // lent memory only
  std::uint32_t queued_ = 0;
};

}  // namespace sinew::hal
