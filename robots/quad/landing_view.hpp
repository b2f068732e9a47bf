#pragma once
#include <array>

#include "math/linear.hpp"
#include "msg/flight.hpp"

namespace sinew::control {

struct LandingViewParams {
  double min_confidence = 0.5;  // sightings below are not used
  /// Lower than this above the pad the pad overfills the picture, and pictures are not used any more.
  double blind_below_m = 0.5;
  double lost_s = 0.6;  // without a sighting for so long: the pad is not known any more
  double gain = 0.5;    // of a sighting on offset and size, 0..1; that on the rates follows from it
  math::Quat q_base_optical{0, 0.70710678118654752, -0.70710678118654752, 0};  // looks down, top of image forward
};

/// What the camera sees of the landing pad, as a policy takes it: how far aside it is, how large, and how fast both
/// change.
/// The picture is levelled by the attitude, so that leaning does not look like moving. In the levelled picture the pad
/// has an offset (tangent of the angle from straight down) and a size (tangent of its radius). The pad's radius is
/// known, so radius / size is the height above the pad, and offset * height the distance aside; these are smoothed, and
/// their rates found, by a filter with fixed gains.
/// Without sightings the estimate goes on with the velocity of `nav`; likewise below blind_below_m, where nothing is
/// taken from the picture.
/// Frames:  world axes of NavState, z up.
/// Thread:  owner.   RT: yes.
class LandingView {
 public:
  LandingViewParams params;

  void reset();
  /// One picture, with or without the pad in it, and the newest estimate of attitude and velocity. Pictures that are
  /// not newer than the last are ignored.
  void see(const msg::PadSighting& sighting, const msg::NavState& nav);

  /// From the vehicle to the pad, along world x or y, and how fast that changes.
  double offset_m(std::size_t axis) const { return offset_m_[axis]; }
  double offset_mps(std::size_t axis) const { return offset_mps_[axis]; }
  double distance_m() const { return math::hypot(offset_m_[0], offset_m_[1]); }  // aside
  /// Of the camera above the pad.
  double height_m() const { return height_m_; }
  double height_mps() const { return height_mps_; }
  /// It was seen lately, or the vehicle has come so low that it does not look any more.
  bool known() const { return known_ != 0; }
  bool blind() const { return blind_ != 0; }

 private:
  struct Seen {
    std::array<double, 2> offset_m{};
    double height_m = 0;
  };
  bool measure(const msg::PadSighting& sighting, const msg::NavState& nav, Seen& seen) const;
  void use(const Seen& seen, double dt_s);

  std::array<double, 2> offset_m_{}, offset_mps_{};
  double height_m_ = 0, height_mps_ = 0, unseen_s_ = 0;
  msg::Time stamp_;
  std::uint32_t known_ = 0, blind_ = 0;  // bools would leave padding in a state
};

}  // namespace sinew::control
