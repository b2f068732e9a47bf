// Places, Jacobians and centres of mass of bodies with random links.
#include "kinematics/body.hpp"

#include <gtest/gtest.h>

#include "math/random.hpp"

namespace sinew::kinematics {
namespace {

using math::Mat3;
using math::Vec3;

Vec3 any_vector(math::Random& random, double most) {
  return {random.uniform(-most, most), random.uniform(-most, most), random.uniform(-most, most)};
}

/// A tree of links with any axes, places and masses.
Body any_body(std::uint64_t seed, std::size_t links) {
  math::Random random(seed);
  Body body;
  for (std::size_t i = 0; i < links; ++i) {
    Link link;
    link.name = "link" + std::to_string(i);
    if (i > 0) link.parent = random.below(static_cast<std::uint32_t>(i));
    link.at_m = any_vector(random, 0.3);
    link.axis = math::normalized(any_vector(random, 1));
    link.mass_kg = random.uniform(0, 2);
    link.com_m = any_vector(random, 0.1);
    body.links.push_back(link);
  }
  return body;
}

std::vector<double> any_angles(math::Random& random, const Body& body) {
  std::vector<double> rad(body.joints());
  for (double& r : rad) r = random.uniform(-3, 3);
  return rad;
}

Pose any_pose(math::Random& random) { return {any_vector(random, 1), math::Quat::exp(any_vector(random, 2))}; }

void expect_near(const Vec3& a, const Vec3& b, double within) { EXPECT_LT(norm(a - b), within); }

/// The rotation about an axis as a matrix: Rodrigues' formula.
Mat3 rotation(const Vec3& axis, double rad) {
  const Mat3 k = math::skew(axis);
  return Mat3::identity() + k * math::sin(rad) + k * k * (1 - math::cos(rad));
}

TEST(BodyPose, IsTheProductOfTheJointsOnTheWayToALink) {
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    const Body body = any_body(seed, 12);
    math::Random random(seed, 1);
    const auto rad = any_angles(random, body);
    const Pose base = any_pose(random);
    BodyPose pose(body);
    pose.set(rad, base);
    for (std::size_t link = 0; link < body.links.size(); ++link) {
      Vec3 point = any_vector(random, 0.5);
      const Vec3 there = pose.link(link).of(point);
      for (std::size_t i = link; i != 0; i = body.links[i].parent)
        point = body.links[i].at_m + rotation(body.links[i].axis, rad[i - 1]) * point;
      expect_near(there, base.of(point), 1e-12);
    }
  }
}

TEST(BodyPose, JacobiansAreTheSlopesOfPlaceAndDirection) {
  constexpr double kStep = 1e-6;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const Body body = any_body(seed, 10);
    math::Random random(seed, 2);
    const auto rad = any_angles(random, body);
    const Pose base = any_pose(random);
    BodyPose pose(body), moved(body);
    pose.set(rad, base);
    const std::size_t link = body.links.size() - 1;
    const Vec3 point = any_vector(random, 0.2);
    std::vector<Vec3> linear(body.joints()), angular(body.joints()), of_com(body.joints());
    pose.jacobian(link, point, linear, angular);
    pose.jacobian_of_centre_of_mass(of_com);
    for (std::size_t j = 0; j < body.joints(); ++j) {
      auto other = rad;
      other[j] += kStep;
      moved.set(other, base);
      expect_near(linear[j], (moved.link(link).of(point) - pose.link(link).of(point)) / kStep, 1e-5);
      expect_near(angular[j], (moved.link(link).q * pose.link(link).q.conjugate()).log() / kStep, 1e-5);
      expect_near(of_com[j], (moved.centre_of_mass() - pose.centre_of_mass()) / kStep, 1e-5);
    }
  }
}

TEST(BodyPose, TheCentreOfMassIsTheMeanOfTheMasses) {
  const Body body = any_body(7, 9);
  math::Random random(7);
  BodyPose pose(body);
  pose.set(any_angles(random, body));
  Vec3 moment;
  for (std::size_t i = 0; i < body.links.size(); ++i)
    moment += pose.link(i).of(body.links[i].com_m) * body.links[i].mass_kg;
  expect_near(pose.centre_of_mass() * body.mass_kg(), moment, 1e-12);
}

TEST(Pose, TheInverseTakesBack) {
  math::Random random(3);
  for (int i = 0; i < 100; ++i) {
    const Pose a = any_pose(random), b = any_pose(random);
    const Vec3 point = any_vector(random, 1);
    expect_near(a.inverse().of(a.of(point)), point, 1e-12);
    expect_near((a * b).of(point), a.of(b.of(point)), 1e-12);
  }
}

}  // namespace
}  // namespace sinew::kinematics
