#include "apps/search/outcome_text.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

namespace sinew::search {

using nlohmann::json;

std::string to_json(const Case& c, const Outcome& o) {
  json j;
  j["case"] = to_string(c);
  j["failed"] = nullptr;
  if (o.violation)
    j["failed"] = {{"invariant", o.violation->invariant}, {"at_ns", o.violation->at.ns}, {"what", o.violation->what}};
  j["ending"] = static_cast<int>(o.ending);
  j["ending_text"] = to_string(o.ending);
  j["ended_s"] = o.ended_s;
  j["landing_error_m"] = o.landing_error_m;
  j["touchdown_speed_mps"] = o.touchdown_speed_mps;
  j["tilt_rad"] = o.worst.tilt_rad;
  j["tilt_error_rad"] = o.worst.tilt_error_rad;
  j["height_error_m"] = o.worst.height_error_m;
  j["age_ms"] = o.worst_age_ms;
  j["steps"] = o.steps;
  j["overruns"] = o.overruns;
  j["commands"] = o.commands;
  j["hash"] = fmt::format("{:016x}", o.hash);
  return j.dump();
}

std::optional<Outcome> parse_outcome(const std::string& line) {
  const json j = json::parse(line, nullptr, false);
  if (!j.is_object() || !j.contains("failed")) return std::nullopt;
  Outcome o;
  try {  // of our own text; what another program wrote is no outcome
    if (const json& f = j.at("failed"); !f.is_null())
      o.violation = Violation{f.at("invariant"), msg::Time{f.at("at_ns")}, f.at("what")};
    const int ending = j.at("ending");
    if (ending < 0 || ending > static_cast<int>(Ending::not_over)) return std::nullopt;
    o.ending = static_cast<Ending>(ending);
    o.ended_s = j.at("ended_s");
    o.landing_error_m = j.at("landing_error_m");
    o.touchdown_speed_mps = j.at("touchdown_speed_mps");
    o.worst = {j.at("tilt_rad"), j.at("tilt_error_rad"), j.at("height_error_m")};
    o.worst_age_ms = j.at("age_ms").get<std::map<std::string, double>>();
    o.steps = j.at("steps");
    o.overruns = j.at("overruns");
    o.commands = j.at("commands");
    o.hash = std::stoull(j.at("hash").get<std::string>(), nullptr, 16);
  } catch (const std::exception&) {
    return std::nullopt;
  }
  return o;
}

}  // namespace sinew::search
