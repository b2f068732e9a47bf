#include "apps/replay/tuning.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <iterator>
#include <set>

#include "apps/bag/bag_file.hpp"
#include "apps/replay/recorded_robot.hpp"
#include "apps/robot_file/param_overlay.hpp"
#include "hal/linux/file.hpp"
#include "hal/silent_board.hpp"

namespace sinew::app {
namespace {

constexpr double kMostPatience_s = 1e9;  // in a Duration
constexpr std::size_t kMostPoints = 1'000'000;

std::unique_ptr<record::Reader> open_reader(const std::string& path, std::string& why) {
  auto file = hal::open_file(path);
  if (!file) {
    why = file.error().code == hal::Errc::not_found ? path + ": no such file" : file_error(path, file.error());
    return nullptr;
  }
  record::FileProblem problem;
  auto reader = record::Reader::open(std::move(*file), problem);
  if (!reader) why = path + ": " + record::to_string(problem);
  return reader;
}

void add(record::Deviation& to, const record::Deviation& more) {
  to.count += more.count;
  to.sum_of_squares += more.sum_of_squares;
  if (more.max > to.max) to.max = more.max, to.max_at = more.max_at;
}

/// Modules that `from` feeds, itself included, or (`up`) that feed it. Does not go on beyond `end`, so that no path
/// goes round a loop.
std::set<std::uint32_t> reach(const rt::Graph& graph, std::uint32_t from, std::uint32_t end, bool up) {
  std::set<std::uint32_t> found{from};
  const auto goes_on = [&](std::uint32_t m) { return m != end && found.contains(m); };
  for (bool more = true; more;) {
    more = false;
    for (std::uint32_t m = 0; m < graph.modules().size(); ++m) {
      const rt::GraphModule& module = graph.modules()[m];
      for (std::size_t p = 0; p < module.topic.size(); ++p) {
        if (module.topic[p] == rt::kNone || module.declaration.ports[p].kind == rt::Declaration::PortKind::output)
          continue;
        const std::uint32_t writer = graph.topics()[module.topic[p]].writer;
        if (writer != rt::kNone)
          more |= up ? goes_on(m) && found.insert(writer).second : goes_on(writer) && found.insert(m).second;
      }
    }
  }
  return found;
}

}  // namespace

struct Tuning::File {
  std::string path;
  rt::GraphSpec spec;
  std::optional<record::Truth> truth;
};

bool Score::counts() const { return error.count > 0 && stopped.empty() && missing * 100 <= error.count + missing; }

bool Tuning::prepare(TuningTask task, const rt::ModuleTypes& types, std::string& why) {
  task_ = std::move(task);
  types_ = &types;
  for (const std::string& path : task_.files)
    if (!open(path, why)) return false;
  points_ = grid(params_);
  return true;
}

bool Tuning::open(const std::string& path, std::string& why) {
  const auto reader = open_reader(path, why);
  if (!reader) return false;
  auto file = std::make_shared<File>();
  file->path = path;
  auto spec = recorded_spec(*reader, path, why);
  if (!spec) {
    why = path + ": " + why;
    return false;
  }
  if (why = window_problem(*reader, task_.from_s, task_.until_s); !why.empty()) {
    why = path + ": " + why;
    return false;
  }
  file->spec = std::move(*spec);
  if (files_.empty()) written_ = *written_spec(*reader, path, why);
  hal::SilentBoard board;
  const auto graph = configured_graph(file->spec, *types_, board, path, why);
  if (!graph) return false;
  params_.clear();
  double points = 1;
  for (const std::string& text : task_.params) {
    auto param = parse_sweep(text, *graph, why);
    if (!param) {
      why = path + ": " + why;
      return false;
    }
    for (const SweptParam& other : params_)
      if (other.name() == param->name()) {
        why = "--param " + param->name() + " stands twice";
        return false;
      }
    points *= static_cast<double>(param->values.size());
    params_.push_back(std::move(*param));
  }
  if (points > kMostPoints) {
    why = fmt::format("{:g} combinations; at most {}", points, kMostPoints);
    return false;
  }
  if (task_.against_truth) {
    const std::string topic = task_.truth.empty() ? record::Truth::topic_of(*reader) : task_.truth;
    if (topic.empty()) {
      why = path + ": has no topic ground_truth; --truth names another one, --against recorded needs none";
      return false;
    }
    file->truth = record::Truth::read(*reader, *graph, topic, why);
    if (!file->truth) {
      why = path + ": " + why;
      return false;
    }
  }
  files_.push_back(std::move(file));
  if (!choose_error(*graph, why)) {
    why = path + ": " + why;
    return false;
  }
  return true;
}

bool Tuning::choose_error(const rt::Graph& graph, std::string& why) {
  std::vector<std::string> matches;
  for (const std::string& name : record::quantity_names(graph))
    if (name == task_.error || record::means(task_.error, name)) matches.push_back(name);
  if (std::find(matches.begin(), matches.end(), task_.error) != matches.end()) matches = {task_.error};
  if (matches.size() != 1) {
    why = fmt::format("--error {}: ", task_.error);
    if (matches.empty()) {
      why += "no output of a module has it; `sinew graph` shows them";
      return false;
    }
    why += fmt::format(
        "may be {}",
        fmt::join(matches.begin(), matches.begin() + std::min<std::ptrdiff_t>(10, std::ssize(matches)), ", "));
    if (matches.size() > 10) why += fmt::format(" or one of {} more", matches.size() - 10);
    return false;
  }
  error_ = matches[0];
  record::ComparisonOptions options;
  options.quantities = {error_};
  options.truth = files_.back()->truth ? &*files_.back()->truth : nullptr;
  const auto compared = record::Comparison(graph, options).result();
  unit_ = compared[0].unit;
  if (task_.against_truth && !compared[0].has_truth) {
    why = fmt::format("--error {}: the truth does not have it; --against recorded", error_);
    return false;
  }
  for (const rt::GraphTopic& topic : graph.topics())
    if (error_.starts_with(topic.name + ".")) choose_modules(graph, topic.writer);
  if (modules_.empty()) {
    why = fmt::format("--error {}: it does not depend on these parameters", error_);
    return false;
  }
  return true;
}

/// Chooses the modules of the parameters, the module of the error, and those between them.
void Tuning::choose_modules(const rt::Graph& graph, std::uint32_t error_module) {
  std::set<std::uint32_t> chosen;
  for (const SweptParam& p : params_) {
    const std::uint32_t swept = graph.find_module(p.module);
    const auto fed = reach(graph, swept, error_module, false), feeding = reach(graph, error_module, swept, true);
    if (fed.contains(error_module))
      std::set_intersection(fed.begin(), fed.end(), feeding.begin(), feeding.end(),
                            std::inserter(chosen, chosen.end()));
  }
  modules_.clear();
  for (const std::uint32_t m : chosen) modules_.push_back(graph.modules()[m].spec.name);
  error_module_ = graph.modules()[error_module].spec.name;
}

bool Tuning::replay(std::size_t point, const File& file, ReplayScore& result, std::string& why) const {
  const auto reader = open_reader(file.path, why);
  if (!reader) return false;
  rt::GraphSpec spec = file.spec;
  apply(params_, points_[point], spec);
  hal::SilentBoard board;
  const auto graph = configured_graph(spec, *types_, board, file.path, why);
  if (!graph) return false;
  record::ComparisonOptions what;
  what.quantities = {error_};
  what.truth = file.truth ? &*file.truth : nullptr;
  what.from_s = task_.from_s;
  what.until_s = task_.until_s;
  what.record = record::recorded_time(*reader);
  record::Comparison comparison(*graph, what);
  record::ReplayOptions how;
  how.modules = modules_;
  how.until_s = task_.until_s;
  how.chain = true;
  for (const SweptParam& p : params_) how.keep.push_back(p.name());
  how.watcher = &comparison;
  const auto report = record::replay(*reader, *graph, how, why);
  if (!report) {
    why = file.path + ": " + why;
    return false;
  }
  if (!report->problems.empty()) {
    why = file.path + ": " + record::to_string(report->problems.front());
    return false;
  }
  const auto compared = comparison.result();
  result.now = task_.against_truth ? compared[0].now_from_truth : compared[0].now;
  result.recorded = compared[0].recorded_from_truth;
  for (const auto& m : report->modules) {
    if (m.name == error_module_) result.missing = m.missing + compared[0].not_a_number;
    if (!m.stopped.empty()) result.stopped.push_back(file.path + ": " + m.name + ": " + m.stopped);
  }
  return true;
}

/// In a copy of this process; `replay` counts the files of the first point, then those of the second, and so on.
int Tuning::replay_and_print(std::size_t replay) const {
  ReplayScore score;
  std::string why;
  if (!this->replay(replay / files_.size(), *files_[replay % files_.size()], score, why)) score.failed = why;
  std::fputs(to_line(score).c_str(), stdout);
  return std::fflush(stdout) == 0 ? 0 : 1;
}

ReplayScore Tuning::score_of(std::size_t replay, const sweep::JobResult& job) const {
  ReplayScore score;
  if (!job.not_started.empty()) {
    score.failed = job.not_started;
    return score;
  }
  auto printed = parse_replay_score(job.output);
  if (printed && job.code == 0 && !job.hung) return std::move(*printed);
  std::string end = sweep::describe_end(job);
  if (job.hung) end = fmt::format("hung: no end within {:g} s (--patience)", task_.patience_s);
  score.stopped = {files_[replay % files_.size()]->path + ": " + end};
  return score;
}

bool Tuning::run(const std::function<void(std::size_t)>& progress, std::string& why) {
  std::vector<ReplayScore> results(points_.size() * files_.size());
  why = "interrupted";
  std::size_t next = 0;
  sweep::ProcessPool pool(task_.jobs, std::chrono::duration_cast<hal::Duration>(
                                          std::chrono::duration<double>(std::min(task_.patience_s, kMostPatience_s))));
  const bool through = pool.run(
      [&]() -> std::optional<sweep::Job> {
        if (next == results.size()) return std::nullopt;
        return sweep::Job{.body = [this, replay = next++] { return replay_and_print(replay); }};
      },
      [&](std::uint64_t number, const sweep::JobResult& job) {
        const auto replay = static_cast<std::size_t>(number);
        results[replay] = score_of(replay, job);
        progress(1);
        if (results[replay].failed.empty()) return true;
        why = results[replay].failed;
        return false;
      });
  if (!through) return false;
  sum_up(results);
  return true;
}

void Tuning::sum_up(const std::vector<ReplayScore>& results) {
  scores_.assign(points_.size(), {});
  recorded_ = {};
  for (std::size_t i = 0; i < results.size(); ++i) {
    Score& score = scores_[i / files_.size()];
    add(score.error, results[i].now);
    score.files.push_back(results[i].now);
    score.missing += results[i].missing;
    score.stopped.insert(score.stopped.end(), results[i].stopped.begin(), results[i].stopped.end());
  }
  for (std::size_t f = 0; f < files_.size(); ++f) {  // any point with all messages has the same values
    const ReplayScore* most = &results[f];
    for (std::size_t p = 1; p < points_.size(); ++p)
      if (const ReplayScore& other = results[p * files_.size() + f]; other.recorded.count > most->recorded.count)
        most = &other;
    add(recorded_.error, most->recorded);
    recorded_.files.push_back(most->recorded);
  }
}

std::optional<std::size_t> Tuning::best() const {
  std::optional<std::size_t> best;
  for (std::size_t i = 0; i < scores_.size(); ++i)
    if (scores_[i].counts() && (!best || scores_[i].error.rms() < scores_[*best].error.rms())) best = i;
  return best;
}

std::string Tuning::robot_file_lines(std::size_t point) const {
  rt::GraphSpec spec = written_;
  apply(params_, points_[point], spec);
  std::string lines, done;
  for (const SweptParam& p : params_) {
    const auto module =
        std::find_if(spec.modules.begin(), spec.modules.end(), [&](const auto& m) { return m.name == p.module; });
    if (module == spec.modules.end() || done.find("." + p.module + ".") != std::string::npos) continue;
    done += "." + p.module + ".";
    std::string values;
    for (const auto& [name, value] : module->params)
      values += fmt::format("{}{} = {}", values.empty() ? "" : ", ", name, toml_value(value.value));
    lines += fmt::format("{}params = {{ {} }}  # [module.{}]", lines.empty() ? "" : "\n", values, p.module);
  }
  return lines;
}

}  // namespace sinew::app
