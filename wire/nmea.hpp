#pragma once
// Sentences of satellite receivers: GGA, RMC, VTG and GSA of any talker (GP, GN, GL, GA, ...). Text: no byte order.
// Source:  NMEA 0183 as reproduced in u-blox UBX-13003221 (M8 receiver description) section 31.
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "wire/frame_scanner.hpp"

namespace sinew::wire {

/// "$TTSSS,field,...*hh" with CR LF behind it, or LF alone. Longer ones than the standard's 82 characters are taken.
struct NmeaFormat {
  static constexpr std::size_t kMaxFrame = 128;
  static FrameVerdict check(std::span<const std::uint8_t> bytes) noexcept;
};
using NmeaScanner = FrameScanner<NmeaFormat>;

/// A sentence whose checksum was right, cut at its commas. Points into the frame.
struct NmeaSentence {
  static constexpr std::size_t kMaxFields = 24;
  std::string_view talker, kind;  // "GN", "GGA"
  std::array<std::string_view, kMaxFields> field{};
  std::size_t count = 0;
  /// Empty: the receiver left it out, or there is none.
  std::string_view at(std::size_t i) const noexcept { return i < count ? field[i] : std::string_view{}; }
};
std::optional<NmeaSentence> split_nmea(std::span<const std::uint8_t> frame) noexcept;

/// A value that is not in its field is NaN (or -1).
struct NmeaGga {
  double time_s = 0;  // of the UTC day
  double latitude_deg = 0, longitude_deg = 0, altitude_m = 0, hdop = 0;
  int quality = 0;  // 0 none, 1 autonomous, 2 differential, 4 RTK fixed, 5 RTK float, 6 dead reckoning
  int satellites = 0;
};
struct NmeaRmc {
  double time_s = 0;
  bool valid = false;
  double latitude_deg = 0, longitude_deg = 0, speed_mps = 0, course_deg = 0;  // course: from north, clockwise
  int day = -1, month = -1, year = -1;
};
struct NmeaVtg {
  double course_deg = 0, speed_mps = 0;
};
struct NmeaGsa {
  int fix = 1;  // 1 none, 2 flat, 3 full
  double pdop = 0, hdop = 0, vdop = 0;
};
/// Nothing: another kind of sentence, or a field whose text is no valid number.
std::optional<NmeaGga> decode_gga(const NmeaSentence& s) noexcept;
std::optional<NmeaRmc> decode_rmc(const NmeaSentence& s) noexcept;
std::optional<NmeaVtg> decode_vtg(const NmeaSentence& s) noexcept;
std::optional<NmeaGsa> decode_gsa(const NmeaSentence& s) noexcept;

}  // namespace sinew::wire
