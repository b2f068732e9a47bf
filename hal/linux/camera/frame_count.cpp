#include "hal/linux/camera/frame_count.hpp"

namespace sinew::hal {

bool FrameCount::arrived(std::uint32_t sequence, std::optional<Time> stamp) noexcept {
  if (!first_ && stamp && last_stamp_ && *stamp <= *last_stamp_) {
    repeated_.add();
    return false;
  }
  const std::uint32_t step = sequence - last_sequence_;  // wraps with the driver's
  // A driver that restarts its count, or does not count, shows no losses.
  const bool counts = step != 0 && step < 0x8000'0000U;
  if (first_) {
    // After a restart at least the frame that broke the stream is missing; the very first frame has the driver's
    // number.
    number_ = streams_ > 1 ? number_ + 2 : sequence;
  } else {
    number_ += counts ? step : 1;
    if (counts) lost_.add(step - 1);
    if (stamp && last_stamp_) {
      const std::int64_t interval = (stamp->ns - last_stamp_->ns) / (counts ? step : 1);
      const std::int64_t mean = interval_ns_.load();
      interval_ns_.store(mean == 0 ? interval : mean + (interval - mean) / 8);
    }
  }
  first_ = false;
  last_sequence_ = sequence;
  if (stamp) last_stamp_ = stamp;
  return true;
}

bool FrameCount::stream_begins() noexcept {
  ++streams_;
  first_ = true;
  last_stamp_.reset();
  interval_ns_.store(0);
  tries_.n.store(0);
  return streams_ > 1;
}

CameraStats FrameCount::stats() const noexcept {
  return {.frames = frames_.get(),
          .lost = lost_.get(),
          .corrupted = corrupted_.get(),
          .repeated = repeated_.get(),
          .too_large = too_large_.get(),
          .unstamped = unstamped_.get(),
          .reopens = reopens_.get(),
          .tries = tries_.get()};
}

double FrameCount::rate_hz() const noexcept {
  const std::int64_t interval = interval_ns_.load();
  return interval > 0 ? 1e9 / static_cast<double>(interval) : 0;
}

std::string FrameCount::text() const {
  const CameraStats s = stats();
  std::string text;
  const auto count = [&text](std::uint64_t n, const char* what) {
    if (n != 0) text += "; " + std::to_string(n) + " " + what;
  };
  count(s.lost, "frames lost");
  count(s.corrupted, "corrupted");
  count(s.repeated, "repeated (no newer than the one before)");
  count(s.too_large, "too large for the topic");
  count(s.unstamped, "without a usable stamp of the driver");
  count(s.reopens, s.reopens == 1 ? "time opened again" : "times opened again");
  return text;
}

}  // namespace sinew::hal
