#include "monitor/run_jobs.hpp"

#include <algorithm>
#include <utility>

#include "monitor/json_reply.hpp"

namespace sinew::monitor {
namespace {

/// Exit code 1 says that something differs, or was left out: the JSON has what.
bool has_result(const ProgramEnd& end) { return end.why.empty() && end.exit_code && *end.exit_code <= 1; }

RunJobs::State state_of(const Json& result) {
  const auto identical = result.find("identical");  // of a replay
  if (identical == result.end() || !identical->is_boolean()) return RunJobs::State::done;
  return identical->get<bool>() ? RunJobs::State::identical : RunJobs::State::differs;
}

}  // namespace

std::string_view to_string(RunJobs::State state) {
  static constexpr std::string_view kNames[] = {"none", "running", "identical", "differs", "failed", "done"};
  return kNames[static_cast<std::size_t>(state)];
}

bool RunJobs::begin(const std::string& name, std::vector<std::string> argv) {
  if (!running().empty()) return false;
  std::erase_if(jobs_, [&](const Job& job) { return job.name == name; });
  if (jobs_.size() >= kMostKept) jobs_.pop_front();
  const std::uint64_t number = ++last_;
  auto program = std::make_unique<Program>(
      std::move(argv), ProgramLimits{.patience = kPatience}, [this, number](const ProgramEnd& end) {
        State state = State::failed;
        std::string result;
        if (has_result(end)) {
          const Json json = Json::parse(end.output, nullptr, false);
          if (json.is_object()) state = state_of(json), result = to_text(json);
        }
        const std::string why = result.empty() ? reason(end) : "";
        server_.post([this, number, state, result, why] { ended(number, state, result, why); });
      });
  jobs_.push_back({name, number, Clock::now()});
  jobs_.back().program = std::move(program);
  return true;
}

bool RunJobs::end(const std::string& name) {
  const Job* const job = find(name);
  if (!job || !job->program) return false;
  job->program->end();
  return true;
}

void RunJobs::ended(std::uint64_t number, State state, std::string result, std::string why) {
  const auto job = std::find_if(jobs_.begin(), jobs_.end(), [&](const Job& j) { return j.number == number; });
  if (job == jobs_.end()) return;
  job->program = nullptr;  // its thread has called us and returns: nothing to wait for
  job->state = state, job->result = std::move(result), job->why = std::move(why);
  job->seconds = std::chrono::duration<double>(Clock::now() - job->begun).count();
}

std::string RunJobs::running() const {
  const auto job = std::find_if(jobs_.begin(), jobs_.end(), [](const Job& j) { return j.state == State::running; });
  return job == jobs_.end() ? std::string() : job->name;
}

const RunJobs::Job* RunJobs::find(const std::string& name) const {
  const auto job = std::find_if(jobs_.begin(), jobs_.end(), [&](const Job& j) { return j.name == name; });
  return job == jobs_.end() ? nullptr : &*job;
}

RunJobs::State RunJobs::state(const std::string& name) const {
  const Job* const job = find(name);
  return job ? job->state : State::none;
}

std::string RunJobs::describe(const std::string& name) const {
  const Job* const job = find(name);
  Json json{{"ok", true}, {"state", to_string(job ? job->state : State::none)}};
  if (!job) return to_text(json);
  json["seconds"] =
      job->state == State::running ? std::chrono::duration<double>(Clock::now() - job->begun).count() : job->seconds;
  if (!job->why.empty()) json["why"] = job->why;
  std::string text = to_text(json);
  if (!job->result.empty()) text.insert(text.size() - 1, ",\"result\":" + job->result);
  return text;
}

}  // namespace sinew::monitor
