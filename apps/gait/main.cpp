// sinew-gait: what a humanoid's motions can do on the simulated pitch, and the search for their numbers.
// docs/walking.md.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>

#include "apps/command/choice_check.hpp"
#include "apps/command/number_check.hpp"
#include "apps/command/usage_error.hpp"
#include "apps/gait/cma_es.hpp"
#include "apps/gait/search.hpp"
#include "apps/gait/study.hpp"
#include "apps/sweep/process_pool.hpp"
#include "apps/sweep/study_run.hpp"
#include "apps/toml/body_reader.hpp"
#include "apps/toml/motion_reader.hpp"
#include "hal/linux/process.hpp"
#include "hal/platform.hpp"
#include "rt/graph_spec.hpp"

namespace {

using namespace sinew;
using namespace sinew::gait;

constexpr int kOk = 0, kNot = 1, kNotBegun = 2;
constexpr double kPatience_s = 3600;  // after which a case counts as hanging

struct Options {
  std::string body = "robots/kid/op3.toml", motions, results, out, numbers;
  std::vector<std::string> courses;  // none: all
  std::vector<std::string> poses;    // that are searched; none: all
  double range_deg = 30;
  StudyOptions study;
  SearchOptions search;
  double no_load_radps = math::kNan;
  unsigned jobs = 0;
  GaitSetup setup;
  std::string texts;  // of both files with all that they extend: results belong to them
};

int fail(const std::string& what) {
  std::fprintf(stderr, "sinew-gait: %s\n", what.c_str());
  return kNotBegun;
}

/// Body and motions; their problems go to stderr.
bool load(Options& o) {
  if (o.motions.empty()) o.motions = std::filesystem::path(o.body).replace_extension().string() + "_motion.toml";
  auto body = app::load_body(o.body);
  for (const rt::Problem& p : body.problems) std::fprintf(stderr, "%s\n", rt::to_string(p, o.body).c_str());
  if (!body.problems.empty()) return false;
  o.setup.body = std::move(body.body);
  auto motions = app::load_motions(o.motions, o.setup.body);
  for (const rt::Problem& p : motions.problems) std::fprintf(stderr, "%s\n", rt::to_string(p, o.motions).c_str());
  if (!motions.problems.empty()) return false;
  o.setup.book = std::move(motions.book);
  o.setup.errors.no_load_radps = o.no_load_radps;
  o.texts = app::body_text(o.body).value_or("") + app::motions_text(o.setup.book, o.setup.body, "");
  return true;
}

std::vector<std::string> course_names() {
  std::vector<std::string> names;
  for (const Course course : kCourses) names.push_back(to_string(course));
  return names;
}

/// A table of all cases, or of those so far when it was interrupted.
int study(Options& o) {
  if (!load(o)) return kNotBegun;
  if (!o.courses.empty()) {
    const std::vector<std::string> names = course_names();
    o.study.courses.clear();
    for (const std::string& name : o.courses)
      o.study.courses.push_back(kCourses[static_cast<std::size_t>(std::ranges::find(names, name) - names.begin())]);
  }
  sweep::StudyRun run{.program = "sinew-gait", .what = to_string(o.study.kind), .results = o.results};
  if (run.results.empty()) run.results = "runs/gait_" + run.what + ".jsonl";
  run.identity = {cases_of(o.study), gait::identity(o.study)};
  run.identity.what["files"] = o.texts;
  if (!math::is_nan(o.no_load_radps)) run.identity.what["no_load_radps"] = o.no_load_radps;
  run.jobs = o.jobs;
  run.patience_s = kPatience_s;
  run.run = [&o](std::uint64_t number, std::string& problem) { return run_case(o.study, o.setup, number, problem); };
  const sweep::StudyEnd end = run_study(run);
  if (end == sweep::StudyEnd::failed) return kNotBegun;
  std::vector<app::Json> cases;
  std::string why;
  if (!sweep::read_cases(run.results, cases, why)) return fail(why);
  std::printf("%s", study_table(o.study, cases).c_str());
  return end == sweep::StudyEnd::whole ? kOk : kNot;
}

/// The costs of one generation, each sample in a process of its own. False: it was stopped, or `why`.
bool evaluate(const Options& o, const std::vector<GaitSetup>& setups, std::uint64_t generation,
              std::vector<double>& costs, std::string& why) {
  costs.assign(setups.size(), math::kInf);
  std::size_t next = 0;
  const auto give = [&]() -> std::optional<sweep::Job> {
    if (next == setups.size()) return std::nullopt;
    sweep::Job job;
    job.body = [&, which = next++] {
      std::string problem;
      const double cost = cost_of(setups[which], o.search, generation, problem);
      if (!problem.empty()) return fail(problem);
      std::printf("%.17g\n", cost);
      return std::fflush(stdout) == 0 ? kOk : kNot;
    };
    return job;
  };
  const auto take = [&](std::uint64_t job, const sweep::JobResult& said) {
    if (said.code == 0) costs[job] = app::Json::parse(said.output, nullptr, false).get<double>();
    if (said.code != 0 && !hal::stop_requested()) why = sweep::describe_end(said) + said.errors;
    return said.code == 0;
  };
  sweep::ProcessPool pool(o.jobs, hal::Duration{static_cast<std::int64_t>(kPatience_s * 1e9)});
  return pool.run(give, take);
}

int search(Options& o) {
  if (!load(o)) return kNotBegun;
  std::string why;
  if (!o.numbers.empty())
    o.search.numbers = parse_searched(o.setup, o.search, o.numbers, why);
  else if (!o.search.motion.empty())
    o.search.numbers = numbers_of_motion(o.setup, o.search.motion, o.poses, o.range_deg, why);
  else
    o.search.numbers = standard_numbers(o.search);
  if (!why.empty()) return fail(why);
  static_cast<void>(hal::stop_requested());
  CmaEs cma(start_of(o.setup, o.search), o.search.sigma, o.search.seed, o.search.samples);
  for (std::uint64_t g = 0; g < o.search.generations; ++g) {
    std::vector<double> costs;
    if (!evaluate(o, setups_of(o.setup, o.search, cma.ask()), o.search.first_generation + g, costs, why))
      return why.empty() ? kNot : fail(why);
    cma.tell(costs);
    double least = math::kInf, total = 0;
    for (const double cost : costs) least = std::min(least, cost), total += cost;
    std::printf("generation %llu: least %.3f, mean %.3f, step %.3f\n", static_cast<unsigned long long>(g), least,
                total / static_cast<double>(costs.size()), cma.sigma());
    std::fflush(stdout);
    const std::vector<double> mean(cma.mean().begin(), cma.mean().end());
    const GaitSetup found = setups_of(o.setup, o.search, {mean}).front();
    std::ofstream out(o.out, std::ios::binary);
    out << app::motions_text(found.book, found.body,
                             fmt::format("# Found by sinew-gait search: seed {}, generation {} of {}, from {}.\n",
                                         o.search.seed, g + 1, o.search.generations, o.motions));
    if (!out.flush()) return fail(o.out + ": cannot be written");
  }
  return kOk;
}

void add_files(CLI::App& command, Options& o) {
  command.add_option("--body", o.body, "the body's file")->capture_default_str();
  command.add_option("--motions", o.motions, "its motion file; without it: BODY_motion.toml beside it");
  command.add_option("--no-load", o.no_load_radps, "no-load speed of all servos, rad/s, instead of the body's")
      ->check(app::number(0.5, 50));
  command.add_option("--jobs", o.jobs, "processes at once; 0: one a processor")
      ->check(app::whole(0, 4096))
      ->capture_default_str();
}

}  // namespace

