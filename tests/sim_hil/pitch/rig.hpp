#pragma once
// Bodies and postures for tests of the pitch.
#include <gtest/gtest.h>

#include "apps/toml/body_reader.hpp"
#include "kinematics/leg.hpp"
#include "sim_hil/pitch/pitch.hpp"

namespace sinew::test {
std::string source_dir();
}

namespace sinew::plant {

inline kinematics::Body kid_body(const std::string& name) {
  app::LoadedBody loaded = app::load_body(test::source_dir() + "/robots/kid/" + name + ".toml");
  for (const auto& p : loaded.problems) ADD_FAILURE() << rt::to_string(p, name.c_str());
  return loaded.body;
}

/// Standing with bent knees: both soles level, this far below where straight legs have them.
inline std::vector<double> crouched(const kinematics::Body& body, double down_m) {
  std::vector<double> rad(body.joints());
  const kinematics::BodyPose zero(body);
  for (const char* foot : {"l_ankle_roll", "r_ankle_roll"}) {
    std::string why;
    const std::size_t link = *body.find_link(foot);
    const auto leg = kinematics::Leg::make(body, link, why);
    EXPECT_TRUE(leg) << why;
    kinematics::Pose to = zero.link(link);
    to.p_m.z += down_m;
    const kinematics::LegAngles angles = leg->solve(to);
    EXPECT_TRUE(angles.reached);
    for (std::size_t i = 0; i < kinematics::kLegJoints; ++i) rad[leg->links()[i] - 1] = angles.rad[i];
  }
  return rad;
}

inline std::unique_ptr<Pitch> pitch_with(const PitchOptions& options, const std::vector<PitchBody>& bodies,
                                         std::uint64_t seed = 1) {
  std::string why;
  auto pitch = Pitch::create(options, bodies, seed, &why);
  EXPECT_TRUE(pitch) << why;
  return pitch ? std::move(*pitch) : nullptr;
}

inline void run(Pitch& pitch, double seconds) {
  const int steps = static_cast<int>(seconds * 1e9 / kPitchStepNs + 0.5);
  for (int i = 0; i < steps; ++i) pitch.step();
}

}  // namespace sinew::plant
