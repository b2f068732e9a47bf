#include "apps/identify/recorded_joints.hpp"

#include <algorithm>
#include <limits>

#include "apps/bag/recorded_topic.hpp"
#include "apps/robot_file/robot_file.hpp"
#include "msg/joints.hpp"

namespace sinew::app {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr double kMoved_rad = 1e-4;  // a setpoint that changed by more has moved
constexpr double kPause_s = 1.5;     // a joint that stands for longer has ended its motion
constexpr double kLead_s = 0.5;      // cut out with what comes before
constexpr double kShortest_s = 5;
constexpr std::string_view kGuardian = "guardian.";

std::vector<std::string> names_of(record::Reader& reader, const std::string& group, std::size_t count) {
  std::vector<std::string> names;
  if (const auto text = record::read_attachment(reader, "robot.toml"))
    for (const auto& device : parse_robot(*text, "robot.toml").robot.devices.devices)
      if (device.name == group)
        for (const auto& joint : device.joints) names.push_back(joint.name);
  for (std::size_t j = names.size(); j < count; ++j) names.push_back("joint " + std::to_string(j));
  names.resize(count);
  return names;
}

}  // namespace

std::optional<RecordedJoints> read_joints(record::Reader& reader, const std::string& group, const std::string& joints,
                                          std::string& why) {
  const auto commands = topic_of<msg::GuardianState>(reader, {kGuardian, group, "--group"}, why);
  if (!commands) return std::nullopt;
  const auto states = topic_of<msg::JointState>(reader, {"", joints, "--joints"}, why);
  if (!states) return std::nullopt;
  RecordedJoints r;
  r.group = commands->substr(kGuardian.size());
  std::optional<std::int64_t> start_ns;
  std::uint32_t count = 0;
  each_of<msg::GuardianState>(reader, *commands, [&](const msg::GuardianState& g) {
    if (!start_ns) start_ns = g.stamp.ns;
    count = std::min<std::uint32_t>(std::max(count, g.count), msg::kMaxChannels);
    r.commands.resize(count);
    const double t = 1e-9 * static_cast<double>(g.stamp.ns - *start_ns);
    const bool active = g.mode == msg::GuardianMode::active;
    for (std::size_t j = 0; j < count; ++j) {
      identify::CommandLine& line = r.commands[j];
      const double value = active ? g.value[j] : kNone;
      const bool same = !line.target_rad.empty() && (line.target_rad.back() == value ||
                                                     (line.target_rad.back() != line.target_rad.back() && !active));
      if (same || (!line.time_s.empty() && t <= line.time_s.back())) continue;
      line.time_s.push_back(t), line.target_rad.push_back(value);
    }
  });
  if (count == 0) {
    why = "topic " + *commands + ": no commands went out";
    return std::nullopt;
  }
  r.time_s.resize(count), r.position_rad.resize(count), r.effort_nm.resize(count);
  each_of<msg::JointState>(reader, *states, [&](const msg::JointState& s) {
    for (std::size_t j = 0; j < std::min(count, s.count); ++j) {
      const std::int64_t at = s.measured[j].ns != 0 ? s.measured[j].ns : s.stamp.ns;
      const double t = 1e-9 * static_cast<double>(at - *start_ns);
      if (!(s.position_rad[j] == s.position_rad[j]) || (!r.time_s[j].empty() && t <= r.time_s[j].back())) continue;
      r.time_s[j].push_back(t);
      r.position_rad[j].push_back(s.position_rad[j]);
      r.effort_nm[j].push_back(s.effort_nm[j]);
    }
  });
  for (std::vector<double>& effort : r.effort_nm)
    if (std::none_of(effort.begin(), effort.end(), [](double e) { return e == e; })) effort.clear();
  r.names = names_of(reader, r.group, count);
  return r;
}

std::optional<identify::ServoRecord> RecordedJoints::alone(std::size_t joint) const {
  // Moments at which setpoints moved, by joint.
  struct Move {
    double t;
    std::size_t joint;
  };
  std::vector<Move> moves;
  for (std::size_t j = 0; j < joints(); ++j)
    for (std::size_t i = 1; i < commands[j].time_s.size(); ++i) {
      const double way = commands[j].target_rad[i] - commands[j].target_rad[i - 1];
      if (way > kMoved_rad || way < -kMoved_rad) moves.push_back({commands[j].time_s[i], j});
    }
  std::stable_sort(moves.begin(), moves.end(), [](const Move& a, const Move& b) { return a.t < b.t; });
  double best_from = 0, best_until = 0, from = 0, until = -1;
  bool open = false;
  for (const Move& m : moves) {
    if (m.joint == joint && open && m.t - until < kPause_s) {
      until = m.t;
    } else if (m.joint == joint) {
      from = until = m.t, open = true;
    } else {
      open = false;
    }
    if (open && until - from > best_until - best_from) best_from = from, best_until = until;
  }
  if (best_until - best_from < kShortest_s) return std::nullopt;
  identify::ServoRecord r;
  for (std::size_t i = 0; i < commands[joint].time_s.size(); ++i) {
    const double t = commands[joint].time_s[i];
    const bool in_force = i + 1 == commands[joint].time_s.size() || commands[joint].time_s[i + 1] > best_from - kLead_s;
    if (!in_force || t > best_until) continue;
    r.commands.time_s.push_back(std::max(t, best_from - kLead_s));
    r.commands.target_rad.push_back(commands[joint].target_rad[i]);
  }
  for (std::size_t i = 0; i < time_s[joint].size(); ++i) {
    const double t = time_s[joint][i];
    if (t < best_from - kLead_s || t > best_until) continue;
    r.time_s.push_back(t);
    r.position_rad.push_back(position_rad[joint][i]);
    if (!effort_nm[joint].empty()) r.effort_nm.push_back(effort_nm[joint][i]);
  }
  return r;
}

std::optional<identify::ChainRecord> RecordedJoints::together(const kinematics::Body& body, std::string& why) const {
  identify::ChainRecord r;
  std::vector<std::size_t> channel;
  for (std::size_t i = 1; i < body.links.size(); ++i) {
    const auto it = std::find(names.begin(), names.end(), body.links[i].name);
    if (it == names.end()) {
      why = "the record has no joint '" + body.links[i].name + "' of the body";
      return std::nullopt;
    }
    channel.push_back(static_cast<std::size_t>(it - names.begin()));
    if (effort_nm[channel.back()].empty()) {
      why = "joint '" + *it + "' measures no efforts";
      return std::nullopt;
    }
  }
  if (channel.empty()) {
    why = "the body has no joints";
    return std::nullopt;
  }
  // Joints of one group are measured together; where one missed a cycle the others' values of it are left out.
  r.time_s = time_s[channel[0]];
  r.q_rad.resize(channel.size()), r.effort_nm.resize(channel.size());
  std::vector<std::size_t> at(channel.size());
  std::vector<double> kept;
  for (const double t : r.time_s) {
    bool all = true;
    for (std::size_t k = 0; k < channel.size(); ++k) {
      const std::vector<double>& time = time_s[channel[k]];
      while (at[k] + 1 < time.size() && time[at[k]] < t - 0.002) ++at[k];
      all = all && time[at[k]] < t + 0.002 && time[at[k]] > t - 0.002;
    }
    if (!all) continue;
    kept.push_back(t);
    for (std::size_t k = 0; k < channel.size(); ++k) {
      r.q_rad[k].push_back(position_rad[channel[k]][at[k]]);
      r.effort_nm[k].push_back(effort_nm[channel[k]][at[k]]);
    }
  }
  r.time_s = std::move(kept);
  return r;
}

}  // namespace sinew::app
