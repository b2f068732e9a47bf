// The tables of a study.
#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "apps/gait/study.hpp"
#include "apps/sweep/statistics.hpp"
#include "apps/sweep/summary.hpp"

namespace sinew::gait {
namespace {

using app::Json;
using Rows = std::vector<std::vector<std::string>>;

constexpr double kDegrees = 180 / math::kPi;

double number(const Json& c, const char* key) { return c.value(key, 0.0); }
bool flag(const Json& c, const char* key) { return c.value(key, false); }

/// Cases by group, in the order in which groups appear first.
struct Groups {
  std::vector<std::string> order;
  std::map<std::string, std::vector<Json>> of;

  explicit Groups(const std::vector<Json>& cases) {
    for (const Json& c : cases) {
      const std::string name = c.value("group", "");
      if (!of.contains(name)) order.push_back(name);
      of[name].push_back(c);
    }
  }
};

double mean(const std::vector<Json>& cases, const char* key) {
  double total = 0;
  for (const Json& c : cases) total += math::fabs(number(c, key));
  return cases.empty() ? 0 : total / static_cast<double>(cases.size());
}
sweep::Quantiles spread(const std::vector<Json>& cases, const char* key) {
  sweep::Quantiles q;
  for (const Json& c : cases) q.add(number(c, key));
  return q;
}
std::string of(std::uint64_t some, std::size_t all) { return fmt::format("{} of {}", some, all); }
std::uint64_t count(const std::vector<Json>& cases, const char* key) {
  return static_cast<std::uint64_t>(
      std::count_if(cases.begin(), cases.end(), [&](const Json& c) { return flag(c, key); }));
}

std::string walk_table(const StudyOptions& o, const std::vector<Json>& cases) {
  const Groups groups(cases);
  Rows rows{{"course", "falls", "forward m/s", "left m/s", "turn rad/s", "odometry/path %", "false alarms"}};
  if (o.looks) rows[0].insert(rows[0].end(), {"camera off deg", "95 % of runs below"});
  for (const std::string& name : groups.order) {
    const std::vector<Json>& all = groups.of.at(name);
    double error = 0, path = 0;
    for (const Json& c : all) error += number(c, "odometry_m"), path += number(c, "path_m");
    rows.push_back({name, of(count(all, "fell"), all.size()), fmt::format("{:.3f}", mean(all, "forward_mps")),
                    fmt::format("{:.3f}", mean(all, "left_mps")), fmt::format("{:.2f}", mean(all, "turn_radps")),
                    fmt::format("{:.1f}", path > 0 ? 100 * error / path : 0),
                    std::to_string(count(all, "false_alarm"))});
    if (o.looks)
      for (const double degrees :
           {kDegrees * mean(all, "off_axis_rad"), kDegrees * spread(all, "most_off_axis_rad").at(0.95)})
        rows.back().push_back(fmt::format("{:.1f}", degrees));
  }
  rows.push_back(
      {"all", of(count(cases, "fell"), cases.size()), "", "", "", "", std::to_string(count(cases, "false_alarm"))});
  if (o.looks) rows.back().resize(rows[0].size());
  return sweep::table_text(rows, "<" + std::string(rows[0].size() - 1, '>'));
}

std::string push_table(const StudyOptions& o, const std::vector<Json>& cases) {
  Rows rows{{"survived, %"}};
  for (const double speed : o.push_mps) rows[0].push_back(fmt::format("{:g} m/s", speed));
  const Groups groups(cases);
  for (const std::string& name : groups.order) {
    rows.push_back({name});
    for (const double speed : o.push_mps) {
      std::uint64_t stood = 0, all = 0;
      for (const Json& c : groups.of.at(name))
        if (number(c, "speed_mps") == speed && !flag(c, "fell_before")) ++all, stood += flag(c, "fell") ? 0 : 1;
      const sweep::Interval sure = sweep::wilson_95(stood, all);
      rows.back().push_back(all == 0 ? "-"
                                     : fmt::format("{:.0f} ({:.0f}-{:.0f})",
                                                   100.0 * static_cast<double>(stood) / static_cast<double>(all),
                                                   100 * sure.low, 100 * sure.high));
    }
  }
  return sweep::table_text(rows, "<" + std::string(o.push_mps.size(), '>'));
}

std::string rise_table(const std::vector<Json>& cases) {
  Rows rows{{"from its", "within s", "stood", "median s", "slowest s", "most motions"}};
  const Groups groups(cases);
  for (const std::string& name : groups.order) {
    std::vector<Json> good;
    for (const Json& c : groups.of.at(name))
      if (flag(c, "stood")) good.push_back(c);
    const sweep::Quantiles time = spread(good, "time_s");
    rows.push_back({name, fmt::format("{:.0f}", number(groups.of.at(name).front(), "limit_s")),
                    of(good.size(), groups.of.at(name).size()), fmt::format("{:.2f}", time.at(0.5)),
                    fmt::format("{:.2f}", time.most()), fmt::format("{:.0f}", spread(good, "motions").most())});
  }
  return sweep::table_text(rows, "<>>>>>");
}

std::string fall_table(const std::vector<Json>& cases) {
  Rows rows{{"push", "reaction", "falls", "seen 150 ms ahead", "median ms", "push to hit ms", "impact N m s",
             "rotor at the gear N m"}};
  const Groups groups(cases);
  for (const std::string& name : groups.order)
    for (const bool react : {true, false}) {
      std::vector<Json> fallen;
      for (const Json& c : groups.of.at(name))
        if (flag(c, "react") == react && flag(c, "fell") && !flag(c, "fell_before")) fallen.push_back(c);
      const auto early =
          std::count_if(fallen.begin(), fallen.end(), [](const Json& c) { return number(c, "ahead_s") >= 0.15; });
      rows.push_back({name, react ? "yes" : "no", std::to_string(fallen.size()),
                      of(static_cast<std::uint64_t>(early), fallen.size()),
                      fmt::format("{:.0f}", 1000 * spread(fallen, "ahead_s").at(0.5)),
                      fmt::format("{:.0f}", 1000 * spread(fallen, "hit_after_s").at(0.5)),
                      fmt::format("{:.4f}", spread(fallen, "impact_nms").at(0.5)),
                      fmt::format("{:.1f}", spread(fallen, "gear_nm").at(0.5))});
    }
  return sweep::table_text(rows, "<<>>>>>>");
}

std::string kick_table(const std::vector<Json>& cases) {
  Rows rows{{"kick", "falls", "touched", "median m/s", "1.2 m/s or more", "within 10 deg", "rolls m"}};
  const Groups groups(cases);
  for (const std::string& name : groups.order) {
    const std::vector<Json>& all = groups.of.at(name);
    const auto fast =
        std::count_if(all.begin(), all.end(), [](const Json& c) { return number(c, "speed_mps") >= 1.2; });
    const auto straight = std::count_if(all.begin(), all.end(), [](const Json& c) {
      return flag(c, "touched") && math::fabs(number(c, "direction_deg")) <= 10;
    });
    rows.push_back(
        {name, of(count(all, "fell"), all.size()), of(count(all, "touched"), all.size()),
         fmt::format("{:.2f}", spread(all, "speed_mps").at(0.5)), of(static_cast<std::uint64_t>(fast), all.size()),
         of(static_cast<std::uint64_t>(straight), all.size()), fmt::format("{:.2f}", spread(all, "rolls_m").at(0.5))});
  }
  return sweep::table_text(rows, "<>>>>>>");
}

std::string stop_table(const std::vector<Json>& cases) {
  Rows rows{{"foot", "falls", "touched", "median m/s then", "stopped", "median m/s at the end", "median m away"}};
  const Groups groups(cases);
  for (const std::string& name : groups.order) {
    const std::vector<Json>& all = groups.of.at(name);
    rows.push_back({name, of(count(all, "fell"), all.size()), of(count(all, "touched"), all.size()),
                    fmt::format("{:.2f}", spread(all, "touch_mps").at(0.5)), of(count(all, "stopped"), all.size()),
                    fmt::format("{:.2f}", spread(all, "speed_mps").at(0.5)),
                    fmt::format("{:.2f}", spread(all, "away_m").at(0.5))});
  }
  return sweep::table_text(rows, "<>>>>>>");
}

std::string down_table(const std::vector<Json>& cases) {
  const sweep::Quantiles time = spread(cases, "time_s"), blow = spread(cases, "blow_mps2");
  const Rows rows{
      {"", "on its front", "without toppling", "median s", "blow m/s^2", "hardest"},
      {"getting down", of(count(cases, "lies"), cases.size()), of(count(cases, "gently"), cases.size()),
       fmt::format("{:.2f}", time.at(0.5)), fmt::format("{:.0f}", blow.at(0.5)), fmt::format("{:.0f}", blow.most())}};
  return sweep::table_text(rows, "<>>>>>");
}

}  // namespace

std::string study_table(const StudyOptions& o, const std::vector<Json>& cases) {
  switch (o.kind) {
    case Kind::walk:
      return walk_table(o, cases);
    case Kind::push:
      return push_table(o, cases);
    case Kind::rise:
      return rise_table(cases);
    case Kind::fall:
      return fall_table(cases);
    case Kind::kick:
      return kick_table(cases);
    case Kind::stop:
      return stop_table(cases);
    case Kind::down:
      return down_table(cases);
  }
  return {};
}

}  // namespace sinew::gait
