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

}  // namespace sinew::msg
