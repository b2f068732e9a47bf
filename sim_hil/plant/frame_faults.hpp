#pragma once
#include <deque>
#include <functional>
#include <span>
#include <vector>

#include "msg/image.hpp"
#include "sim_hil/server/plant_link.hpp"
#include "sim_hil/worlds/fault.hpp"

namespace sinew::plant {

/// Like SensorFaults, for the camera's frames. With faults a frame is drawn into memory of its own and copied into the
/// link's slot when it goes out, because frames that are held back must not occupy slots.
/// Thread:  owner.
class FrameFaults {
 public:
  using Send = std::function<hal::Status(std::span<const std::uint8_t> pixels, const sim_hil::FrameMeta& meta)>;
  FrameFaults(FaultLog& log, msg::PixelFormat format, std::uint32_t width, std::uint32_t height);
  bool any() const { return faults_.any(); }
  /// Where the next frame is drawn; until offer().
  std::span<std::uint8_t> canvas() { return drawn_; }
  hal::Status offer(sim_hil::FrameMeta meta, const Send& send);
  hal::Status release(hal::Time until, const Send& send);

 private:
  struct Held {
    std::vector<std::uint8_t> pixels;
    sim_hil::FrameMeta meta;
  };
  void move_right(double share);

  DeviceFaults faults_;
  std::uint32_t row_bytes_, unit_bytes_, height_;
  std::vector<std::uint8_t> drawn_, last_;
  std::deque<Held> held_;
  hal::Time last_ready_{0};
};

}  // namespace sinew::plant
