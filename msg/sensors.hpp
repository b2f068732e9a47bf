#pragma once
// What sensors measure, in SI units and REP-103 frames (base: x forward, y left, z up).
#include "msg/geometry.hpp"

namespace sinew::msg {

/// Angular rate and specific force (what an accelerometer feels: +g upward at rest) in the base frame.
struct ImuSample {
  Time stamp;
  Vec3 gyro_radps;
  Vec3 accel_mps2;
};

/// Distance along the beam of a range finder; NaN when nothing is in range.
struct RangeSample {
  Time stamp;
  double range_m = 0;
};

struct BaroSample {
  Time stamp;
  double pressure_pa = 0;
  double temperature_c = 0;
};

/// What a power module or a fuel gauge says.
struct BatterySample {
  Time stamp;
  double voltage_v = 0;  // at its terminals, under load
  double current_a = 0;  // drawn from it
  double charge = 0;     // 0..1 of the usable charge; NaN when the device does not know
};

inline constexpr std::size_t kSoleCells = 8;

/// Forces on the cells under the feet of a robot with two legs.
struct SolePressure {
  Time stamp;
  std::array<double, kSoleCells>
      force_n{};  // left: front left, front right, rear left, rear right; then right: the same
};

/// Magnetic flux density in the base frame.
struct MagSample {
  Time stamp;
  Vec3 field_t;
};

enum class GnssFix : std::uint32_t { none = 0, time = 1, flat = 2, full = 3, rtk_float = 4, rtk_fixed = 5 };

inline constexpr ValueName kGnssFixNames[] = {{"none", GnssFix::none},
                                              {"time only", GnssFix::time},
                                              {"two-dimensional", GnssFix::flat},
                                              {"three-dimensional", GnssFix::full},
                                              {"RTK float", GnssFix::rtk_float},
                                              {"RTK fixed", GnssFix::rtk_fixed}};

/// Position and velocity of the antenna from satellites (WGS 84). Values that the receiver does not give are NaN.
struct GnssSample {
  Time stamp;  // when it was valid, as far as the receiver tells; else when it came in
  double latitude_deg = 0, longitude_deg = 0;
  double altitude_m = 0;                                                              // above mean sea level
  Vec3 velocity_mps;                                                                  // world: x east, y north, z up
  double horizontal_accuracy_m = 0, vertical_accuracy_m = 0, speed_accuracy_mps = 0;  // one sigma
  GnssFix fix = GnssFix::none;
  std::uint32_t satellites = 0;  // used
};

inline constexpr std::size_t kMaxRcChannels = 16;

/// The sticks and switches of a pilot.
struct RcSample {
  Time stamp;
  std::array<double, kMaxRcChannels> channel{};  // -1..1; 0 at the middle of a stick
  double link_quality = 0;                       // 0..1 of the frames that should have come; NaN when unknown
  double rssi_dbm = 0;                           // NaN when unknown
  std::uint32_t count = 0;                       // channels in use
  std::uint32_t lost = 0;                        // 1: the receiver has no transmitter; the channels mean nothing
};

template <>
struct Description<ImuSample> {
  static constexpr std::string_view name = "ImuSample", doc = "Angular rate and specific force in the base frame.";
  static constexpr auto fields = describe(field<&ImuSample::stamp>("ns", "middle of the sampling interval"),
                                          field<&ImuSample::gyro_radps>("rad/s", "base frame"),
                                          field<&ImuSample::accel_mps2>("m/s^2", "base frame, +g upward at rest"));
};

template <>
struct Description<RangeSample> {
  static constexpr std::string_view name = "RangeSample", doc = "Distance along the beam of a range finder.";
  static constexpr auto fields =
      describe(field<&RangeSample::stamp>("ns"), field<&RangeSample::range_m>("m", "NaN when nothing is in range"));
};

template <>
struct Description<BaroSample> {
  static constexpr std::string_view name = "BaroSample", doc = "Static air pressure.";
  static constexpr auto fields = describe(field<&BaroSample::stamp>("ns"), field<&BaroSample::pressure_pa>("Pa"),
                                          field<&BaroSample::temperature_c>("degC"));
};

template <>
struct Description<BatterySample> {
  static constexpr std::string_view name = "BatterySample", doc = "Voltage, current and charge of a battery.";
  static constexpr auto fields =
      describe(field<&BatterySample::stamp>("ns"), field<&BatterySample::voltage_v>("V", "at its terminals"),
               field<&BatterySample::current_a>("A", "drawn from it"),
               field<&BatterySample::charge>("1", "0..1, NaN when unknown"));
};

template <>
struct Description<SolePressure> {
  static constexpr std::string_view name = "SolePressure", doc = "Forces on the cells under the feet.";
  static constexpr auto fields = describe(
      field<&SolePressure::stamp>("ns"),
      field<&SolePressure::force_n>("N", "left: front left, front right, rear left, rear right; then right: the same"));
};

template <>
struct Description<MagSample> {
  static constexpr std::string_view name = "MagSample", doc = "Magnetic flux density in the base frame.";
  static constexpr auto fields =
      describe(field<&MagSample::stamp>("ns"), field<&MagSample::field_t>("T", "base frame"));
};

template <>
struct Description<GnssSample> {
  static constexpr std::string_view name = "GnssSample", doc = "Position and velocity from satellites.";
  static constexpr auto fields = describe(
      field<&GnssSample::stamp>("ns"), field<&GnssSample::latitude_deg>("deg", "WGS 84"),
      field<&GnssSample::longitude_deg>("deg", "WGS 84"), field<&GnssSample::altitude_m>("m", "above mean sea level"),
      field<&GnssSample::velocity_mps>("m/s", "x east, y north, z up"),
      field<&GnssSample::horizontal_accuracy_m>("m", "one sigma"),
      field<&GnssSample::vertical_accuracy_m>("m", "one sigma"),
      field<&GnssSample::speed_accuracy_mps>("m/s", "one sigma"), enum_field<&GnssSample::fix>(kGnssFixNames),
      field<&GnssSample::satellites>("1", "used"));
};

template <>
struct Description<RcSample> {
  static constexpr std::string_view name = "RcSample", doc = "The sticks and switches of a pilot.";
  static constexpr auto fields =
      describe(field<&RcSample::stamp>("ns"), field<&RcSample::channel>("1", "-1..1"),
               field<&RcSample::link_quality>("1", "0..1; NaN when unknown"),
               field<&RcSample::rssi_dbm>("dBm", "NaN when unknown"), field<&RcSample::count>("1", "channels in use"),
               field<&RcSample::lost>("1", "1: no transmitter; the channels mean nothing"));
};

}  // namespace sinew::msg
