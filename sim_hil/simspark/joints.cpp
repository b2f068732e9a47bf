#include "sim_hil/simspark/joints.hpp"

#include <algorithm>

#include "sim_hil/simspark/frame.hpp"

namespace sinew::simspark {
namespace {

using kinematics::Limb;
using math::Vec3;

constexpr double kSame = 0.999;  // cosine of axes that are the same
constexpr double kHalf = 0.70710678118654752;
constexpr Vec3 kRight{1, 0, 0}, kAhead{0, 1, 0}, kUp{0, 0, 1};

constexpr std::array<SparkJointKind, kJoints> kAll{{
    {"hj1", "he1", Limb::head, 0, kUp},
    {"hj2", "he2", Limb::head, 1, kRight},
    {"raj1", "rae1", Limb::right_arm, 0, kRight},
    {"raj2", "rae2", Limb::right_arm, 1, kUp},
    {"raj3", "rae3", Limb::right_arm, 2, kAhead},
    {"raj4", "rae4", Limb::right_arm, 3, kUp},
    {"laj1", "lae1", Limb::left_arm, 0, kRight},
    {"laj2", "lae2", Limb::left_arm, 1, kUp},
    {"laj3", "lae3", Limb::left_arm, 2, kAhead},
    {"laj4", "lae4", Limb::left_arm, 3, kUp},
    {"rlj1", "rle1", Limb::right_leg, 0, {-kHalf, 0, kHalf}},
    {"rlj2", "rle2", Limb::right_leg, 1, kAhead},
    {"rlj3", "rle3", Limb::right_leg, 2, kRight},
    {"rlj4", "rle4", Limb::right_leg, 3, kRight},
    {"rlj5", "rle5", Limb::right_leg, 4, kRight},
    {"rlj6", "rle6", Limb::right_leg, 5, kAhead},
    {"llj1", "lle1", Limb::left_leg, 0, {-kHalf, 0, -kHalf}},
    {"llj2", "lle2", Limb::left_leg, 1, kAhead},
    {"llj3", "lle3", Limb::left_leg, 2, kRight},
    {"llj4", "lle4", Limb::left_leg, 3, kRight},
    {"llj5", "lle5", Limb::left_leg, 4, kRight},
    {"llj6", "lle6", Limb::left_leg, 5, kAhead},
}};

}  // namespace

const std::array<SparkJointKind, kJoints>& spark_joints() { return kAll; }

std::optional<std::size_t> SparkJointMap::find_effector(std::string_view name) {
  const auto found = std::ranges::find(kAll, name, &SparkJointKind::effector);
  if (found == kAll.end()) return std::nullopt;
  return static_cast<std::size_t>(found - kAll.begin());
}

std::optional<SparkJointMap> SparkJointMap::of(const kinematics::Body& body, std::string& why) {
  const kinematics::Limbs limbs = kinematics::Limbs::of(body);
  SparkJointMap map;
  for (std::size_t i = 0; i < kJoints; ++i) {
    const SparkJointKind& kind = kAll[i];
    const std::string name(kind.perceptor), limb(to_string(kind.limb));
    const auto& joints = limbs.of(kind.limb);
    if (kind.in_limb >= joints.size()) {
      why = "SimSpark's joint " + name + ": the " + limb + " of the body has " + std::to_string(joints.size()) +
            " joints";
      return std::nullopt;
    }
    map.joint_[i] = joints[kind.in_limb];
    const kinematics::Link& link = body.links[map.joint_[i] + 1];
    const double same = dot(from_spark(kind.axis), link.axis);
    if (math::fabs(same) < kSame) {
      why = "SimSpark's joint " + name + " and the body's " + link.name + " do not turn about the same axis";
      return std::nullopt;
    }
    map.sign_[i] = same > 0 ? 1 : -1;
  }
  return map;
}

}  // namespace sinew::simspark
