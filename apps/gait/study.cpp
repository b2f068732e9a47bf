#include "apps/gait/study.hpp"

#include <array>

#include "apps/gait/down_trial.hpp"
#include "apps/gait/kick_trial.hpp"
#include "apps/gait/push_trial.hpp"
#include "apps/gait/rise_trial.hpp"
#include "apps/gait/stop_trial.hpp"
#include "math/random.hpp"

namespace sinew::gait {
namespace {

using app::Json;

struct NamedDirection {
  const char* name;
  double rad;
};
// Of the push: from the back it goes forward.
constexpr std::array<NamedDirection, 4> kDirections{
    {{"from back", 0}, {"from front", math::kPi}, {"from right", math::kPi / 2}, {"from left", -math::kPi / 2}}};

constexpr double kBallAside_m = 0.14;  // of a ball that feet of a standing robot touch only just

Json walk_case(const StudyOptions& o, const GaitSetup& setup, std::uint64_t n, std::string& why) {
  const Course course = o.courses[n % o.courses.size()];
  const auto r =
      run_walk(setup, {.course = course, .seed = o.first_seed + n, .lasts_s = o.lasts_s, .looks = o.looks}, why);
  if (!r) return {};
  return {{"kind", "walk"},
          {"group", to_string(course)},
          {"seed", o.first_seed + n},
          {"fell", r->fell},
          {"time_s", r->time_s},
          {"forward_mps", r->forward_mps},
          {"left_mps", r->left_mps},
          {"turn_radps", r->turn_radps},
          {"odometry_m", r->odometry_m},
          {"path_m", r->path_m},
          {"second_error_m", r->step_error_m},
          {"off_axis_rad", r->off_axis_rad},
          {"most_off_axis_rad", r->most_off_axis_rad},
          {"false_alarm", r->false_alarm}};
}

Json push_case(const StudyOptions& o, const GaitSetup& setup, std::uint64_t n, std::string& why) {
  const std::uint64_t group = n % (4 * o.push_mps.size()), run = n / (4 * o.push_mps.size());
  const NamedDirection& direction = kDirections[group % 4];
  const double speed = o.push_mps[group / 4];
  const std::uint64_t seed = o.first_seed + run;
  const auto r =
      run_push(setup, {.seed = seed, .speed_mps = speed, .direction_rad = direction.rad, .react = false}, why);
  if (!r) return {};
  return {{"kind", "push"}, {"group", direction.name}, {"speed_mps", speed},
          {"seed", seed},   {"fell", r->fell},         {"fell_before", r->fell_before}};
}

Json rise_case(const StudyOptions& o, const GaitSetup& setup, std::uint64_t n, std::string& why) {
  struct Way {
    const char* name;
    motion::FallWay lies_on;
  };
  static constexpr Way kWays[] = {{"front", motion::FallWay::front},
                                  {"back", motion::FallWay::back},
                                  {"left side", motion::FallWay::left},
                                  {"right side", motion::FallWay::right}};
  const Way& way = kWays[n % 4];
  const std::uint64_t seed = o.first_seed + n / 4;
  const auto r = run_rise(setup, way.lies_on, seed, why);
  if (!r) return {};
  return {{"kind", "rise"},       {"group", way.name}, {"limit_s", most_rise_s(way.lies_on)},
          {"seed", seed},         {"stood", r->stood}, {"time_s", r->time_s},
          {"motions", r->motions}};
}

Json fall_case(const StudyOptions& o, const GaitSetup& setup, std::uint64_t n, std::string& why) {
  const NamedDirection& direction = kDirections[n / 2 % 4];
  const bool react = n % 2 == 0;
  const std::uint64_t seed = kUnseenSeeds + n / 8;
  const auto r =
      run_push(setup, {.seed = seed, .speed_mps = o.fall_mps, .direction_rad = direction.rad, .react = react}, why);
  if (!r) return {};
  return {{"kind", "fall"},
          {"group", direction.name},
          {"seed", seed},
          {"react", react},
          {"fell", r->fell},
          {"seen", r->seen},
          {"fell_before", r->fell_before},
          {"ahead_s", r->ahead_s},
          {"hit_after_s", r->hit_after_s},
          {"impact_nms", r->impact_nms},
          {"gear_nm", r->gear_nm}};
}

Json kick_case(const StudyOptions&, const GaitSetup& setup, std::uint64_t n, std::string& why) {
  KickTrial trial{.seed = kUnseenSeeds + n / 8};
  trial.foot = n % 2 == 0 ? motion::Side::left : motion::Side::right;
  trial.way = n / 2 % 2 == 0 ? motion::KickWay::forward : motion::KickWay::outward;
  trial.walking = n / 4 % 2 == 1;
  const auto r = run_kick(setup, trial, why);
  if (!r) return {};
  const std::string group = std::string(trial.walking ? "in-walk" : "standing") + ' ' +
                            (trial.foot == motion::Side::left ? "left" : "right") + ' ' +
                            (trial.way == motion::KickWay::forward ? "forward" : "outward");
  return {{"kind", "kick"},
          {"group", group},
          {"seed", trial.seed},
          {"fell", r->fell},
          {"touched", r->touched},
          {"speed_mps", r->speed_mps},
          {"direction_deg", r->direction_deg},
          {"rolls_m", r->rolls_m}};
}

Json stop_case(const StudyOptions& o, const GaitSetup& setup, std::uint64_t n, std::string& why) {
  StopTrial trial{.seed = o.first_seed + n / 8, .speed_mps = o.ball_mps};
  trial.foot = n % 2 == 0 ? motion::Side::left : motion::Side::right;
  trial.aside_m = n / 2 % 2 == 0 ? 0 : kBallAside_m;
  trial.stops = n / 4 % 2 == 0;
  const auto r = run_stop(setup, trial, why);
  if (!r) return {};
  const std::string group = std::string(trial.aside_m == 0 ? "straight at it" : "beside it") +
                            (trial.foot == motion::Side::left ? ", left foot" : ", right foot") +
                            (trial.stops ? "" : ", only standing");
  return {{"kind", "stop"},        {"group", group},          {"seed", trial.seed},        {"fell", r->fell},
          {"touched", r->touched}, {"stopped", r->stopped()}, {"touch_mps", r->touch_mps}, {"speed_mps", r->speed_mps},
          {"away_m", r->away_m}};
}

Json down_case(const GaitSetup& setup, std::uint64_t n, std::string& why) {
  const std::uint64_t seed = kUnseenSeeds + n;
  const auto r = run_down(setup, seed, why);
  if (!r) return {};
  return {{"kind", "down"},      {"group", kGetDown},        {"seed", seed}, {"gently", r->gently}, {"lies", r->lies},
          {"time_s", r->time_s}, {"blow_mps2", r->blow_mps2}};
}

}  // namespace

std::string to_string(Kind kind) {
  static constexpr const char* kNames[] = {"walk", "push", "rise", "fall", "kick", "stop", "down"};
  return kNames[static_cast<std::size_t>(kind)];
}

std::uint64_t cases_of(const StudyOptions& o) {
  switch (o.kind) {
    case Kind::walk:
    case Kind::down:
      return o.runs;
    case Kind::push:
      return o.runs * 4 * o.push_mps.size();
    case Kind::rise:
      return o.runs * 4;
    case Kind::fall:
    case Kind::kick:
    case Kind::stop:
      return o.runs * 8;
  }
  return 0;
}

Json run_case(const StudyOptions& o, const GaitSetup& setup, std::uint64_t n, std::string& why) {
  switch (o.kind) {
    case Kind::walk:
      return walk_case(o, setup, n, why);
    case Kind::push:
      return push_case(o, setup, n, why);
    case Kind::rise:
      return rise_case(o, setup, n, why);
    case Kind::fall:
      return fall_case(o, setup, n, why);
    case Kind::kick:
      return kick_case(o, setup, n, why);
    case Kind::stop:
      return stop_case(o, setup, n, why);
    case Kind::down:
      return down_case(setup, n, why);
  }
  return {};
}

Json identity(const StudyOptions& o) {
  Json out{{"study", "gait " + to_string(o.kind)}, {"runs", o.runs}};
  if (o.kind == Kind::walk) {
    out["lasts_s"] = o.lasts_s;
    if (o.looks) out["looks"] = true;
    out["first_seed"] = o.first_seed;
    for (const Course course : o.courses) out["courses"].push_back(to_string(course));
  }
  if (o.kind == Kind::rise) out["first_seed"] = o.first_seed;
  if (o.kind == Kind::push) {
    out["push_mps"] = o.push_mps;
    out["first_seed"] = o.first_seed;
  }
  if (o.kind == Kind::fall) out["fall_mps"] = o.fall_mps;
  if (o.kind == Kind::stop) {
    out["ball_mps"] = o.ball_mps;
    out["first_seed"] = o.first_seed;
  }
  return out;
}

}  // namespace sinew::gait
