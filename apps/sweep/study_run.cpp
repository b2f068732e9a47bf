#include "apps/sweep/study_run.hpp"

#include <fmt/format.h>

#include <cstdio>
#include <filesystem>
#include <map>

#include "apps/command/progress.hpp"
#include "apps/sweep/process_pool.hpp"
#include "hal/linux/process.hpp"
#include "hal/platform.hpp"

namespace sinew::sweep {

namespace {

/// In the process of a case: its result is the one line of standard output.
int run_case(const StudyRun& study, std::uint64_t number) {
  std::string problem;
  const Json result = study.run(number, problem);
  if (!problem.empty() || !result.is_object()) {
    std::fprintf(stderr, "%s\n", problem.empty() ? "no result" : problem.c_str());
    return 1;
  }
  std::printf("%s\n", app::to_line(result).c_str());
  return std::fflush(stdout) == 0 ? 0 : 1;
}

/// The cases that are not in the file. False with `why`: one has no result, or the file took none; without: stopped.
bool run_cases(const StudyRun& study, ResultsFile& file, std::string& why) {
  app::Progress progress(study.what, true, app::ProgressOf::cases);
  progress.expect(study.identity.cases);
  progress.add_before(file.count());
  std::uint64_t next = 0, started = 0;
  std::map<std::uint64_t, std::uint64_t> under_way;
  const auto give = [&]() -> std::optional<Job> {
    while (next < study.identity.cases && file.has(next)) ++next;
    if (next == study.identity.cases) return std::nullopt;
    const std::uint64_t number = under_way[started++] = next++;
    return Job{.body = [&study, number] { return run_case(study, number); }};
  };
  const auto take = [&](std::uint64_t job, const JobResult& said) {
    const std::uint64_t number = under_way.extract(job).mapped();
    const Json result = Json::parse(said.output, nullptr, false);
    if (said.code != 0 || !result.is_object()) {
      if (!hal::stop_requested())
        why = fmt::format("{}: {}{}", study.name ? study.name(number) : fmt::format("case {}", number),
                          describe_end(said), said.errors.empty() ? "" : ": " + said.errors);
      return false;
    }
    if (!file.append(number, result, why)) return false;
    progress.add(1);
    return true;
  };
  ProcessPool pool(study.jobs, hal::Duration{static_cast<std::int64_t>(study.patience_s * 1e9)});
  return pool.run(give, take);
}

StudyEnd fail(const StudyRun& study, const std::string& why) {
  std::fprintf(stderr, "%s: %s\n", study.program.c_str(), why.c_str());
  return StudyEnd::failed;
}

}  // namespace

StudyEnd run_study(const StudyRun& study) {
  static_cast<void>(hal::stop_requested());  // from here on a signal only asks for the end
  hal::end_at_second_signal("\nended at once by a second signal; the same command goes on where it stopped\n");
  std::error_code ignored;  // opening the file tells
  if (const auto folder = std::filesystem::path(study.results).parent_path(); !folder.empty())
    std::filesystem::create_directories(folder, ignored);
  std::string why;
  const auto file = ResultsFile::open(study.results, study.identity, {}, why);
  if (!file) return fail(study, why);
  if (!run_cases(study, *file, why) && !why.empty()) return fail(study, why);
  if (file->count() < study.identity.cases) {
    std::fprintf(stderr, "%s: interrupted after %llu of %llu cases; the same command goes on\n", study.program.c_str(),
                 static_cast<unsigned long long>(file->count()), static_cast<unsigned long long>(study.identity.cases));
    return StudyEnd::interrupted;
  }
  return file->finish(study.identity.cases, why) ? StudyEnd::whole : fail(study, why);
}

bool read_cases(const std::string& path, std::vector<Json>& cases, std::string& why) {
  Identity identity;
  Shard shard;
  std::map<std::uint64_t, Json> by_number;
  const auto each = [&](const ResultLine& line) { return by_number[line.number] = line.result, true; };
  if (!read_results(path, identity, shard, each, why)) return false;
  for (auto& [number, result] : by_number) cases.push_back(std::move(result));
  return true;
}

}  // namespace sinew::sweep
