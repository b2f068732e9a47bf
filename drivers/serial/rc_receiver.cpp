#include "drivers/serial/rc_receiver.hpp"

#include <limits>

namespace sinew::drivers {

using namespace std::chrono_literals;

namespace {
constexpr double kUnknownRc = std::numeric_limits<double>::quiet_NaN();
constexpr hal::Duration kPause = 3ms;  // between SBUS frames at least 4 ms
constexpr double kQualityShare = 1.0 / 32;
}  // namespace

hal::Status RcReceiver::set_up(std::string& why) {
  sbus_ = {}, crsf_ = {};
  quality_ = config_.protocol == RcProtocol::sbus ? 1 : kUnknownRc;
  rssi_dbm_ = kUnknownRc;
  begun_ = false;
  return line_.open(why);
}

hal::Status RcReceiver::poll(hal::Time now, std::vector<msg::RcSample>& out, std::string& why) {
  if (!begun_) last_told_ = last_byte_ = now;
  begun_ = true;
  const auto on_bytes = [&](std::span<const std::uint8_t> bytes) {
    if (now - last_byte_ >= kPause) sbus_.gap();
    last_byte_ = now;
    for (const std::uint8_t b : bytes) {
      if (config_.protocol == RcProtocol::sbus)
        sbus_.push(b, [&](const wire::SbusFrame& f) { on_sbus(f, now, out); });
      else
        crsf_.push(b, [&](std::span<const std::uint8_t> f) { on_crsf(f, now, out); });
    }
  };
  if (auto done = line_.read(on_bytes, why); !done) return done;
  if (!out.empty()) last_told_ = now;
  if (now - last_told_ < config_.lost_after) return {};
  last_told_ = now;
  // The first frames after an outage count at once; CRSF tells its quality again.
  quality_ = config_.protocol == RcProtocol::sbus ? 0 : kUnknownRc;
  out.push_back(lost(now));
  return {};
}

void RcReceiver::on_sbus(const wire::SbusFrame& frame, hal::Time now, std::vector<msg::RcSample>& out) {
  const bool missed = frame.frame_lost || frame.failsafe;
  quality_ += ((missed ? 0.0 : 1.0) - quality_) * kQualityShare;
  // A missed frame repeats the last sticks: nothing new. Failsafe sticks are made up: the link is lost.
  if (frame.failsafe)
    out.push_back(lost(now));
  else if (!frame.frame_lost)
    out.push_back(sample(frame.channel, now));
}

void RcReceiver::on_crsf(std::span<const std::uint8_t> frame, hal::Time now, std::vector<msg::RcSample>& out) {
  if (const auto link = wire::decode_crsf_link(frame)) {
    quality_ = link->link_quality;
    rssi_dbm_ = link->rssi_dbm;
    if (quality_ == 0) out.push_back(lost(now));
    return;
  }
  const auto counts = wire::decode_crsf_channels(frame);
  if (!counts) return;
  // Some receivers go on sending their failsafe values with a quality of 0.
  out.push_back(quality_ == 0 ? lost(now) : sample(*counts, now));
}

msg::RcSample RcReceiver::sample(const wire::RcCounts& counts, hal::Time now) const {
  msg::RcSample s;
  s.stamp = now;
  for (std::size_t i = 0; i < counts.size(); ++i) s.channel[i] = wire::rc_stick(counts[i]);
  s.link_quality = quality_;
  s.rssi_dbm = rssi_dbm_;
  s.count = static_cast<std::uint32_t>(counts.size());
  return s;
}

msg::RcSample RcReceiver::lost(hal::Time now) const {
  msg::RcSample s;
  s.stamp = now;
  s.rssi_dbm = rssi_dbm_;
  s.count = 16;
  s.lost = 1;
  return s;
}

}  // namespace sinew::drivers
