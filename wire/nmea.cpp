#include "wire/nmea.hpp"

#include <charconv>
#include <cmath>
#include <limits>

namespace sinew::wire {
namespace {

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
constexpr double kKnot = 1852.0 / 3600.0;  // m/s

int hex(std::uint8_t c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  return -1;
}

/// Reads numbers one after the other; remembers whether every field that is not empty could be read.
class Fields {
 public:
  explicit Fields(const NmeaSentence& s) : s_(s) {}
  double number(std::size_t i) {
    const std::string_view text = s_.at(i);
    if (text.empty()) return kUnknown;
    double value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value, std::chars_format::fixed);
    if (error == std::errc{} && end == text.data() + text.size() && std::isfinite(value)) return value;
    ok_ = false;
    return kUnknown;
  }
  int integer(std::size_t i, int absent) {
    const double value = number(i);
    if (std::isnan(value)) return absent;
    if (value < 0 || value > 1e6 || value != std::floor(value)) ok_ = false;
    return ok_ ? static_cast<int>(value) : absent;
  }
  /// "hhmmss.sss" as seconds of the day.
  double time(std::size_t i) {
    const double value = number(i);
    if (std::isnan(value)) return kUnknown;
    const double hours = std::floor(value / 10000), minutes = std::floor(value / 100) - hours * 100;
    const double rest = value - hours * 10000 - minutes * 100;
    if (value < 0 || hours > 23 || minutes > 59 || rest >= 61) ok_ = false;  // 60: a leap second
    return hours * 3600 + minutes * 60 + rest;
  }
  /// "ddmm.mmm" and its half of the world as degrees.
  double angle(std::size_t i, char positive, char negative, double most) {
    const double value = number(i);
    const std::string_view half = s_.at(i + 1);
    if (std::isnan(value)) return kUnknown;
    const double degrees = std::floor(value / 100), minutes = value - degrees * 100;
    const double angle = degrees + minutes / 60;
    if (half.size() != 1 || (half[0] != positive && half[0] != negative) || value < 0 || minutes >= 60 || angle > most)
      ok_ = false;
    return ok_ && half[0] == negative ? -angle : angle;
  }
  bool ok() const { return ok_; }

 private:
  const NmeaSentence& s_;
  bool ok_ = true;
};

template <class T>
std::optional<T> if_ok(const Fields& f, const T& value) {
  if (!f.ok()) return {};
  return value;
}

}  // namespace

FrameVerdict NmeaFormat::check(std::span<const std::uint8_t> bytes) noexcept {
  if (bytes[0] != '$') return {FrameVerdict::foreign};
  // Only the last byte is new, but checking all of them again is cheap: sentences are short.
  std::uint8_t sum = 0;
  for (std::size_t i = 1; i < bytes.size(); ++i) {
    const std::uint8_t c = bytes[i];
    if (c == '*') {
      if (bytes.size() < i + 3) return {FrameVerdict::more};
      const int high = hex(bytes[i + 1]), low = hex(bytes[i + 2]);
      return {high >= 0 && low >= 0 && high * 16 + low == sum ? FrameVerdict::good : FrameVerdict::broken, i + 3};
    }
    if (c < ' ' || c > '~' || c == '$') return {FrameVerdict::broken};
    sum ^= c;
  }
  return {FrameVerdict::more};
}

std::optional<NmeaSentence> split_nmea(std::span<const std::uint8_t> frame) noexcept {
  if (frame.size() < 9 || frame[0] != '$' || frame[frame.size() - 3] != '*') return {};
  std::string_view body(reinterpret_cast<const char*>(frame.data()) + 1, frame.size() - 4);
  const std::size_t comma = body.find(',');
  if (comma != 5) return {};  // makers' own sentences ($P...) have other addresses
  NmeaSentence s{body.substr(0, 2), body.substr(2, 3), {}, 0};
  body.remove_prefix(comma + 1);
  for (;;) {
    if (s.count == NmeaSentence::kMaxFields) return s;
    const std::size_t end = body.find(',');
    s.field[s.count++] = body.substr(0, end);
    if (end == std::string_view::npos) return s;
    body.remove_prefix(end + 1);
  }
}

std::optional<NmeaGga> decode_gga(const NmeaSentence& s) noexcept {
  if (s.kind != "GGA") return {};
  Fields f(s);
  const NmeaGga g{.time_s = f.time(0),
                  .latitude_deg = f.angle(1, 'N', 'S', 90),
                  .longitude_deg = f.angle(3, 'E', 'W', 180),
                  .altitude_m = f.number(8),
                  .hdop = f.number(7),
                  .quality = f.integer(5, 0),
                  .satellites = f.integer(6, 0)};
  return if_ok(f, g);
}

std::optional<NmeaRmc> decode_rmc(const NmeaSentence& s) noexcept {
  if (s.kind != "RMC") return {};
  Fields f(s);
  const int date = f.integer(8, -1);
  NmeaRmc r{.time_s = f.time(0),
            .valid = s.at(1) == "A",
            .latitude_deg = f.angle(2, 'N', 'S', 90),
            .longitude_deg = f.angle(4, 'E', 'W', 180),
            .speed_mps = f.number(6) * kKnot,
            .course_deg = f.number(7)};
  if (date >= 0) r.day = date / 10000, r.month = date / 100 % 100, r.year = 2000 + date % 100;
  return if_ok(f, r);
}

std::optional<NmeaVtg> decode_vtg(const NmeaSentence& s) noexcept {
  if (s.kind != "VTG") return {};
  Fields f(s);
  const NmeaVtg v{.course_deg = f.number(0), .speed_mps = f.number(6) / 3.6};
  return if_ok(f, v);
}

std::optional<NmeaGsa> decode_gsa(const NmeaSentence& s) noexcept {
  if (s.kind != "GSA") return {};
  Fields f(s);
  const NmeaGsa g{.fix = f.integer(1, 1), .pdop = f.number(14), .hdop = f.number(15), .vdop = f.number(16)};
  return if_ok(f, g);
}

}  // namespace sinew::wire
