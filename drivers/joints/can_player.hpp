#pragma once
// Plays a log of `candump -l` into a bus: the drivers of one robot see what was once on another robot's bus.
#include <string>
#include <string_view>
#include <vector>

#include "hal/can_bus.hpp"

namespace sinew::drivers {

/// Frames go out at the distances in time that the log has, divided by the speed; the first one at once. Error frames
/// of the log are left out: no node can send one.
/// Thread:  owner.   RT: step() yes.
class CanPlayer {
 public:
  struct Options {
    double speed = 1;       // 0: everything at the first step()
    std::string interface;  // only this one's frames; empty: all
  };
  /// Takes over all lines of the log; empty lines are skipped. Errors: bad_data: `why` names the line and what is
  /// wrong; bad_argument: no frame of that interface is in it, or a speed below 0.
  static hal::Result<CanPlayer> open(std::string_view log, const Options& options, std::string& why);

  /// Sends the frames that are due at `now`. Answers when to call it again; kNever: all of them have been sent. A frame
  /// that the bus has no room for is tried again at the next step; a frame that the bus refuses is counted and left
  /// out.
  /// `now` never goes backwards.
  hal::Time step(hal::Time now, hal::CanBus& bus) noexcept;

  std::size_t frames() const noexcept { return frames_.size(); }
  struct Stats {
    std::uint64_t sent = 0, refused = 0, error_frames = 0;  // error_frames: left out
  };
  const Stats& stats() const noexcept { return stats_; }

 private:
  std::vector<msg::CanFrame> frames_;  // their stamps: since the first one, at this speed
  std::size_t next_ = 0;
  bool begun_ = false;
  hal::Time start_;
  Stats stats_;
};

}  // namespace sinew::drivers
