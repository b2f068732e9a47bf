#include "motion/stand_poses.hpp"

#include <algorithm>

#include "math/random.hpp"

namespace sinew::motion {
namespace {

using kinematics::Pose;
using math::Quat;
using math::Vec3;

constexpr std::uint32_t kStream = 0x73746e64;
constexpr std::size_t kMostTries = 60;  // for each pose
constexpr double kWithin = 0.9;         // of the range of a joint

bool within_ranges(const Figure& figure, const JointAngles& rad) {
  for (std::size_t j = 0; j < figure.joints(); ++j) {
    const kinematics::Link& link = figure.body().links[j + 1];
    if (rad[j] < kWithin * link.least_rad || rad[j] > kWithin * link.most_rad) return false;
  }
  return true;
}

}  // namespace

std::vector<JointAngles> stand_poses(const Figure& figure, const StandPosesOptions& o) {
  std::vector<JointAngles> all;
  kinematics::BodyPose pose(figure.body());
  const double hips_m = figure.leg(Side::left).leg.hip_m().z;  // below the torso's origin: negative
  for (std::size_t tries = 0; tries < kMostTries * o.poses && all.size() < o.poses; ++tries) {
    math::Random random(o.seed, kStream, tries);
    const auto both = [&](double most) { return random.uniform(-most, most); };
    const Vec3 over{both(o.shift_m), both(o.shift_m), 0};  // of the centre of mass
    const double z = o.height_m - hips_m - random.uniform(0, o.lower_m);
    const Quat q = Quat::exp({both(o.tilt_rad), both(o.tilt_rad), both(o.turn_rad)});
    const Vec3 look{o.ahead_m + both(o.around_m), o.aside_m + both(o.around_m), 0};
    JointAngles rad{};
    Vec3 base{0, 0, z};
    bool reached = true;
    for (int round = 0; round < 4; ++round) {
      const Pose torso{base, q};
      for (const Side side : kSides)
        reached =
            figure.place_sole(side, torso.inverse() * Pose{{0, sign(side) * o.stance_m / 2, 0}, {}}, rad) && reached;
      const Vec3 to = torso.inverse().of(look);
      if (figure.head_pan() != kinematics::kNone && figure.head_tilt() != kinematics::kNone) {
        pose.set({rad.data(), figure.joints()}, {});
        const Vec3 neck = pose.link(figure.head_tilt() + 1).p_m, way = to - neck;
        rad[figure.head_pan()] = math::atan2(way.y, way.x);
        rad[figure.head_tilt()] = math::atan2(-way.z, math::hypot(way.x, way.y));
      }
      pose.set({rad.data(), figure.joints()}, torso);
      const Vec3 off = pose.centre_of_mass() - over;
      base.x -= off.x, base.y -= off.y;
    }
    if (reached && within_ranges(figure, rad)) all.push_back(rad);
  }
  return all;
}

}  // namespace sinew::motion
