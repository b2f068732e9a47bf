// Base inertial parameters of chains whose torques come from the energy of their links, which the regressor knows
// nothing of.
#include "identify/base_parameters.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>

#include "math/random.hpp"

namespace sinew::identify::base_parameters_test {
namespace {

using kinematics::Body;
using kinematics::BodyPose;
using math::Vec3;

/// Three links on a torso: about z, y and x, the last one beside the others' axes.
Body arm() {
  Body body;
  body.name = "arm";
  body.servos = {{"servo", 4, 5, 0.004}};
  body.links.resize(4);
  const char* const names[] = {"torso", "yaw", "shoulder", "elbow"};
  for (std::size_t i = 0; i < 4; ++i) {
    body.links[i].name = names[i];
    if (i == 0) continue;
    body.links[i].parent = i - 1;
    body.links[i].servo = 0;
    body.links[i].least_rad = -2, body.links[i].most_rad = 2;
    body.links[i].mass_kg = 0.2 + 0.1 * static_cast<double>(i);
    body.links[i].com_m = {0.01, 0.02 * static_cast<double>(i), -0.05};
    body.links[i].inertia_kgm2 = {4e-4, 5e-4, 3e-4, 2e-5, -3e-5, 1e-5};
  }
  body.links[1].axis = {0, 0, 1}, body.links[1].at_m = {0, 0, 0.1};
  body.links[2].axis = {0, 1, 0}, body.links[2].at_m = {0.02, 0, 0.05};
  body.links[3].axis = {1, 0, 0}, body.links[3].at_m = {0.01, 0.03, -0.12};
  return body;
}

/// Kinetic energy less potential energy of all links, by where each is and how it moves.
double lagrangian(const Body& body, std::span<const double> q, std::span<const double> v, const Vec3& gravity) {
  BodyPose pose(body);
  pose.set(q);
  double sum = 0;
  std::vector<Vec3> linear(body.joints()), angular(body.joints());
  for (std::size_t i = 1; i < body.links.size(); ++i) {
    const kinematics::Link& link = body.links[i];
    pose.jacobian(i, link.com_m, linear, angular);
    Vec3 speed, turn;
    for (std::size_t j = 0; j < body.joints(); ++j) speed += v[j] * linear[j], turn += v[j] * angular[j];
    const Vec3 w = pose.link(i).q.conjugate().rotate(turn);
    const auto& c = link.inertia_kgm2;
    const Vec3 spin{c[0] * w.x + c[3] * w.y + c[4] * w.z, c[3] * w.x + c[1] * w.y + c[5] * w.z,
                    c[4] * w.x + c[5] * w.y + c[2] * w.z};
    sum += 0.5 * link.mass_kg * dot(speed, speed) + 0.5 * dot(w, spin) +
           link.mass_kg * dot(gravity, pose.link(i).of(link.com_m));
  }
  return sum;
}

/// d/dt (dL/dv) - dL/dq, by differences, for joints that move as q(t).
template <class Motion>
std::vector<double> lagrange_torques(const Body& body, const Motion& motion, double t, const Vec3& gravity) {
  constexpr double kStep = 1e-4;
  const auto momentum = [&](double at, std::size_t j) {
    const auto [q, v, a] = motion(at);
    std::vector<double> more = v, less = v;
    more[j] += kStep, less[j] -= kStep;
    return (lagrangian(body, q, more, gravity) - lagrangian(body, q, less, gravity)) / (2 * kStep);
  };
  const auto [q, v, a] = motion(t);
  std::vector<double> torque(body.joints());
  for (std::size_t j = 0; j < torque.size(); ++j) {
    std::vector<double> more = q, less = q;
    more[j] += kStep, less[j] -= kStep;
    torque[j] = (momentum(t + kStep, j) - momentum(t - kStep, j)) / (2 * kStep) -
                (lagrangian(body, more, v, gravity) - lagrangian(body, less, v, gravity)) / (2 * kStep);
  }
  return torque;
}

struct Swing {
  std::vector<double> q, v, a;
};
Swing swing(double t) {
  Swing s{std::vector<double>(3), std::vector<double>(3), std::vector<double>(3)};
  for (std::size_t j = 0; j < 3; ++j)
    for (std::size_t k = 0; k < 4; ++k) {
      const double w = 1.1 + 1.37 * static_cast<double>(k) + 0.31 * static_cast<double>(j),
                   size = 0.8 / (1 + static_cast<double>(k));
      const math::SinCos x = math::sincos(w * t + static_cast<double>(j + 2 * k));
      s.q[j] += size * x.sin, s.v[j] += size * w * x.cos, s.a[j] -= size * w * w * x.sin;
    }
  return s;
}

TEST(ChainRegressor, TimesTheParametersOfTheFileIsTheTorqueOfLagrange) {
  const Body body = arm();
  const std::vector<double> parameters = chain_parameters(body);
  for (const Vec3 gravity : {Vec3{0, 0, -9.8}, Vec3{3, -4, 5}})
    for (const double t : {0.3, 1.7, 4.1}) {
      const Swing s = swing(t);
      Dense regressor;
      chain_regressor(body, {s.q, s.v, s.a}, gravity, 0.01, regressor);
      const auto expected = lagrange_torques(
          body,
          [](double at) {
            const Swing x = swing(at);
            return std::tuple(x.q, x.v, x.a);
          },
          t, gravity);
      for (std::size_t j = 0; j < 3; ++j) {
        double sum = 0;
        for (std::size_t c = 0; c < regressor.columns(); ++c) sum += regressor(j, c) * parameters[c];
        EXPECT_NEAR(sum - body.servos[0].armature_kgm2 * s.a[j], expected[j], 2e-5);
      }
    }
}

TEST(BaseSet, NamesWhatChangesNoEffortAndGroupsWhatCannotBeToldApart) {
  const Body body = arm();
  const BaseSet set = base_set(body, {0, 0, -9.8});
  const auto has = [&](const std::vector<std::size_t>& all, const std::string& name) {
    return std::any_of(all.begin(), all.end(), [&](std::size_t c) { return chain_column_name(body, c) == name; });
  };
  // The first link turns about the vertical: neither its weight nor its inertia about other axes is felt.
  for (const char* name : {"yaw.m", "yaw.mx", "yaw.my", "yaw.mz", "yaw.xx", "yaw.yy", "yaw.xy"})
    EXPECT_TRUE(has(set.without_effect, name)) << name;
  const auto yaw = std::find_if(set.base.begin(), set.base.end(),
                                [&](const BaseColumn& b) { return chain_column_name(body, b.column) == "yaw.zz"; });
  ASSERT_NE(yaw, set.base.end());
  EXPECT_NE(base_name(body, *yaw, 99).find("yaw.armature"), std::string::npos) << base_name(body, *yaw, 99);
  // 3 of friction and offset for each joint, and as many inertial ones as the rank of the motions has.
  EXPECT_GT(set.base.size(), 9u + 12u);
  EXPECT_LT(set.base.size(), ChainColumns{3}.size() - 10);
}

/// An arm whose masses and friction nobody told the fit.
struct SecretArm {
  Body body = arm();
  std::array<double, 3> coulomb_nm{}, slow_radps{}, viscous_nms{};
};
SecretArm draw_arm(std::uint64_t seed) {
  math::Random random(seed, 0x61726d);
  SecretArm a;
  for (std::size_t i = 1; i < a.body.links.size(); ++i) {
    kinematics::Link& link = a.body.links[i];
    link.mass_kg *= random.uniform(0.5, 2);
    link.com_m += Vec3{random.uniform(-0.03, 0.03), random.uniform(-0.03, 0.03), random.uniform(-0.03, 0.03)};
    for (std::size_t k = 0; k < 3; ++k) link.inertia_kgm2[k] *= random.uniform(0.6, 1.8);
    a.coulomb_nm[i - 1] = random.uniform(0.02, 0.15);
    a.slow_radps[i - 1] = random.uniform(0.01, 0.15);
    a.viscous_nms[i - 1] = random.uniform(0.005, 0.05);
  }
  return a;
}

/// A record of 30 s: encoder of 4096 steps, efforts with noise.
ChainRecord record_of(const SecretArm& a, std::uint64_t seed) {
  math::Random random(seed, 7);
  ChainRecord r;
  r.q_rad.resize(3), r.effort_nm.resize(3);
  const std::vector<double> parameters = chain_parameters(a.body);
  const double phase = random.uniform(0, 100);
  Dense regressor;
  for (double t = 0; t < 30; t += 0.004) {
    const Swing s = swing(t + phase);
    chain_regressor(a.body, {s.q, s.v, s.a}, {0, 0, -9.80665}, 0.01, regressor);
    r.time_s.push_back(t);
    for (std::size_t j = 0; j < 3; ++j) {
      double nm = a.coulomb_nm[j] * s.v[j] / (math::fabs(s.v[j]) + a.slow_radps[j]) + a.viscous_nms[j] * s.v[j] +
                  0.05 * random.normal();
      for (std::size_t c = 0; c < regressor.columns(); ++c) nm += regressor(j, c) * parameters[c];
      constexpr double kStep = 6.283185307179586 / 4096;
      r.q_rad[j].push_back(kStep * math::round(s.q[j] / kStep));
      r.effort_nm[j].push_back(nm);
    }
  }
  return r;
}

TEST(BaseParameters, AreFoundWithIntervalsThatHoldAndPredictThePartHeldOut) {
  const ChainColumns columns{3};
  std::size_t held = 0, all = 0, friction_held = 0, friction = 0;
  for (std::uint64_t seed = 101; seed <= 110; ++seed) {
    const SecretArm a = draw_arm(seed);
    const std::vector<double> drawn = chain_parameters(a.body);
    const BaseFit fit = fit_base_parameters(a.body, record_of(a, seed));
    ASSERT_EQ(fit.problem, "");
    for (std::size_t i = 0; i < fit.set.base.size(); ++i) {
      double truth = drawn[fit.set.base[i].column];
      for (const auto& part : fit.set.base[i].with) truth += part.factor * drawn[part.column];
      bool rubs = false;
      for (std::size_t j = 0; j < 3; ++j) {
        if (fit.set.base[i].column == columns.joint(j, JointParameter::viscous)) truth += a.viscous_nms[j], rubs = true;
        if (fit.set.base[i].column == columns.joint(j, JointParameter::coulomb)) truth += a.coulomb_nm[j], rubs = true;
      }
      const bool holds = math::fabs(fit.estimates[i].value - truth) <= fit.estimates[i].half_width;
      ++all, held += holds ? 1 : 0;
      if (rubs) ++friction, friction_held += holds ? 1 : 0;
    }
    // 0.05 N m of noise are 0.01 behind the low-pass.
    for (std::size_t j = 0; j < 3; ++j) EXPECT_LT(fit.held_out_rms_nm[j], 0.013);
  }
  EXPECT_GE(held * 100, all * 89) << held << " of " << all;
  EXPECT_LE(held * 100, all * 99) << held << " of " << all;
  EXPECT_GE(friction_held * 100, friction * 89) << friction_held << " of " << friction;
}

TEST(BaseParameters, OfJointsThatStandAreNotGiven) {
  const SecretArm a = draw_arm(1);
  const Body& body = a.body;
  ChainRecord r = record_of(a, 1);
  for (double& q : r.q_rad[1]) q = 0;
  EXPECT_NE(fit_base_parameters(body, r).problem, "");
  r.q_rad.pop_back();
  EXPECT_NE(fit_base_parameters(body, r).problem, "");
}

}  // namespace
}  // namespace sinew::identify::base_parameters_test
