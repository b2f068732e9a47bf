#include "net/bridge/shared.hpp"

#include <algorithm>

#include "hal/platform.hpp"
#include "net/bridge/robot_client.hpp"

namespace sinew::net {
namespace {

using namespace std::chrono_literals;

constexpr auto kClockSilence = 5s;
/// A clock whose sender is restarted, or that jumps by more, begins anew.
constexpr std::int64_t kClockJumpNs = 1'000'000'000;
/// An offset is known too small by the delay of its message. The largest of late counts, and fades by this share of the
/// difference with each message, so that a slower clock is followed, too.
constexpr std::int64_t kFade = 50;

}  // namespace

void BridgeShared::stop() {
  stop_.store(true, std::memory_order_release);
  notify();
}

void BridgeShared::notify() {
  const std::lock_guard lock(mutex_);
  ++notes_;
  changed_.notify_all();
}

void BridgeShared::wait(std::uint64_t& seen, hal::Duration longest) {
  std::unique_lock lock(mutex_);
  changed_.wait_for(lock, longest, [&] { return notes_ != seen; });
  seen = notes_;
}

void BridgeShared::heard_clock(std::int64_t ros_ns, hal::Time at) {
  const std::lock_guard lock(mutex_);
  const std::int64_t offset = ros_ns - at.ns;
  if (!clock_heard_ || offset > clock_offset_ns_ || clock_offset_ns_ - offset > kClockJumpNs)
    clock_offset_ns_ = offset;
  else
    clock_offset_ns_ -= (clock_offset_ns_ - offset) / kFade;
  clock_heard_ = at;
}

std::optional<std::int64_t> BridgeShared::to_ros_ns(std::int64_t robot_offset_ns) const {
  if (spec.clock == ros2::ClockUse::follow) {
    const std::lock_guard lock(mutex_);
    if (!clock_heard_ || hal::system_os().now() - *clock_heard_ > kClockSilence) return {};
    return clock_offset_ns_ - robot_offset_ns;
  }
  if (spec.stamps == ros2::Stamps::robot) return 0;
  return wall_minus_monotonic() - robot_offset_ns;
}

}  // namespace sinew::net
