#pragma once
// One robot on the pitch with its motions, without the runtime: sensors in, targets out, each 10 ms.
#include <memory>
#include <string>

#include "apps/gait/gait_setup.hpp"
#include "motion/fall.hpp"
#include "motion/key_poses.hpp"
#include "motion/walk.hpp"
#include "sim_hil/pitch/pitch.hpp"

namespace sinew::gait {

inline constexpr double kControl_s = 0.01;
inline constexpr int kPlantSteps = 5;  // for each control step

/// Thread:  owner.
class Rig {
 public:
  /// Errors: null, with `why`. `setup` lives as long.
  static std::unique_ptr<Rig> create(const GaitSetup& setup, std::uint64_t seed, std::string& why,
                                     const plant::PitchPlace& start = {}, bool has_ball = false);

  /// What the robot knows now.
  motion::Sensed sense();
  /// Commands, and the plant 10 ms on.
  void act(std::span<const double> targets_rad);
  double now_s() const { return 1e-9 * static_cast<double>(pitch_->now_ns()); }
  const motion::Figure& figure() const { return figure_; }
  const GaitSetup& setup() const { return *setup_; }
  plant::Pitch& pitch() { return *pitch_; }
  const plant::BodyTruth& truth() const { return pitch_->truth(0); }

  /// With the setup's parameters.
  motion::Walk make_walk() const;
  std::span<double> targets() { return std::span(targets_rad_).first(figure_.joints()); }

 private:
  Rig(const GaitSetup& setup, const motion::Figure& figure) : setup_(&setup), figure_(figure) {}
  const GaitSetup* setup_;
  motion::Figure figure_;
  std::unique_ptr<plant::Pitch> pitch_;
  motion::JointAngles measured_rad_{}, targets_rad_{};
};

}  // namespace sinew::gait
