#include "identify/chain_regressor.hpp"

#include <algorithm>
#include <array>
#include <cstdlib>

namespace sinew::identify {
namespace {

using kinematics::Body;
using kinematics::kMaxLinks;
using math::Quat;
using math::Vec3;

/// A link's motion in its own axes, at its origin; accelerations are against free fall.
struct LinkState {
  Quat q_parent;  // takes its coordinates to the parent's
  Vec3 w_radps, dw_radps2, a_mps2;
};

struct Wrench {
  Vec3 force_n, torque_nm;  // about the link's origin
};

/// What one unit of a parameter needs to move with the link.
Wrench unit_wrench(const LinkState& s, LinkParameter p) {
  const auto lever = [&](const Vec3& e) {  // of mass times centre along e
    return Wrench{cross(s.dw_radps2, e) + cross(s.w_radps, cross(s.w_radps, e)), cross(e, s.a_mps2)};
  };
  const auto inertia = [&](auto&& times) {
    return Wrench{{}, times(s.dw_radps2) + cross(s.w_radps, times(s.w_radps))};
  };
  switch (p) {
    case LinkParameter::m:
      return {s.a_mps2, {}};
    case LinkParameter::mx:
      return lever({1, 0, 0});
    case LinkParameter::my:
      return lever({0, 1, 0});
    case LinkParameter::mz:
      return lever({0, 0, 1});
    case LinkParameter::xx:
      return inertia([](const Vec3& v) { return Vec3{v.x, 0, 0}; });
    case LinkParameter::yy:
      return inertia([](const Vec3& v) { return Vec3{0, v.y, 0}; });
    case LinkParameter::zz:
      return inertia([](const Vec3& v) { return Vec3{0, 0, v.z}; });
    case LinkParameter::xy:
      return inertia([](const Vec3& v) { return Vec3{v.y, v.x, 0}; });
    case LinkParameter::xz:
      return inertia([](const Vec3& v) { return Vec3{v.z, 0, v.x}; });
    case LinkParameter::yz:
      return inertia([](const Vec3& v) { return Vec3{0, v.z, v.y}; });
  }
  return {};
}

constexpr std::array<const char*, kLinkParameters> kLinkNames{"m",  "mx", "my", "mz", "xx",
                                                              "yy", "zz", "xy", "xz", "yz"};
constexpr std::array<const char*, kJointParameters> kJointNames{"armature", "viscous", "coulomb", "effort_offset"};
constexpr std::array<const char*, kJointParameters> kJointUnits{"kg m^2", "N m s/rad", "N m", "N m"};

}  // namespace

void chain_regressor(const Body& body, const ChainMotion& motion, const Vec3& gravity_mps2, double coulomb_radps,
                     Dense& regressor) {
  const ChainColumns columns{body.joints()};
  if (motion.q_rad.size() < columns.joints || motion.v_radps.size() < columns.joints ||
      motion.a_radps2.size() < columns.joints || body.links.size() > kMaxLinks)
    std::abort();  // our own mistake: the callers make spans for the body
  if (regressor.rows() != columns.joints || regressor.columns() != columns.size())
    regressor = Dense(columns.joints, columns.size());
  for (std::size_t r = 0; r < regressor.rows(); ++r) std::fill_n(regressor.row(r), regressor.columns(), 0.0);

  std::array<LinkState, kMaxLinks> state{};
  state[0].a_mps2 = -gravity_mps2;
  for (std::size_t i = 1; i < body.links.size(); ++i) {
    const kinematics::Link& link = body.links[i];
    const LinkState& parent = state[link.parent];
    LinkState& s = state[i];
    const double v = motion.v_radps[i - 1];
    s.q_parent = Quat::from_axis_angle(link.axis, motion.q_rad[i - 1]);
    const Quat to_link = s.q_parent.conjugate();
    const Vec3 w_parent = to_link.rotate(parent.w_radps);
    s.w_radps = w_parent + v * link.axis;
    s.dw_radps2 =
        to_link.rotate(parent.dw_radps2) + cross(w_parent, v * link.axis) + motion.a_radps2[i - 1] * link.axis;
    s.a_mps2 = to_link.rotate(parent.a_mps2 + cross(parent.dw_radps2, link.at_m) +
                              cross(parent.w_radps, cross(parent.w_radps, link.at_m)));
  }
  for (std::size_t i = 1; i < body.links.size(); ++i)
    for (std::size_t p = 0; p < kLinkParameters; ++p) {
      Wrench w = unit_wrench(state[i], static_cast<LinkParameter>(p));
      const std::size_t column = columns.link(i - 1, static_cast<LinkParameter>(p));
      for (std::size_t at = i; at != 0; at = body.links[at].parent) {  // down the chain
        const kinematics::Link& link = body.links[at];
        regressor(at - 1, column) = dot(link.axis, w.torque_nm);
        const Vec3 force = state[at].q_parent.rotate(w.force_n);
        w = {force, state[at].q_parent.rotate(w.torque_nm) + cross(link.at_m, force)};
      }
    }
  for (std::size_t j = 0; j < columns.joints; ++j) {
    const double v = motion.v_radps[j];
    regressor(j, columns.joint(j, JointParameter::armature)) = motion.a_radps2[j];
    regressor(j, columns.joint(j, JointParameter::viscous)) = v;
    const double speed = math::fabs(v) + coulomb_radps;
    regressor(j, columns.joint(j, JointParameter::coulomb)) = speed > 0 ? v / speed : 0;
    regressor(j, columns.joint(j, JointParameter::offset)) = 1;
  }
}

std::vector<double> chain_parameters(const Body& body) {
  const ChainColumns columns{body.joints()};
  std::vector<double> value(columns.size());
  for (std::size_t i = 1; i < body.links.size(); ++i) {
    const kinematics::Link& l = body.links[i];
    const Vec3& c = l.com_m;
    const double m = l.mass_kg;
    const std::array<double, kLinkParameters> of_link{m,
                                                      m * c.x,
                                                      m * c.y,
                                                      m * c.z,
                                                      l.inertia_kgm2[0] + m * (c.y * c.y + c.z * c.z),
                                                      l.inertia_kgm2[1] + m * (c.x * c.x + c.z * c.z),
                                                      l.inertia_kgm2[2] + m * (c.x * c.x + c.y * c.y),
                                                      l.inertia_kgm2[3] - m * c.x * c.y,
                                                      l.inertia_kgm2[4] - m * c.x * c.z,
                                                      l.inertia_kgm2[5] - m * c.y * c.z};
    std::copy(of_link.begin(), of_link.end(), value.begin() + static_cast<std::ptrdiff_t>((i - 1) * kLinkParameters));
    if (l.servo < body.servos.size())
      value[columns.joint(i - 1, JointParameter::armature)] = body.servos[l.servo].armature_kgm2;
  }
  return value;
}

std::string chain_column_name(const Body& body, std::size_t column) {
  const std::size_t of_links = body.joints() * kLinkParameters;
  if (column < of_links)
    return body.links[column / kLinkParameters + 1].name + "." + kLinkNames[column % kLinkParameters];
  column -= of_links;
  return body.links[column / kJointParameters + 1].name + "." + kJointNames[column % kJointParameters];
}

std::string chain_column_unit(const Body& body, std::size_t column) {
  const std::size_t of_links = body.joints() * kLinkParameters;
  if (column >= of_links) return kJointUnits[(column - of_links) % kJointParameters];
  const std::size_t p = column % kLinkParameters;
  return p == 0 ? "kg" : p < 4 ? "kg m" : "kg m^2";
}

}  // namespace sinew::identify
