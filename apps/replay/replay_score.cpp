#include "apps/replay/replay_score.hpp"

#include <bit>
#include <sstream>

#include "apps/command/json.hpp"

namespace sinew::app {
namespace {

constexpr const char* kKey = "replay_score";

// As bits: JSON has no infinity.
Json bits_of(double value) { return std::bit_cast<std::uint64_t>(value); }
double double_of(const Json& bits) { return std::bit_cast<double>(bits.get<std::uint64_t>()); }

Json score_json(const record::Deviation& d) {
  return Json::array({d.count, bits_of(d.sum_of_squares), bits_of(d.max), d.max_at.ns});
}

record::Deviation deviation_of(const Json& json) {
  record::Deviation d;
  d.count = json.at(0).get<std::uint64_t>();
  d.sum_of_squares = double_of(json.at(1));
  d.max = double_of(json.at(2));
  d.max_at.ns = json.at(3).get<std::int64_t>();
  return d;
}

std::optional<ReplayScore> score_of(const std::string& line) {
  const Json json = Json::parse(line, nullptr, false);
  if (!json.is_object() || !json.contains(kKey)) return std::nullopt;
  ReplayScore score;
  try {  // of our own text; what a module printed is no score
    const Json& values = json.at(kKey);
    score.now = deviation_of(values.at("now"));
    score.recorded = deviation_of(values.at("recorded"));
    score.missing = values.at("missing").get<std::uint64_t>();
    score.stopped = values.at("stopped").get<std::vector<std::string>>();
    score.failed = values.at("failed").get<std::string>();
  } catch (const std::exception&) {
    return std::nullopt;
  }
  return score;
}

}  // namespace

std::string to_line(const ReplayScore& score) {
  Json json;
  json[kKey] = {{"now", score_json(score.now)},
                {"recorded", score_json(score.recorded)},
                {"missing", score.missing},
                {"stopped", score.stopped},
                {"failed", score.failed}};
  return to_line(json);
}

std::optional<ReplayScore> parse_replay_score(const std::string& text) {
  std::istringstream in(text);
  std::string line;
  std::optional<ReplayScore> last;
  while (std::getline(in, line))
    if (auto score = score_of(line)) last = std::move(score);
  return last;
}

}  // namespace sinew::app
