#include "apps/gait/search.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <string_view>

#include "apps/gait/down_trial.hpp"
#include "apps/gait/kick_trial.hpp"
#include "apps/gait/push_trial.hpp"
#include "apps/gait/rise_trial.hpp"
#include "apps/gait/walk_trial.hpp"
#include "math/random.hpp"

namespace sinew::gait {
namespace {

using motion::KeyPose;
using motion::KickParams;
using motion::MotionBook;
using motion::StepKickParams;
using motion::WalkParams;

constexpr double kDegree = math::kPi / 180;
constexpr double kLeastPose_s = 0.1, kMostPose_s = 3;
constexpr const char* kTurn = "turn_from_left";
constexpr double kCostPerS = 0.05;
constexpr double kBadBlow_mps2 = 200;  // of a robot that falls over where it stands
constexpr double kFallen = 4;          // a kick that misses counts 1
constexpr double kWantedBall_mps = 1.4, kGoodBall_mps = 1.25, kTooSlow = 0.3, kGoodDirection_deg = 4,
                 kBadDirection_deg = 24;

/// A number of a book, which may be at several places.
struct Places {
  std::vector<double*> at{};
  double unit = 1;  // of the file, in the book's
  double least = 0, most = 0;
};

/// Does `name`, with or without its side, mean this joint?
bool means(const std::string& name, const std::string& joint) {
  return joint == name || ((joint.starts_with("l_") || joint.starts_with("r_")) && joint.substr(2) == name);
}

void find_joint(std::vector<KeyPose>& poses, std::size_t pose, const std::string& name, const kinematics::Body& body,
                Places& out) {
  for (std::size_t j = 0; j < body.joints(); ++j) {
    const kinematics::Link& link = body.links[j + 1];
    if (!means(name, link.name)) continue;
    const double was = poses[pose].rad[j];
    for (std::size_t p = pose; p < poses.size() && poses[p].rad[j] == was; ++p) out.at.push_back(&poses[p].rad[j]);
    out.least = link.least_rad / kDegree;
    out.most = link.most_rad / kDegree;
  }
  out.unit = kDegree;
}

/// Without places: there is no such number.
Places find(MotionBook& book, const kinematics::Body& body, const SearchFor& what, const std::string& name) {
  Places out;
  if (what.kick && what.within_step) {
    StepKickParams& kick = *what.kick == motion::KickWay::forward ? book.step_kick_forward : book.step_kick_outward;
    if (const auto* row = motion::find_param<StepKickParams>(motion::kStepKickParams, name))
      out = {{&(kick.*row->value)}, 1, row->least, row->most};
    return out;
  }
  if (what.kick) {
    KickParams& kick = *what.kick == motion::KickWay::forward ? book.kick_forward : book.kick_outward;
    if (const auto* row = motion::find_param<KickParams>(motion::kKickParams, name))
      out = {{&(kick.*row->value)}, 1, row->least, row->most};
    return out;
  }
  if (what.motion.empty()) {
    if (const auto* row = motion::find_param<WalkParams>(motion::kWalkParams, name))
      out = {{&(book.walk.*row->value)}, 1, row->least, row->most};
    return out;
  }
  const std::size_t slash = name.find('/');
  const auto found = book.poses.find(what.motion);
  if (slash == name.npos || found == book.poses.end()) return out;
  std::vector<KeyPose>& poses = found->second;
  const auto pose = std::ranges::find(poses, name.substr(0, slash), &KeyPose::name);
  if (pose == poses.end()) return out;
  const std::string of_pose = name.substr(slash + 1);
  if (of_pose == "duration_s") return {{&pose->duration_s}, 1, 0, 10};
  find_joint(poses, static_cast<std::size_t>(pose - poses.begin()), of_pose, body, out);
  return out;
}

/// Of a joint that this pose moves; empty: of one that it does not, or of the right one of two that do the same.
std::string moved_joint(const std::vector<KeyPose>& poses, std::size_t pose, std::size_t j,
                        const motion::JointAngles& rest_rad, const kinematics::Body& body) {
  const motion::JointAngles& before = pose == 0 ? rest_rad : poses[pose - 1].rad;
  const motion::JointAngles& now = poses[pose].rad;
  const std::string& name = body.links[j + 1].name;
  const auto moves = [&](std::size_t joint) { return now[joint] != before[joint]; };
  if (!name.starts_with("l_") && !name.starts_with("r_")) return moves(j) ? name : "";
  const auto twin = body.find_link((name[0] == 'l' ? "r_" : "l_") + name.substr(2));
  const bool same = twin && now[*twin - 1] == now[j] && before[*twin - 1] == before[j];
  if (!moves(j)) return {};
  if (!same) return name;
  return name[0] == 'l' ? name.substr(2) : std::string{};
}

/// By how much a speed was missed, as a part of the largest.
double missed(double got, double wanted, double most) {
  return most > 0 ? std::min(1.0, math::fabs(got - wanted) / most) : 0;
}

double cost_of_run(const WalkResult& r, Course course, double lasts_s, const WalkParams& walk) {
  if (r.fell) return 2 - r.time_s / lasts_s;
  double speeds = 0;
  if (course != Course::mixed)  // its commands are scaled down where they are too much together
    speeds = missed(r.forward_mps, r.wanted_forward_mps, walk.most_forward_mps) +
             missed(r.left_mps, r.wanted_left_mps, walk.most_side_mps) +
             missed(r.turn_radps, r.wanted_turn_radps, walk.most_turn_radps);
  return speeds + 0.1 * r.tilt_rad + 0.15 * r.step_error_m / std::max(0.02, r.step_m);
}

bool parse_number(std::string_view text, double& out) {
  const auto end = std::from_chars(text.data(), text.data() + text.size(), out);
  return end.ec == std::errc{} && end.ptr == text.data() + text.size();
}

}  // namespace

std::vector<Searched> standard_numbers(const SearchFor& what) {
  if (what.kick && what.within_step) {
    return {{"stretch", 1, 2.2},    {"back_m", -0.02, 0.12}, {"strike_m", 0.04, 0.25},
            {"lift_m", 0, 0.05},    {"tip_rad", 0, 0.8},     {"lean_back_rad", -0.2, 0.5},
            {"aim_rad", -0.3, 0.3}, {"back_at", 0.1, 0.6},   {"hit_at", 0.3, 0.95},
            {"hold", 0, 0.4}};
  }
  if (what.kick) {
    const bool ahead = *what.kick == motion::KickWay::forward;
    return {{"shift_s", 0.3, 0.8},
            {"lift_s", 0.15, 0.6},
            {"still_s", 0, 0.3},
            {"strike_s", 0.03, 0.25},
            {"follow_s", 0, 0.3},
            {"return_s", 0.15, 0.6},
            {"com_inside_m", -0.02, 0.03},
            {"com_forward_m", -0.02, 0.03},
            {"taller_m", -0.01, 0.025},
            {"less_lean_rad", -0.1, 0.2},
            {"lift_m", 0.01, 0.1},
            {"strike_lift_m", 0.01, 0.1},
            {"back_m", ahead ? 0.0 : -0.03, ahead ? 0.12 : 0.06},
            {"strike_m", 0.06, 0.2},
            {"gyro_pitch_s", 0, 0.12},
            {"gyro_roll_s", 0, 0.12},
            {"tilt_pitch", -0.2, 0.8},
            {"tilt_roll", -0.2, 0.8},
            {"back_tip_rad", 0, 1},
            {"strike_tip_rad", 0, 1},
            {"lean_back_rad", -0.3, 0.3},
            {"arm_swing_rad", -2, 2}};
  }
  return {{"period_s", 0.2, 0.36},
          {"height_m", 0.2, 0.24},
          {"stance_m", 0.084, 0.11},
          {"lift_m", 0.012, 0.035},
          {"lean_rad", -0.05, 0.25},
          {"com_forward_m", -0.02, 0.02},
          {"cop_inside_m", -0.005, 0.02},
          {"omega_radps", 5, 7.5},
          {"swing_end", 0.7, 1},
          {"swing_ramp", 0.08, 0.45},
          {"gyro_pitch_s", 0, 0.08},
          {"gyro_roll_s", 0, 0.08},
          {"tilt_pitch", -0.1, 0.4},
          {"dcm_per_s", 1, 12},
          {"time_gain", 0, 1},
          {"late_s", 0, 0.06},
          {"lead_s", 0.02, 0.08},
          {"servo_gain_per_rad", 6, 16},
          {"scale_forward", 0.9, 1.4},
          {"scale_side", 0.8, 1.4},
          {"most_step_x_m", 0.12, 0.18},
          {"turn_stance_m_per_radps", 0, 0.02},
          {"cop_most_x_m", 0.01, 0.06}};
}

std::vector<Searched> numbers_of_motion(const GaitSetup& setup, const std::string& motion,
                                        const std::vector<std::string>& only, double range_deg, std::string& why) {
  const std::vector<KeyPose>* poses = setup.book.find(motion);
  if (poses == nullptr) {
    why = "the motion file has no motion " + motion;
    return {};
  }
  for (const std::string& name : only)
    if (std::ranges::find(*poses, name, &KeyPose::name) == poses->end()) {
      why = fmt::format("{} has no pose \"{}\"", motion, name);
      return {};
    }
  std::vector<Searched> out;
  for (std::size_t p = 0; p < poses->size(); ++p) {
    const KeyPose& pose = (*poses)[p];
    if (!only.empty() && std::ranges::find(only, pose.name) == only.end()) continue;
    out.push_back({pose.name + "/duration_s", std::max(kLeastPose_s, 0.5 * pose.duration_s),
                   std::min(kMostPose_s, 2 * pose.duration_s)});
    for (std::size_t j = 0; j < setup.body.joints(); ++j) {
      const std::string joint = moved_joint(*poses, p, j, setup.book.rest_rad, setup.body);
      if (joint.empty()) continue;
      const kinematics::Link& link = setup.body.links[j + 1];
      out.push_back({pose.name + '/' + joint, std::max(link.least_rad, pose.rad[j] - range_deg * kDegree) / kDegree,
                     std::min(link.most_rad, pose.rad[j] + range_deg * kDegree) / kDegree});
    }
  }
  return out;
}

std::vector<Searched> parse_searched(const GaitSetup& setup, const SearchFor& what, const std::string& text,
                                     std::string& why) {
  MotionBook book = setup.book;
  std::vector<Searched> out;
  std::string_view rest = text;
  while (!rest.empty()) {
    const std::string_view one = rest.substr(0, rest.find(','));
    rest.remove_prefix(std::min(rest.size(), one.size() + 1));
    const std::size_t a = one.find(':'), b = a == one.npos ? a : one.find(':', a + 1);
    Searched s{std::string(one.substr(0, a))};
    const Places places = find(book, setup.body, what, s.name);
    if (places.at.empty()) {
      why = fmt::format("{}: {} has no number of this name", s.name,
                        what.kick ? "the kick" : (what.motion.empty() ? "the walk" : what.motion));
      return {};
    }
    if (b == one.npos || !parse_number(one.substr(a + 1, b - a - 1), s.least) ||
        !parse_number(one.substr(b + 1), s.most) || !(s.least < s.most) || s.least < places.least ||
        s.most > places.most) {
      why = fmt::format("{}: NAME:LEAST:MOST with {:g} <= LEAST < MOST <= {:g}", one, places.least, places.most);
      return {};
    }
    out.push_back(std::move(s));
  }
  return out;
}

namespace {

double cost_of_walk(const GaitSetup& setup, const SearchOptions& o, std::uint64_t i, std::uint64_t seed,
                    std::string& why) {
  WalkTrial trial;
  trial.course = kCourses[i % kCourses.size()];
  trial.seed = seed;
  trial.lasts_s = o.lasts_s;
  if (o.push_mps > 0) {
    math::Random random(trial.seed, 7);
    trial.push = {o.push_mps, random.uniform(-math::kPi, math::kPi)};
    trial.push_every_s = 3;
  }
  const auto r = run_walk(setup, trial, why);
  return r ? cost_of_run(*r, trial.course, trial.lasts_s, setup.book.walk) : math::kInf;
}

double cost_of_push(const GaitSetup& setup, const SearchOptions& o, std::uint64_t i, std::uint64_t seed,
                    std::string& why) {
  static constexpr double kFrom_rad[] = {math::kPi, 0.5 * math::kPi, -0.5 * math::kPi, 0};  // front, right, left, back
  PushTrial trial;
  trial.seed = seed;
  trial.direction_rad = kFrom_rad[i % 4];
  trial.speed_mps = i % 4 == 1 || i % 4 == 2 ? o.push_side_mps : o.push_along_mps;
  trial.react = false;
  const auto r = run_push(setup, trial, why);
  return r && !r->fell ? 0 : 1;
}

double cost_of_kick(const GaitSetup& setup, const SearchOptions& o, std::uint64_t i, std::uint64_t seed,
                    std::string& why) {
  const auto r = run_kick(setup, {seed, motion::kSides[i % 2], *o.kick, o.within_step}, why);
  if (!r) return math::kInf;
  if (r->fell) return kFallen;
  if (!r->touched) return 1;
  const double off_deg = math::fabs(r->direction_deg) - kGoodDirection_deg;
  return std::max(0.0, 1 - r->speed_mps / kWantedBall_mps) + (r->speed_mps < kGoodBall_mps ? kTooSlow : 0) +
         0.5 * std::clamp(off_deg / (kBadDirection_deg - kGoodDirection_deg), 0.0, 1.0);
}

double cost_of_motion(const GaitSetup& setup, const std::string& motion, std::uint64_t seed, std::string& why) {
  if (motion == kGetDown) {
    const auto r = run_down(setup, seed, why);
    return r ? std::min(1.0, r->blow_mps2 / kBadBlow_mps2) + (r->lies ? 0 : 0.5) + (r->gently ? 0 : 0.25) : math::kInf;
  }
  if (motion == kTurn) {
    const auto r = run_turn(setup, motion, motion::FallWay::left, seed, why);
    if (!r) return math::kInf;
    return r->lay ? (1 + r->up.x) / 2 + kCostPerS * r->lasts_s : 0;  // it may roll off its side by itself
  }
  const auto r = run_motion(setup, motion, seed, why);
  if (!r) return math::kInf;
  const bool from_back = motion.find("back") != std::string::npos;
  return r->shortfall + (r->stood ? 0 : 0.5) + (from_back ? 0.5 * r->from_front : 0);
}

}  // namespace

double cost_of(const GaitSetup& setup, const SearchOptions& o, std::uint64_t generation, std::string& why) {
  double total = 0;
  for (std::uint64_t i = 0; i < o.runs; ++i) {
    const std::uint64_t seed = 1000 + 100 * generation + i;
    if (o.kick)
      total += cost_of_kick(setup, o, i, seed, why);
    else if (o.motion.empty())
      total += cost_of_walk(setup, o, i, seed, why);
    else
      total += cost_of_motion(setup, o.motion, seed, why);
    if (!why.empty()) return math::kInf;
  }
  double fallen = 0;
  for (std::uint64_t i = 0; i < o.pushes; ++i) {
    fallen += cost_of_push(setup, o, i, 1000 + 100 * generation + i, why);
    if (!why.empty()) return math::kInf;
  }
  return total / static_cast<double>(o.runs) + fallen / static_cast<double>(std::max<std::uint64_t>(o.pushes, 1));
}

std::vector<double> start_of(const GaitSetup& setup, const SearchOptions& o) {
  MotionBook book = setup.book;
  std::vector<double> out;
  for (const Searched& s : o.numbers) {
    const Places places = find(book, setup.body, o, s.name);
    const double value = *places.at.front() / places.unit;
    out.push_back(std::clamp((value - s.least) / (s.most - s.least), 0.0, 1.0));
  }
  return out;
}

std::vector<GaitSetup> setups_of(const GaitSetup& setup, const SearchOptions& o,
                                 const std::vector<std::vector<double>>& samples) {
  std::vector<GaitSetup> out(samples.size(), setup);
  for (std::size_t k = 0; k < samples.size(); ++k) {
    std::vector<Places> places;  // all before any of them changes: what was the same is told by its value
    for (const Searched& s : o.numbers) places.push_back(find(out[k].book, setup.body, o, s.name));
    for (std::size_t i = 0; i < o.numbers.size(); ++i) {
      const Searched& s = o.numbers[i];
      const double value = s.least + std::clamp(samples[k][i], 0.0, 1.0) * (s.most - s.least);
      for (double* place : places[i].at) *place = value * places[i].unit;
    }
  }
  return out;
}

}  // namespace sinew::gait
