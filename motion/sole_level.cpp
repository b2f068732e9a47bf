#include "motion/sole_level.hpp"

#include <algorithm>

namespace sinew::motion {
namespace {

constexpr double kLeastShare = 0.02;  // of a sole's force, on a cell of one that lies flat

}  // namespace

SoleLevel::SoleLevel(const Figure& figure) {
  for (const Side side : kSides) {
    const auto& links = figure.leg(side).leg.links();
    for (std::size_t k = 0; k < 2; ++k) {
      const std::size_t link = links[kinematics::kLegJoints - 2 + k];  // pitch, then roll
      joint_[2 * index(side) + k] = link - 1;
      const math::Vec3& axis = figure.body().links[link].axis;
      sign_[2 * index(side) + k] = (k == 0 ? axis.y : axis.x) < 0 ? -1 : 1;
    }
  }
}

void SoleLevel::step(const std::array<SoleForces, 2>& soles_n, double dt_s) {
  std::array<double, 2> front{}, left{};
  for (std::size_t foot = 0; foot < 2; ++foot) {
    const SoleForces& c = soles_n[foot];
    const double all = sum(c);
    if (!(all > kLeast_n)) return;
    front[foot] = (c[0] + c[1] - c[2] - c[3]) / all;
    left[foot] = (c[0] + c[2] - c[1] - c[3]) / all;
  }
  const double both = (front[0] + front[1]) / 2;
  for (std::size_t foot = 0; foot < 2; ++foot) {
    const double by[2] = {both - (front[foot] - both), left[foot]};
    for (std::size_t k = 0; k < 2; ++k) {
      double& turn = turn_rad[2 * foot + k];
      turn = std::clamp(turn + kGain_radps * dt_s * by[k] * sign_[2 * foot + k], -kMost_rad, kMost_rad);
    }
  }
}

void SoleLevel::add_to(std::span<double> joints_rad) const {
  for (std::size_t k = 0; k < 4; ++k)
    if (joint_[k] < joints_rad.size()) joints_rad[joint_[k]] += turn_rad[k];
}

bool lie_flat(const std::array<SoleForces, 2>& soles_n) {
  for (const SoleForces& sole : soles_n)
    for (const double cell : sole)
      if (!(sum(sole) > SoleLevel::kLeast_n) || !(cell > kLeastShare * sum(sole))) return false;
  return true;
}

}  // namespace sinew::motion
