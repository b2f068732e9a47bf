#pragma once
// Joint torques of a body on a fixed stand, as a linear function of its masses: torque = regressor * parameters.
#include <span>
#include <string>
#include <vector>

#include "identify/dense.hpp"
#include "kinematics/body.hpp"

namespace sinew::identify {

/// What each moving link has, in this order: mass, mass times centre (the link's axes, kg m), inertia about the link's
/// origin in its axes (not about its centre of mass: those would not be linear).
enum class LinkParameter : std::uint8_t { m, mx, my, mz, xx, yy, zz, xy, xz, yz };
inline constexpr std::size_t kLinkParameters = 10;
/// And each joint: the rotor's inertia seen at the joint, viscous friction, Coulomb friction, and what its effort
/// reads at no torque.
enum class JointParameter : std::uint8_t { armature, viscous, coulomb, offset };
inline constexpr std::size_t kJointParameters = 4;

/// Columns of a regressor: first the links' parameters, link 1 first, then those of the joints.
struct ChainColumns {
  std::size_t joints = 0;
  std::size_t size() const { return joints * (kLinkParameters + kJointParameters); }
  std::size_t link(std::size_t joint, LinkParameter p) const {
    return joint * kLinkParameters + static_cast<std::size_t>(p);
  }
  std::size_t joint(std::size_t joint, JointParameter p) const {
    return joints * kLinkParameters + joint * kJointParameters + static_cast<std::size_t>(p);
  }
};

/// The motion of all joints at one instant.
struct ChainMotion {
  std::span<const double> q_rad, v_radps, a_radps2;  // one for each joint of the body
};

/// Torques of the joints' motors as rows, parameters as columns. Link 0 does not move.
/// `gravity_mps2`: in link 0's frame, (0, 0, -9.80665) when it stands upright. `coulomb_radps`: Coulomb friction is
/// v / (|v| + coulomb_radps) of itself.
/// Frames:  as Body.   Source:  W. Khalil and E. Dombre, Modeling, Identification and Control of Robots (2002), 12.
/// Errors:  the spans are shorter than the body's joints: aborts.
void chain_regressor(const kinematics::Body& body, const ChainMotion& motion, const math::Vec3& gravity_mps2,
                     double coulomb_radps, Dense& regressor);

/// The columns' values as the body's file has them; the joints' friction and offset are 0.
std::vector<double> chain_parameters(const kinematics::Body& body);

/// "l_knee.mx", "l_knee.armature".
std::string chain_column_name(const kinematics::Body& body, std::size_t column);
/// "kg m", "kg m^2", "N m s/rad", ...
std::string chain_column_unit(const kinematics::Body& body, std::size_t column);

}  // namespace sinew::identify