int main(int argc, char** argv) {
  Options o;
  CLI::App options(
      "Walks, pushes, falls, rising and kicks of a humanoid on the simulated pitch, with the errors of real servos "
      "and\n"
      "sensors, in virtual time; and the search for their numbers.",
      "sinew-gait");
  options.require_subcommand(1);
  std::map<CLI::App*, Kind> kinds;
  for (const Kind kind : kKinds) {
    CLI::App& command =
        *options.add_subcommand(to_string(kind), "a table on unseen seeds; goes on where it was interrupted");
    kinds[&command] = kind;
    add_files(command, o);
    command.add_option("--runs", o.study.runs, "walk: in all; others: of each row or cell of the table")
        ->check(app::whole(1, 1'000'000))
        ->capture_default_str();
    command.add_option("--results", o.results, "file of results; without it: runs/gait_KIND.jsonl");
    if (kind == Kind::walk) {
      command.add_option("--seconds", o.study.lasts_s, "of each walk")
          ->check(app::number(1, 3600))
          ->capture_default_str();
      command.add_flag("--looks", o.study.looks, "the head looks to both sides of the way, in place of resting");
      command.add_option("--courses", o.courses, "these only, in turn")
          ->delimiter(',')
          ->check(app::one_of(course_names()));
    }
    if (kind == Kind::walk || kind == Kind::push || kind == Kind::stop || kind == Kind::rise)
      command.add_option("--first-seed", o.study.first_seed, "of the runs; from 500001 on no search has seen them")
          ->check(app::whole(1, 1'000'000'000))
          ->capture_default_str();
    if (kind == Kind::stop)
      command.add_option("--ball-speed", o.study.ball_mps, "of the ball when it comes to the feet, m/s")
          ->check(app::number(0.1, 3))
          ->capture_default_str();
    if (kind == Kind::push)
      command.add_option("--speeds", o.study.push_mps, "changes of speed, m/s")
          ->delimiter(',')
          ->check(app::number(0, 5));
  }
  CLI::App& find = *options.add_subcommand(
      "search", "for the numbers of a walk or a kick, or the poses of a motion, by covariance adaptation over seeds");
  add_files(find, o);
  find.add_option("out", o.out, "the motion file that is written after each generation")->required();
  find.add_option("--numbers", o.numbers,
                  "NAME:LEAST:MOST,...; without it: the standard ones; with --motion POSE/JOINT or POSE/duration_s");
  find.add_option("--motion", o.search.motion,
                  "searches the poses of this motion: rise_front, rise_back, turn_from_left, get_down");
  const std::map<std::string, motion::KickWay> ways{{"forward", motion::KickWay::forward},
                                                    {"outward", motion::KickWay::outward}};
  find.add_option("--kick", o.search.kick, "searches the numbers of this kick: forward, outward")
      ->transform(CLI::CheckedTransformer(ways));
  find.add_flag("--within-step", o.search.within_step, "with --kick: of the kick within a step of the walk");
  find.add_option("--poses", o.poses, "with --motion: these only")->delimiter(',');
  find.add_option("--range", o.range_deg, "with --motion: how far to both sides of each angle, degrees")
      ->check(app::number(1, 180))
      ->capture_default_str();
  find.add_option("--seed", o.search.seed, "of the search")->check(app::whole(1, 1'000'000))->capture_default_str();
  find.add_option("--generations", o.search.generations, "how many")
      ->check(app::whole(1, 10'000))
      ->capture_default_str();
  find.add_option("--first", o.search.first_generation, "number of the first: its seeds follow from it")
      ->check(app::whole(0, 4'000))
      ->capture_default_str();
  find.add_option("--samples", o.search.samples, "of a generation")->check(app::whole(4, 1'000))->capture_default_str();
  find.add_option("--runs", o.search.runs, "of a sample; of a walk the courses in turn")
      ->check(app::whole(1, 99))
      ->capture_default_str();
  find.add_option("--seconds", o.search.lasts_s, "of a run")->check(app::number(1, 600))->capture_default_str();
  find.add_option("--push", o.search.push_mps, "change of speed by a push each 3 s, m/s")
      ->check(app::number(0, 2))
      ->capture_default_str();
  find.add_option("--pushes", o.search.pushes, "of a sample, beside its walks: from front, right, left, back in turn")
      ->check(app::whole(0, 99))
      ->capture_default_str();
  find.add_option("--push-along", o.search.push_along_mps, "change of speed by those from front and back, m/s")
      ->check(app::number(0, 2))
      ->capture_default_str();
  find.add_option("--push-side", o.search.push_side_mps, "and by those from the sides, m/s")
      ->check(app::number(0, 2))
      ->capture_default_str();
  find.add_option("--sigma", o.search.sigma, "spread of the first samples, as a part of each range")
      ->check(app::number(0.001, 1))
      ->capture_default_str();
  try {
    options.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    if (e.get_exit_code() != 0) return fail(app::usage_error(options, e));
    return options.exit(e);  // prints the help
  }
  if (find.parsed()) return search(o);
  for (const auto& [command, kind] : kinds)
    if (command->parsed()) {
      o.study.kind = kind;
      return study(o);
    }
  return kNotBegun;
}
