#pragma once
#include <chrono>
#include <cstdint>
#include <deque>

#include "monitor/foxglove/robot.hpp"
#include "monitor/http/server.hpp"

namespace sinew::foxglove {

/// How many pictures one connection has under way, and how large they are, so that what its viewer sees is young: a
/// picture that waits in buffers of the network is old when it arrives.
///
/// A picture is delivered when the peer's system has acknowledged its last byte. Pictures get smaller when most of the
/// last ones took long, beyond what the link's round trip takes alone, and larger again when they did not; the longer,
/// the more often larger ones were too large. One picture late by a lost packet changes nothing.
/// Thread:  owner.
class PicturePace {
 public:
  using Clock = std::chrono::steady_clock;
  using Duration = Clock::duration;

  /// Notes what was delivered meanwhile.
  void look(Clock::time_point now, const Link& link);
  /// Whether another picture may be sent.
  bool may_send(const Link& link) const;
  /// A picture's last byte has gone to the system.
  void sent(Clock::time_point now, const Link& link);
  PictureSize size() const;
  /// Some are under way: look() again soon.
  bool waits() const { return !under_way_.empty(); }
  std::size_t under_way() const { return under_way_.size(); }
  int step() const { return step_; }
  static int steps();

  static constexpr std::chrono::milliseconds kSlow{70}, kQuick{35};  // beyond the shortest round trip
  static constexpr std::chrono::milliseconds kMostHold{16000};

 private:
  struct Picture {
    std::uint64_t end;  // its last byte among all of the connection
    Clock::time_point at;
  };
  void delivered(Clock::time_point now, Duration beyond);
  void change(Clock::time_point now, int by);

  std::deque<Picture> under_way_;
  std::deque<bool> slow_;  // the last ones
  int step_ = 0, quick_ = 0;
  bool was_slow_ = false;  // ever
  Clock::time_point larger_at_{};
  Duration hold_ = std::chrono::milliseconds(500);  // until the next try to send larger ones
  Clock::time_point hold_until_{};
};

}  // namespace sinew::foxglove
