#include "drivers/serial/gnss_receiver.hpp"

#include <cmath>
#include <limits>
#include <utility>

namespace sinew::drivers {

using namespace std::chrono_literals;

namespace {

constexpr double kUnknownGnss = std::numeric_limits<double>::quiet_NaN();
constexpr std::uint64_t kMuchGnssGarbage = 2000;  // bytes: more than any receiver sends between two good frames
constexpr hal::Duration kClockStands = 2s;        // the same instant for so long: the clock stands
constexpr hal::Duration kUbxHolds = 2s;           // after UBX, NMEA is ignored for so long

msg::GnssFix fix_of(int quality, int gsa) {
  using enum msg::GnssFix;
  switch (quality) {
    case 1:
    case 2:
    case 3:
      return gsa == 2 ? flat : full;
    case 4:
      return rtk_fixed;
    case 5:
      return rtk_float;
    default:
      return none;  // 6: dead reckoning, 7: typed in, 8: simulated
  }
}

// NaN (no time yet) is no instant.
bool same_instant(double a, double b) { return std::abs(a - b) < 0.005; }

}  // namespace

hal::Status GnssReceiver::set_up(std::string& why) {
  nmea_ = {}, ubx_ = {};
  gga_.reset(), rmc_.reset(), gsa_.reset(), pvt_.reset();
  bytes_ = 0;
  if (auto done = line_.open(why); !done) return done;
  if (!config_.configure_ubx) return {};
  std::array<std::uint8_t, 32> bytes{};
  for (const bool rate : {true, false}) {
    const std::size_t n =
        rate ? wire::encode_solution_rate(config_.period_ms, bytes) : wire::encode_enable_nav_pvt(bytes);
    if (auto done = line_.write({bytes.data(), n}); !done) {
      why = std::string("the receiver cannot be configured: ") + hal::to_string(done.error().code);
      return done;
    }
  }
  return {};
}

hal::Status GnssReceiver::poll(hal::Time now, std::vector<msg::GnssSample>& out, std::string& why) {
  const auto on_ubx = [&](std::span<const std::uint8_t> frame) {
    bytes_ = 0;
    if (const auto pvt = wire::decode_nav_pvt(frame)) on_solution(*pvt, now, out);
  };
  const auto on_nmea = [&](std::span<const std::uint8_t> frame) {
    bytes_ = 0;
    const auto s = wire::split_nmea(frame);
    if (s && !(pvt_ && now - *pvt_ < kUbxHolds)) on_sentence(*s, now, out);
  };
  const auto on_bytes = [&](std::span<const std::uint8_t> bytes) {
    for (const std::uint8_t b : bytes) {
      ++bytes_;
      ubx_.push(b, on_ubx);
      nmea_.push(b, on_nmea);
    }
  };
  if (auto done = line_.read(on_bytes, why); !done) return done;
  if (std::exchange(repeats_, false)) {
    why = "sends the same instant again and again (its clock stands; power it off and on)";
    return hal::Error{hal::Errc::bad_data, "gnss: repeats"};
  }
  if (bytes_ < kMuchGnssGarbage) return {};
  bytes_ = 0;
  why = "only garbage comes in; wrong bit rate? (receivers begin with 9600 or 38400 bit/s)";
  return hal::Error{hal::Errc::bad_data, "gnss: garbage"};
}

void GnssReceiver::on_solution(const wire::UbxPvt& pvt, hal::Time now, std::vector<msg::GnssSample>& out) {
  pvt_ = now;
  gga_.reset(), rmc_.reset();
  msg::GnssSample s = pvt.sample;
  const bool has = s.fix != msg::GnssFix::none && s.fix != msg::GnssFix::time;
  // Without a position its clock may stand for good reasons, and repeated samples do no harm.
  if (has && told_week_ms_ == pvt.time_of_week_ms) {
    repeats_ = now - told_at_ >= kClockStands;
    return;
  }
  told_week_ms_.reset();
  if (has) told_week_ms_ = pvt.time_of_week_ms;
  told_at_ = now;
  s.stamp = now - config_.delay;
  if (!has) s.latitude_deg = s.longitude_deg = s.altitude_m = kUnknownGnss;
  out.push_back(s);
}

void GnssReceiver::on_sentence(const wire::NmeaSentence& s, hal::Time now, std::vector<msg::GnssSample>& out) {
  if (const auto gsa = wire::decode_gsa(s)) {
    gsa_ = *gsa;
    return;
  }
  const auto gga = wire::decode_gga(s);
  const auto rmc = wire::decode_rmc(s);
  if (!gga && !rmc) return;
  const double time_s = gga ? gga->time_s : rmc->time_s;
  if (same_instant(told_s_, time_s)) {
    repeats_ = now - told_at_ >= kClockStands;
    return;
  }
  // A sentence of another instant (or without one, when there is no time yet) completes the sample that was begun. A
  // repeated sentence is not of another instant.
  if ((gga_ && !same_instant(gga_->time_s, time_s)) || (rmc_ && !same_instant(rmc_->time_s, time_s))) flush(now, out);
  if (!gga_ && !rmc_) came_in_ = now;
  if (gga) gga_ = *gga;
  if (rmc) rmc_ = *rmc;
  if (gga_ && rmc_) flush(now, out);
}

void GnssReceiver::flush(hal::Time now, std::vector<msg::GnssSample>& out) {
  if (gga_) {  // RMC alone has no height and no number of satellites
    out.push_back(combined());
    told_s_ = gga_->time_s;
    told_at_ = now;
  }
  gga_.reset(), rmc_.reset();
}

msg::GnssSample GnssReceiver::combined() const {
  msg::GnssSample s;
  s.stamp = came_in_ - config_.delay;
  s.fix = fix_of(gga_->quality, gsa_ ? gsa_->fix : 3);
  if (rmc_ && !rmc_->valid) s.fix = msg::GnssFix::none;
  const bool has = s.fix != msg::GnssFix::none;
  s.latitude_deg = has ? gga_->latitude_deg : kUnknownGnss;
  s.longitude_deg = has ? gga_->longitude_deg : kUnknownGnss;
  s.altitude_m = has ? gga_->altitude_m : kUnknownGnss;
  s.satellites = static_cast<std::uint32_t>(gga_->satellites);
  s.horizontal_accuracy_m = gga_->hdop * config_.error_per_hdop_m;
  s.vertical_accuracy_m = gsa_ ? gsa_->vdop * config_.error_per_hdop_m : kUnknownGnss;
  s.speed_accuracy_mps = kUnknownGnss;
  s.velocity_mps = {kUnknownGnss, kUnknownGnss, kUnknownGnss};
  if (rmc_ && has) {
    // Standing still, receivers leave the course out: then there is no velocity to point anywhere.
    const double course = std::isnan(rmc_->course_deg) ? 0 : rmc_->course_deg * wire::kRadPerDeg;
    if (!std::isnan(rmc_->course_deg) || rmc_->speed_mps < 0.5)
      s.velocity_mps = {rmc_->speed_mps * std::sin(course), rmc_->speed_mps * std::cos(course), kUnknownGnss};
  }
  return s;
}

}  // namespace sinew::drivers
