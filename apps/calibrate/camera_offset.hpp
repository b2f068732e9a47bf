#pragma once
#include <optional>
#include <string>
#include <vector>

#include "math/linear.hpp"
#include "msg/sensors.hpp"

namespace sinew::app {

/// How far a camera's stamps are from those of an IMU, and how the camera is turned against the IMU: from the turns
/// that both measured while somebody turned the robot about all its axes.
///
/// For each delay a linear map and a bias are fitted, from the gyro integrated between the stamps of two pictures to
/// the turn between these pictures. The delay with the least residual is the offset (a correlation of rates in three
/// axes at once). Two parts of the map are the mount: the turn about the line of sight, and the exchange between the
/// two axes across it. Travel of the camera in a near scene and a wrong focal length do not change these two parts; the
/// other parts show both errors.
/// Source:  J. Furgale, J. Rehder, R. Siegwart, Unified temporal and spatial calibration for multi-sensor systems
///          (IROS 2013) for the problem; E. Mair et al., Spatio-temporal initialization for IMU to camera registration
///          (ROBIO 2011) for the correlation of angular rates.
/// Thread:  owner.   RT: no.
class CameraOffset {
 public:
  struct Result {
    double time_offset_ms = 0;    // to be added to the camera's stamps
    double time_sigma_ms = 0;     // 1 sigma by the residual; without errors common to all turns
    math::Quat q_imu_optical;     // optical frame to the IMU's
    math::Vec3 turned_deg;        // of q_imu_optical against the nominal, about the optical axes
    double scale = 1;             // turns across the line of sight, by the pictures / by the gyro
    double residual_radps = 0;    // RMS of an axis
    math::Vec3 excitation_radps;  // RMS rate about each optical axis, apart from the others'
    std::size_t pairs = 0;
  };
  static constexpr double kMostOffset_ms = 150;

  /// In the order of their stamps; others are left out.
  void add(const msg::ImuSample& sample);
  /// The camera's turn from the picture of one stamp to that of the next: q_older_newer, optical frame.
  void add(msg::Time older, msg::Time newer, const math::Vec3& rotation_rad);
  std::size_t pairs() const { return pairs_.size(); }
  /// `q_nominal`: from the robot file, at most 30 degrees off.
  /// Nothing: `why` says what was too little, or what does not fit.
  std::optional<Result> solve(const math::Quat& q_nominal, std::string& why) const;

 private:
  struct Turned {
    msg::Time at;
    math::Vec3 angle_rad;       // integrated gyro since the first sample, IMU frame
    std::uint32_t stretch = 0;  // without a gap
  };
  struct Pair {
    msg::Time older, newer;
    math::Vec3 rotation_rad;
  };
  struct Fit;
  std::optional<Turned> turned_by(double at_ns) const;
  Fit fit(const std::vector<Pair>& pairs, const math::Quat& q, double offset_ms) const;
  double best_offset_ms(const std::vector<Pair>& pairs, const math::Quat& q) const;
  std::vector<Pair> usable() const;

  std::vector<Turned> turned_;
  math::Vec3 last_radps_;
  std::vector<Pair> pairs_;
};

}  // namespace sinew::app
