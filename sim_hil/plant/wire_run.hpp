#pragma once
#include <functional>
#include <optional>

#include "sim_hil/plant/camera_feed.hpp"
#include "sim_hil/plant/session_options.hpp"
#include "sim_hil/plant/session_report.hpp"
#include "sim_hil/plant/wire_devices.hpp"

namespace sinew::plant {

/// A world without any connection to a runtime: a robot moves it and looks at it through its devices at the wire. In
/// real time, from the call of run() until the duration is over or it is asked to stop.
/// Thread:  owner; makes a SCHED_FIFO thread for the physics, and the camera has its own.
class WireRun {
 public:
  WireRun(hal::Os& os, CameraFeed& camera, WireDevices& wire, const SessionOptions& options);

  /// Asks `stop` every millisecond. Errors: of making the world, its devices or the thread; report().reason has it.
  hal::Status run(const std::function<bool()>& stop);
  const SessionReport& report() const { return report_; }

 private:
  hal::Status open();
  void advance_one_ms();
  void begin_frame();
  void finish_frame();
  void loop(const std::function<bool()>& stop);

  hal::Os& os_;
  CameraFeed& feed_;
  WireDevices& wire_;
  const SessionOptions options_;
  std::unique_ptr<World> world_;
  std::int64_t camera_delay_ns_ = 0;
  hal::Time host_zero_{};  // the host's clock at plant time 0
  struct Frame {
    hal::Time stamp;
    std::uint32_t number = 0;
  };
  std::optional<Frame> drawn_;  // the frame in work
  std::uint32_t frame_number_ = 0;
  SessionReport report_;
};

}  // namespace sinew::plant
