#pragma once
// The 22 joints of SimSpark's Nao, and which joint of a body of ours each of them is.
#include <array>
#include <optional>
#include <string>
#include <string_view>

#include "kinematics/body.hpp"
#include "kinematics/limbs.hpp"

namespace sinew::simspark {

inline constexpr std::size_t kJoints = 22;
inline constexpr double kMostSpeed_radps = 6.1395;  // 351.77 degrees/s

struct SparkJointKind {
  std::string_view perceptor, effector;  // "llj3", "lle3"
  kinematics::Limb limb{};
  std::size_t in_limb = 0;
  math::Vec3 axis;  // SimSpark's frame
};

/// In the order in which the server says them.
/// Source:  rcssserver3d, rsg/agent/nao (naoneckhead, naoarm, naoleg); the SimSpark wiki, Models.
const std::array<SparkJointKind, kJoints>& spark_joints();

/// Which joint of a body is which of SimSpark's, and whether it turns the other way.
class SparkJointMap {
 public:
  /// A body with two joints of the head, four of each arm, six of each leg, about the axes of SimSpark's Nao.
  /// Errors:  nothing, and `why` names the joint that is missing or turns about something else.
  static std::optional<SparkJointMap> of(const kinematics::Body& body, std::string& why);

  /// The joint of the body (0: that of link 1), by the number in spark_joints().
  std::size_t joint(std::size_t i) const { return joint_[i]; }
  /// +1 or -1: our angle for each of SimSpark's.
  double sign(std::size_t i) const { return sign_[i]; }
  /// The number of an effector in spark_joints(); nothing: no joint has it.
  static std::optional<std::size_t> find_effector(std::string_view name);

 private:
  std::array<std::size_t, kJoints> joint_{};
  std::array<double, kJoints> sign_{};
};

}  // namespace sinew::simspark
