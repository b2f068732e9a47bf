#pragma once
// The OP3 class body of robots/kid with its motions, and a puppet of it: joints that are where they were told to be.
#include <gtest/gtest.h>

#include "apps/toml/body_reader.hpp"
#include "apps/toml/motion_reader.hpp"
#include "motion/figure.hpp"
#include "motion/walk.hpp"
#include "source_dir.hpp"

namespace sinew::motion {

inline constexpr double kStep_s = 0.01;

struct Op3 {
  kinematics::Body body;
  MotionBook book;
  std::optional<Figure> figure;

  explicit Op3(const char* name = "op3") {
    const std::string path = test::source_dir() + "/robots/kid/" + name;
    auto loaded = app::load_body(path + ".toml");
    EXPECT_TRUE(loaded.problems.empty());
    body = std::move(loaded.body);
    auto motions = app::load_motions(path + "_motion.toml", body);
    EXPECT_TRUE(motions.problems.empty());
    book = std::move(motions.book);
    std::string why;
    figure = Figure::make(body, why);
    EXPECT_TRUE(figure) << why;
  }
};

/// Sensors of a body that does what the plan says: upright, on the sole that the walk says, from `lands_at` of a step
/// on also on the other one.
struct Puppet {
  const Op3& op3;
  std::vector<double> joints_rad, targets_rad;
  math::Vec3 gyro_radps, accel_mps2{0, 0, 9.81};
  double lands_at = 1;  // part of a step; above 2: never

  explicit Puppet(const Op3& of) : op3(of), joints_rad(of.body.joints()), targets_rad(of.body.joints()) {}

  Sensed sensed(const Walk* walk = nullptr, double part = 0) const {
    const double weight_n = op3.figure->mass_kg() * 9.81;
    Sensed s{joints_rad, gyro_radps, accel_mps2, {}};
    const bool both = walk == nullptr || walk->phase() != WalkPhase::step || part >= lands_at;
    for (const Side side : kSides)
      if (both || walk->support() == side) s.soles_n[index(side)].fill(weight_n / (both ? 8 : 4));
    return s;
  }
  void step(Walk& walk, const WalkCommand& command) {
    const std::uint64_t before = walk.steps();
    const double period = walk.params.period_s;
    walk.step(command, sensed(&walk, in_step_s_ / period), kStep_s, targets_rad);
    in_step_s_ = walk.steps() != before || walk.phase() != WalkPhase::step ? 0 : in_step_s_ + kStep_s;
    joints_rad = targets_rad;
  }

 private:
  double in_step_s_ = 0;
};

}  // namespace sinew::motion
