#include "apps/live/status_text.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "apps/view/graph_text.hpp"
#include "msg/actuators.hpp"

namespace sinew::app {
namespace {

const Json& list(const Json& of, const char* key) {
  static const Json kNone = Json::array();
  const auto at = of.is_object() ? of.find(key) : of.end();
  return at != of.end() && at->is_array() ? *at : kNone;
}

std::uint64_t number(const Json& of, const char* key) {
  const auto at = of.is_object() ? of.find(key) : of.end();
  return at != of.end() && at->is_number_unsigned() ? at->get<std::uint64_t>() : 0;
}

std::string text(const Json& of, const char* key) {
  const auto at = of.is_object() ? of.find(key) : of.end();
  return at != of.end() && at->is_string() ? at->get<std::string>() : std::string();
}

bool flag(const Json& of, const char* key) {
  const auto at = of.is_object() ? of.find(key) : of.end();
  return at != of.end() && at->is_boolean() && at->get<bool>();
}

rt::Duration quantile(const Json& of, const char* histogram, const char* which) {
  const auto at = of.is_object() ? of.find(histogram) : of.end();
  return rt::Duration{at != of.end() ? static_cast<std::int64_t>(number(*at, which)) : 0};
}

// "pad, motion": the names of those for which `is` holds, or "none".
template <class Is>
std::string names_of(const Json& all, Is is) {
  std::string names;
  for (const Json& one : all)
    if (is(one)) names += (names.empty() ? "" : ", ") + text(one, "name");
  return names.empty() ? "none" : names;
}

const char* state_of(const Json& module) {
  if (flag(module, "running")) return "runs";
  return number(module, "stops") > 0 ? "stopped" : "disabled";
}

std::string chain_line(const Json& c) {
  return fmt::format("chain     {}: age p50 {} p99 {} max {}, budget {} missed {} of {}\n", text(c, "name"),
                     human(quantile(c, "age", "p50_ns")), human(quantile(c, "age", "p99_ns")),
                     human(quantile(c, "age", "max_ns")),
                     human(rt::Duration{static_cast<std::int64_t>(number(c, "budget_ns"))}), number(c, "budget_misses"),
                     c.contains("age") ? number(c["age"], "count") : 0);
}

// Whether the guardian passes commands or is ready to arm; else every reason against arming.
std::string guardian_lines(const Json& guardian) {
  const bool permitted = number(guardian, "permitted") != 0, ready = number(guardian, "ready") != 0;
  const auto mode = static_cast<std::uint32_t>(number(guardian, "mode"));
  const std::string_view name = msg::name_of(msg::kGuardianModeNames, mode);
  std::string out = fmt::format("guardian  {}; commands ", name.empty() ? std::to_string(mode) : std::string(name));
  if (permitted) return out + "pass\n";
  out += ready ? "do not pass; ready to arm\n" : "do not pass; not ready:\n";
  if (ready) return out;
  for (const Json& reason : list(guardian, "reasons"))
    if (reason.is_string()) out += fmt::format("          {}\n", reason.get_ref<const std::string&>());
  return out;
}

// The devices' complaints, word for word.
std::string device_lines(const Json& devices) {
  const Json& complaints = list(devices, "complaints");
  std::string out = fmt::format("devices   {}\n", complaints.empty() ? "nothing to complain about" : "complain:");
  for (const Json& line : complaints)
    if (line.is_string()) out += fmt::format("          {}\n", line.get_ref<const std::string&>());
  return out;
}

// One line for each mate.
std::string team_lines(const Json& team, std::uint64_t now_ns) {
  std::string out;
  for (const Json& mate : list(team, "mate")) {
    out += fmt::format("mate      {}: ", number(mate, "robot"));
    if (number(mate, "starts") == 0) {
      out += "never heard\n";
      continue;
    }
    const std::uint64_t heard_ns = std::min(number(mate, "heard"), now_ns);
    out += fmt::format("heard {} ago, {} frames, {} lost; ",
                       human(rt::Duration{static_cast<std::int64_t>(now_ns - heard_ns)}), number(mate, "frames"),
                       number(mate, "lost"));
    const auto bound = mate.find("clock_bound_ns");
    const std::int64_t bound_ns = bound != mate.end() && bound->is_number_integer() ? bound->get<std::int64_t>() : -1;
    out += bound_ns < 0 ? "its clock is not known: it does not hear us"
                        : "its clock is known to " + human(rt::Duration{bound_ns});
    if (const auto foreign = number(mate, "foreign")) out += fmt::format("; {} messages of another build", foreign);
    out += "\n";
  }
  const auto others = number(team, "strangers");
  if (others > 0)
    out += fmt::format("strangers {} frames, the last of robot {}\n", others, number(team, "last_stranger"));
  return out;
}

}  // namespace

std::string status_text(const Json& all) {
  const Json &threads = list(all, "threads"), &modules = list(all, "modules"), &topics = list(all, "topics");
  const auto over = [](const Json& t) { return number(t, "overruns") > 0; };
  const auto stopped = [](const Json& m) { return state_of(m) == std::string_view("stopped"); };
  const auto disabled = [](const Json& m) { return state_of(m) == std::string_view("disabled"); };
  const auto faulty = [](const Json& m) { return number(m, "fault") > 0; };
  const auto losing = [](const Json& t) { return number(t, "drops") > 0; };
  std::string out = fmt::format("robot     {}: process {}, board {}, {}\n", text(all, "robot"), number(all, "pid"),
                                text(all, "board"), flag(all, "virtual_time") ? "virtual time" : "real time");
  out += fmt::format("threads   {}; with overruns: {}\n", threads.size(), names_of(threads, over));
  out += fmt::format("modules   {}; stopped: {}; disabled: {}; with faults: {}\n", modules.size(),
                     names_of(modules, stopped), names_of(modules, disabled), names_of(modules, faulty));
  out += fmt::format("topics    {}; with losses: {}\n", topics.size(), names_of(topics, losing));
  for (const Json& c : list(all, "chains")) out += chain_line(c);
  if (const auto guardian = all.find("guardian"); guardian != all.end()) out += guardian_lines(*guardian);
  if (const auto team = all.find("team"); team != all.end()) out += team_lines(*team, number(all, "now_ns"));
  if (const auto devices = all.find("devices"); devices != all.end()) out += device_lines(*devices);
  if (const auto others = all.find("outsiders"); others != all.end())
    out += fmt::format("outsiders {} connected, {} requests so far\n", number(*others, "clients"),
                       number(*others, "requests"));
  return out;
}

std::string module_table(const Json& status) {
  std::string out = fmt::format("{:<16} {:<30} {:<12} {:<9} {:>9} {:>7} {:>6} {:>9}\n", "module", "type", "thread",
                                "state", "steps", "stale", "faults", "exec p99");
  for (const Json& m : list(status, "modules"))
    out += fmt::format("{:<16} {:<30} {:<12} {:<9} {:>9} {:>7} {:>6} {:>9}\n", text(m, "name"), text(m, "type"),
                       text(m, "thread"), state_of(m), number(m, "steps"), number(m, "stale"), number(m, "fault"),
                       human(quantile(m, "exec", "p99_ns")));
  return out;
}

StatusRows rows_of(const Json& status) {
  StatusRows rows;
  for (const Json& t : list(status, "threads"))
    rows.threads.push_back({text(t, "name"), static_cast<int>(number(t, "priority")), number(t, "completions"),
                            number(t, "overruns"), quantile(t, "lateness", "p50_ns"), quantile(t, "lateness", "p99_ns"),
                            quantile(t, "exec", "p99_ns")});
  for (const Json& t : list(status, "topics"))
    rows.topics.push_back({text(t, "name"), number(t, "messages"), number(t, "drops"), quantile(t, "age", "p99_ns")});
  return rows;
}

}  // namespace sinew::app
