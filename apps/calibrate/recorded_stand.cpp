#include "apps/calibrate/recorded_stand.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "apps/bag/recorded_topic.hpp"
#include "kinematics/limbs.hpp"
#include "motion/sole_level.hpp"
#include "msg/joints.hpp"
#include "msg/sensors.hpp"

namespace sinew::app {
namespace {

constexpr double kStandsStill_px = 0.6;  // from one picture to the next
constexpr std::size_t kFewestPictures = 2;
constexpr double kOtherPose_px = 2;              // two such that differ by more are two poses
constexpr std::int64_t kAround_ns = 60'000'000;  // of the first and the last picture: measured then, too

template <class M>
std::vector<M> all_of(record::Reader& reader, const std::string& topic) {
  std::vector<M> all;
  each_of<M>(reader, topic, [&](const M& message) { all.push_back(message); });
  return all;
}

struct Still {
  std::int64_t from_ns = 0, until_ns = 0;
  std::size_t first = 0, last = 0;  // of the boards
};

std::vector<Still> still_times(const RecordedBoards& boards) {
  std::vector<Still> all;
  const auto& b = boards.boards;
  for (std::size_t i = 0; i < b.size();) {
    std::size_t last = i;
    // Against the newest picture, that is of slow ways; against the first one that it is one pose.
    while (last + 1 < b.size() && farthest_px(b[last + 1], b[last]) < kStandsStill_px &&
           farthest_px(b[last + 1], b[i]) < kOtherPose_px)
      ++last;
    // The first picture may still have moved a little.
    if (last - i + 1 > kFewestPictures) all.push_back({b[i + 1].stamp_ns, b[last].stamp_ns, i + 1, last});
    i = last + 1;
  }
  return all;
}

std::optional<std::array<std::string, 3>> joint_topics(const RobotFile& robot) {
  for (const rt::ModuleSpec& m : robot.graph.modules) {
    std::array<std::string, 3> topics;
    std::size_t found = 0;
    for (std::size_t i = 0; const char* port : {"head_joints", "left_leg_joints", "right_leg_joints"}) {
      if (const auto it = m.in.find(port); it != m.in.end()) topics[i] = it->second.value, ++found;
      ++i;
    }
    if (found == topics.size()) return topics;
  }
  return std::nullopt;
}

}  // namespace

std::optional<RecordedStand> read_stand(record::Reader& reader, const RobotFile& robot, const RecordedBoards& boards,
                                        double square_m, std::uint32_t columns, std::string& why) {
  if (!robot.body.body) {
    why = "its robot file has no [body]";
    return std::nullopt;
  }
  const kinematics::Body& body = *robot.body.body;
  const auto topics = joint_topics(robot);
  if (!topics) {
    why = "no module of its robot file reads head_joints, left_leg_joints and right_leg_joints";
    return std::nullopt;
  }
  const auto soles_topic = topic_of<msg::SolePressure>(reader, {}, why);
  if (!soles_topic) return std::nullopt;
  const auto imu_topic = topic_of<msg::ImuSample>(reader, {}, why);
  if (!imu_topic) return std::nullopt;

  RecordedStand stand;
  const std::vector<Still> times = still_times(boards);
  stand.still = times.size();
  const kinematics::Limbs limbs = kinematics::Limbs::of(body);
  struct Sums {
    std::vector<double> rad;
    std::vector<std::size_t> count;
    math::Vec3 accel;
    std::size_t accels = 0, soles = 0;
    std::array<motion::SoleForces, 2> force{};
  };
  std::vector<Sums> sums(times.size(),
                         {std::vector<double>(body.joints()), std::vector<std::size_t>(body.joints()), {}, 0, 0, {}});
  const auto each = [&](std::int64_t at_ns, const auto& add) {
    for (std::size_t i = 0; i < times.size(); ++i)
      if (at_ns >= times[i].from_ns - kAround_ns && at_ns <= times[i].until_ns + kAround_ns) add(sums[i]);
  };
  constexpr kinematics::Limb kLimb[] = {kinematics::Limb::head, kinematics::Limb::left_leg,
                                        kinematics::Limb::right_leg};
  for (std::size_t limb = 0; limb < 3; ++limb) {
    const std::vector<std::size_t>& joints = limbs.of(kLimb[limb]);
    for (const msg::JointState& s : all_of<msg::JointState>(reader, (*topics)[limb]))
      each(s.stamp.ns, [&](Sums& sum) {
        for (std::size_t c = 0; c < std::min<std::size_t>(joints.size(), s.count); ++c)
          if (std::isfinite(s.position_rad[c])) sum.rad[joints[c]] += s.position_rad[c], ++sum.count[joints[c]];
      });
  }
  for (const msg::ImuSample& s : all_of<msg::ImuSample>(reader, *imu_topic))
    each(s.stamp.ns, [&](Sums& sum) { sum.accel += math::Vec3(s.accel_mps2), ++sum.accels; });
  for (const msg::SolePressure& s : all_of<msg::SolePressure>(reader, *soles_topic))
    each(s.stamp.ns, [&](Sums& sum) {
      for (std::size_t i = 0; i < msg::kSoleCells; ++i) sum.force[i / 4][i % 4] += s.force_n[i];
      ++sum.soles;
    });

  for (std::size_t i = 0; i < times.size(); ++i) {
    Sums& sum = sums[i];
    identify::StandPose pose;
    bool measured = sum.soles > 0;
    for (const kinematics::Limb limb : kLimb)
      for (const std::size_t j : limbs.of(limb)) measured = measured && sum.count[j] > 0;
    if (!measured) continue;
    for (auto& foot : sum.force)
      for (double& cell : foot) cell /= static_cast<double>(sum.soles);
    if (!motion::lie_flat(sum.force)) {
      ++stand.not_flat;
      continue;
    }
    for (std::size_t j = 0; j < body.joints(); ++j)
      pose.joints_rad.push_back(sum.count[j] > 0 ? sum.rad[j] / static_cast<double>(sum.count[j]) : 0);
    if (sum.accels > 0) pose.accel_mps2 = sum.accel / static_cast<double>(sum.accels);
    const double pictures = static_cast<double>(times[i].last - times[i].first + 1);
    for (std::size_t k = 0; k < boards.boards[times[i].first].corners.size(); ++k) {
      identify::PlanePoint p{static_cast<double>(k % columns) * square_m, static_cast<double>(k / columns) * square_m,
                             0, 0};
      for (std::size_t b = times[i].first; b <= times[i].last; ++b)
        p.u_px += boards.boards[b].corners[k].u_px / pictures, p.v_px += boards.boards[b].corners[k].v_px / pictures;
      pose.view.push_back(p);
    }
    stand.poses.push_back(std::move(pose));
  }
  return stand;
}

}  // namespace sinew::app
