#include "apps/gait/search.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <string_view>

#include "apps/gait/rise_trial.hpp"
#include "apps/gait/walk_trial.hpp"
#include "math/random.hpp"

namespace sinew::gait {
namespace {

using motion::WalkParams;

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
  return 0.3 * speeds + 0.1 * r.tilt_rad + 0.15 * r.step_error_m / std::max(0.02, r.step_m);
}

constexpr double kCostPerS = 0.05, kLeast_s = 0.1, kMost_s = 0.8;
constexpr std::string_view kDuration = "duration_s";

/// The number of this name in the setup. Names are from standard_numbers(), parse_searched() or pose_numbers().
double& number_of(GaitSetup& setup, const std::string& name) {
  const std::size_t a = name.find('/');
  if (a == name.npos) return setup.book.walk.*motion::find_param<WalkParams>(motion::kWalkParams, name)->value;
  const std::size_t b = name.find('/', a + 1);
  std::size_t pose = 0;
  std::from_chars(name.data() + a + 1, name.data() + b, pose);
  motion::KeyPose& at = setup.book.poses.at(name.substr(0, a)).at(pose);
  const std::string what = name.substr(b + 1);
  if (what == kDuration) return at.duration_s;
  return at.rad.at(setup.body.find_link(what).value() - 1);
}

double cost_of_motion(const GaitSetup& setup, const SearchOptions& o, std::uint64_t generation, std::string& why) {
  double total = 0;
  std::uint64_t counted = 0;
  for (std::uint64_t i = 0; i < o.runs; ++i) {
    const auto r = run_turn(setup, o.motion, o.lies_on, 1000 + 100 * generation + i, why);
    if (!r) return math::kInf;
    if (!r->lay) continue;
    ++counted;
    const double there = o.ends_on == motion::FallWay::front ? -r->up.x : r->up.x;
    total += (1 - there) / 2 + kCostPerS * r->lasts_s;
  }
  return counted > 0 ? total / static_cast<double>(counted) : 0;
}

bool parse_number(std::string_view text, double& out) {
  const auto end = std::from_chars(text.data(), text.data() + text.size(), out);
  return end.ec == std::errc{} && end.ptr == text.data() + text.size();
}

}  // namespace

std::vector<Searched> standard_numbers() {
  return {{"period_s", 0.2, 0.36},        {"height_m", 0.2, 0.24},       {"stance_m", 0.084, 0.11},
          {"lift_m", 0.012, 0.035},       {"lean_rad", -0.05, 0.25},     {"com_forward_m", -0.02, 0.02},
          {"cop_inside_m", -0.005, 0.02}, {"omega_radps", 5, 7.5},       {"swing_end", 0.7, 1},
          {"gyro_pitch_s", 0, 0.08},      {"gyro_roll_s", 0, 0.08},      {"tilt_pitch", -0.1, 0.4},
          {"dcm_per_s", 1, 12},           {"time_gain", 0, 1},           {"late_s", 0, 0.06},
          {"lead_s", 0.02, 0.08},         {"servo_gain_per_rad", 6, 16}, {"scale_forward", 0.9, 1.4},
          {"scale_side", 0.8, 1.4},       {"most_step_x_m", 0.12, 0.18}, {"turn_stance_m_per_radps", 0, 0.02},
          {"cop_most_x_m", 0.01, 0.06}};
}

std::vector<Searched> parse_searched(const std::string& text, std::string& why) {
  std::vector<Searched> out;
  std::string_view rest = text;
  while (!rest.empty()) {
    const std::string_view one = rest.substr(0, rest.find(','));
    rest.remove_prefix(std::min(rest.size(), one.size() + 1));
    const std::size_t a = one.find(':'), b = a == one.npos ? a : one.find(':', a + 1);
    Searched s{std::string(one.substr(0, a))};
    const auto* row = motion::find_param<WalkParams>(motion::kWalkParams, s.name);
    if (row == nullptr) {
      why = s.name + ": the walk has no number of this name";
      return {};
    }
    if (b == one.npos || !parse_number(one.substr(a + 1, b - a - 1), s.least) ||
        !parse_number(one.substr(b + 1), s.most) || !(s.least < s.most) || s.least < row->least || s.most > row->most) {
      why = fmt::format("{}: NAME:LEAST:MOST with {:g} <= LEAST < MOST <= {:g}", one, row->least, row->most);
      return {};
    }
    out.push_back(std::move(s));
  }
  return out;
}

std::vector<Searched> pose_numbers(const GaitSetup& setup, const std::string& motion, double range_rad) {
  std::vector<Searched> out;
  const std::vector<motion::KeyPose>* poses = setup.book.find(motion);
  if (poses == nullptr) return out;
  for (std::size_t p = 0; p < poses->size(); ++p) {
    const std::string prefix = fmt::format("{}/{}/", motion, p);
    out.push_back({prefix + std::string(kDuration), kLeast_s, kMost_s});
    for (std::size_t j = 0; j < setup.body.joints(); ++j) {
      const kinematics::Link& link = setup.body.links[j + 1];
      if (!link.name.starts_with("l_") && !link.name.starts_with("r_")) continue;
      const double rad = (*poses)[p].rad[j];
      const double least = std::max(link.least_rad, rad - range_rad), most = std::min(link.most_rad, rad + range_rad);
      if (least < most) out.push_back({prefix + link.name, least, most});
    }
  }
  return out;
}

double cost_of(const GaitSetup& setup, const SearchOptions& o, std::uint64_t generation, std::string& why) {
  if (!o.motion.empty()) return cost_of_motion(setup, o, generation, why);
  double total = 0;
  for (std::uint64_t i = 0; i < o.runs; ++i) {
    WalkTrial trial;
    trial.course = kCourses[i % kCourses.size()];
    trial.seed = 1000 + 100 * generation + i;
    trial.lasts_s = o.lasts_s;
    if (o.push_mps > 0) {
      math::Random random(trial.seed, 7);
      trial.push = {o.push_mps, random.uniform(-math::kPi, math::kPi)};
      trial.push_every_s = 3;
    }
    const auto r = run_walk(setup, trial, why);
    if (!r) return math::kInf;
    total += cost_of_run(*r, trial.course, trial.lasts_s, setup.book.walk);
  }
  return total / static_cast<double>(o.runs);
}

std::vector<double> start_of(const GaitSetup& setup, const std::vector<Searched>& numbers) {
  std::vector<double> out;
  GaitSetup own = setup;
  for (const Searched& s : numbers) {
    const double value = number_of(own, s.name);
    out.push_back(std::clamp((value - s.least) / (s.most - s.least), 0.0, 1.0));
  }
  return out;
}

std::vector<GaitSetup> setups_of(const GaitSetup& setup, const std::vector<Searched>& numbers,
                                 const std::vector<std::vector<double>>& samples) {
  std::vector<GaitSetup> out(samples.size(), setup);
  for (std::size_t k = 0; k < samples.size(); ++k)
    for (std::size_t i = 0; i < numbers.size(); ++i) {
      const Searched& s = numbers[i];
      number_of(out[k], s.name) = s.least + std::clamp(samples[k][i], 0.0, 1.0) * (s.most - s.least);
    }
  return out;
}

}  // namespace sinew::gait
