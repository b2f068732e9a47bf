#pragma once
// What a camera that looks down says about the vehicle's travel over the ground, and the height that follows from it.
#include "msg/geometry.hpp"

namespace sinew::msg {

/// How fast the ground passes below: speed over ground divided by the height, without the vehicle's own turning.
struct GroundMotion {
  Time stamp;                                    // of the newer picture
  std::int64_t interval_ns = 0;                  // between the two pictures
  double forward_radps = 0, left_radps = 0;      // base: > 0 where the vehicle travels forward, to the left
  double turn_forward_px = 0, turn_left_px = 0;  // a frame: what the turning made of it, already taken off; in bins
  double reading_x = 0, reading_y = 0;           // of the detector itself, in its own unit; image: x right, y down
  double shift_px = 0;                           // length of the whole shift a frame, in bins
  double contrast_grey = 0;                      // standard deviation of the picture
  std::uint32_t bin = 0;                         // pixels a side that were averaged
  std::uint32_t seen = 0;                        // there was enough texture
};

enum class AltitudePhase : std::uint32_t {
  wait = 0,
  spin_up = 1,
  climb = 2,
  speed_up = 3,
  follow = 4,
  land = 5,
  done = 6
};

inline constexpr ValueName kAltitudePhaseNames[] = {
    {"wait", AltitudePhase::wait},         {"spin_up", AltitudePhase::spin_up}, {"climb", AltitudePhase::climb},
    {"speed_up", AltitudePhase::speed_up}, {"follow", AltitudePhase::follow},   {"land", AltitudePhase::land},
    {"done", AltitudePhase::done}};

/// What the altitude controller believes and wants.
struct AltitudeState {
  Time stamp;
  double height_m = 0, climb_mps = 0;                // over the ground, at the wanted speed
  double airspeed_mps = 0, airspeed_left_mps = 0;    // by the accelerometer: base x and y
  double motion_radps = 0, wanted_motion_radps = 0;  // forward
  double pitch_rad = 0, roll_rad = 0, thrust_n = 0;  // commanded
  AltitudePhase phase = AltitudePhase::wait;
  std::uint32_t motion_fresh = 0;
};

template <>
struct Description<GroundMotion> {
  using M = GroundMotion;
  static constexpr std::string_view name = "GroundMotion",
                                    doc = "How fast the ground passes below, by the camera: speed over height.";
  static constexpr auto fields = describe(
      field<&M::stamp>("ns", "of the newer picture"), field<&M::interval_ns>("ns", "between the two"),
      field<&M::forward_radps>("rad/s", "base, turning taken off"), field<&M::left_radps>("rad/s", "likewise"),
      field<&M::turn_forward_px>("px", "a frame, in bins: taken off"), field<&M::turn_left_px>("px", "likewise"),
      field<&M::reading_x>("1", "the detector's own"), field<&M::reading_y>("1", "likewise"),
      field<&M::shift_px>("px", "a frame, in bins"), field<&M::contrast_grey>("1", "of the picture"),
      field<&M::bin>("px"), field<&M::seen>("1", "enough texture"));
};

template <>
struct Description<AltitudeState> {
  using M = AltitudeState;
  static constexpr std::string_view name = "AltitudeState", doc = "What the altitude controller believes and wants.";
  static constexpr auto fields =
      describe(field<&M::stamp>("ns"), field<&M::height_m>("m", "over the ground, at the wanted speed"),
               field<&M::climb_mps>("m/s", "likewise"), field<&M::airspeed_mps>("m/s", "forward, by the accelerometer"),
               field<&M::airspeed_left_mps>("m/s", "to the left"), field<&M::motion_radps>("rad/s", "forward"),
               field<&M::wanted_motion_radps>("rad/s"), field<&M::pitch_rad>("rad", "commanded"),
               field<&M::roll_rad>("rad", "commanded"), field<&M::thrust_n>("N", "commanded"),
               enum_field<&M::phase>(kAltitudePhaseNames), field<&M::motion_fresh>("1"));
};

}  // namespace sinew::msg
