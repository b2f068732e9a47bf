#pragma once
#include "math/linear.hpp"
#include "math/random.hpp"
#include "msg/flight.hpp"
#include "sim_hil/worlds/world.hpp"

namespace sinew::learning {

/// How the real detector errs: measured with tools/pad_errors.py on recorded flights with pictures (docs/learning.md).
struct PadCameraParams {
  double width_px = 320, height_px = 240;
  double centre_px = 0.08;      // standard deviation of the pad's centre, each axis, and
  double centre_share = 0.003;  // of its radius in the picture
  double size_px = 0.65;        // the radius is reported larger by this, with
  double size_share = 0.005;    // a standard deviation of this share
  double late_ms = 1.6;         // execution of the detector, after the picture is there
};

/// The pad as the camera and its detector would report it, without a picture: from the pose of the camera, with the
/// detector's noise and the camera's field of view. The pad is found while enough of its edge, or of the ring inside,
/// is in sight. Thread:  owner.
class PadCamera {
 public:
  explicit PadCamera(std::uint64_t seed, const PadCameraParams& params = {}) : params_(params), noise_(seed, 0x9ad) {}

  msg::PadSighting look(const plant::CameraPose& camera, msg::Time stamp);
  /// From the middle of the exposure until modules have the sighting.
  msg::Duration delay() const;

 private:
  double seen_share(const plant::CameraPose& camera, double radius_m) const;

  PadCameraParams params_;
  math::Random noise_;
};

}  // namespace sinew::learning
