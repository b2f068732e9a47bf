#include <fmt/format.h>

#include <cstdio>

#include "apps/bag/bag_options.hpp"
#include "apps/command/command.hpp"
#include "apps/command/json.hpp"
#include "record/check.hpp"
#include "record/run/run_review.hpp"

namespace sinew::app {
namespace {

Json counts(const std::map<std::string, record::Losses>& losses) {
  Json json = Json::object();
  for (const auto& [name, lost] : losses) json[name] = {{"count", lost.count}, {"first_s", msg::seconds(lost.first)}};
  return json;
}

Json check_json(const std::string& file, const std::vector<std::string>& problems, const record::RunReview& review) {
  Json json = {{"file", file}, {"ok", problems.empty()}, {"problems", problems}};
  if (!review.is_run) return json;
  Json modules = Json::object();
  for (const auto& m : review.verdict) modules[m.module] = m.reasons;
  json["ended"] = review.ended;
  json["part"] = review.is_part;
  json["not_replayable"] = modules;
  json["lost_messages"] = counts(review.lost_messages);
  json["lost_steps"] = counts(review.lost_steps);
  return json;
}

std::string review_text(const record::RunReview& review) {
  if (!review.is_run) return {};
  std::string out;
  for (const auto& m : review.verdict) out += fmt::format("  {:<18} {}\n", m.module, to_text(m));
  for (const auto& [topic, lost] : review.lost_messages) out += topic + ": lost " + to_text(lost, "messages") + "\n";
  for (const auto& [thread, lost] : review.lost_steps)
    out += "thread " + thread + ": lost " + to_text(lost, "steps") + "\n";
  if (review.is_part)
    out += "only a part of a recording: what is missing before it does not count\n";
  else if (!review.ended)
    out += "the file has no verdict of its own: its recording was cut off, or goes on in another file\n";
  return out;
}

}  // namespace

int bag_check(const BagOptions& options) {
  std::vector<std::string> problems;
  record::RunReview review;
  {
    Progress progress("check");
    const auto file = open_input(options.file, progress);
    if (!file) return kNotBegun;
    const auto found = record::check(*file);
    if (!found.empty() && found.front().kind == record::ProblemKind::not_mcap)
      return fail(options.file + ": " + to_string(found.front()));
    for (const auto& p : found) problems.push_back(to_string(p));
    const auto reader = open_recording(options.file, progress);
    if (!reader) return kNotBegun;
    review = record::review(*reader);
    problems.insert(problems.end(), review.differences.begin(), review.differences.end());
  }
  for (const auto& p : problems) std::fprintf(stderr, "%s: %s\n", options.file.c_str(), p.c_str());
  if (options.json)
    std::printf("%s", to_line(check_json(options.file, problems, review)).c_str());
  else if (problems.empty())
    std::printf("%s: no problems\n%s", options.file.c_str(), review_text(review).c_str());
  else
    std::printf("%s: %zu problem%s\n%s", options.file.c_str(), problems.size(), problems.size() == 1 ? "" : "s",
                review_text(review).c_str());
  return problems.empty() ? kDone : kFailed;
}

}  // namespace sinew::app
