#pragma once
// Messages of a head that follows a ball: what the camera saw, what the head does about it.
#include "msg/geometry.hpp"

namespace sinew::msg {

/// A ball in one image.
struct BallSighting {
  Time stamp;              // of the image
  Vec3 direction_optical;  // unit vector to the ball's centre, camera optical frame
  double u_px = 0, v_px = 0;
  double radius_px = 0;
  double angular_radius_rad = 0;
  double range_m = 0;     // from the known size of the ball; NaN when not measurable
  double confidence = 0;  // 0..1
  std::uint32_t found = 0;
  std::uint32_t blobs = 0;
};

enum class HeadMode : std::uint32_t {
  idle = 0,    // not permitted to move: commands nothing
  follow = 1,  // sees the ball
  coast = 2,   // out of sight for a moment: looks where it should be
  search = 3,  // sweeps, level
  hold = 4     // level and straight ahead: no pictures, or a failsafe asked for it
};

inline constexpr ValueName kHeadModeNames[] = {{"idle", HeadMode::idle},
                                               {"follow", HeadMode::follow},
                                               {"coast", HeadMode::coast},
                                               {"search", HeadMode::search},
                                               {"hold", HeadMode::hold}};

/// What the head does. Level frame: z up; x as in the estimate's world.
struct HeadState {
  Time stamp;
  Time mode_since;
  double azimuth_rad = 0, elevation_rad = 0;                // where it wants to look, level frame; up is positive
  double ball_azimuth_radps = 0, ball_elevation_radps = 0;  // estimated motion of the ball
  double axis_elevation_rad = 0;                            // of the optical axis, as the estimate has it
  double base_tilt_rad = 0;                                 // of what the head stands on
  double innovation_rad = 0;                                // of the last sighting, against the prediction
  HeadMode mode = HeadMode::idle;
  std::uint32_t sightings = 0;  // used since the start
};

template <>
struct Description<BallSighting> {
  static constexpr std::string_view name = "BallSighting", doc = "A ball in one image.";
  static constexpr auto fields = describe(
      field<&BallSighting::stamp>("ns"), field<&BallSighting::direction_optical>("1", "unit vector, optical frame"),
      field<&BallSighting::u_px>("px"), field<&BallSighting::v_px>("px"), field<&BallSighting::radius_px>("px"),
      field<&BallSighting::angular_radius_rad>("rad"), field<&BallSighting::range_m>("m", "NaN when not measurable"),
      field<&BallSighting::confidence>("1"), field<&BallSighting::found>("1"), field<&BallSighting::blobs>("1"));
};

template <>
struct Description<HeadState> {
  static constexpr std::string_view name = "HeadState", doc = "What a head that follows a ball does.";
  static constexpr auto fields =
      describe(field<&HeadState::stamp>("ns"), field<&HeadState::mode_since>("ns"),
               field<&HeadState::azimuth_rad>("rad", "wanted, level frame"),
               field<&HeadState::elevation_rad>("rad", "wanted, up is positive"),
               field<&HeadState::ball_azimuth_radps>("rad/s"), field<&HeadState::ball_elevation_radps>("rad/s"),
               field<&HeadState::axis_elevation_rad>("rad", "of the optical axis"),
               field<&HeadState::base_tilt_rad>("rad", "of what the head stands on"),
               field<&HeadState::innovation_rad>("rad", "of the last sighting"),
               enum_field<&HeadState::mode>(kHeadModeNames), field<&HeadState::sightings>("1", "used since the start"));
};

}  // namespace sinew::msg
