// sinew-fuzz: flies a robot in virtual time again and again, each time disturbed in another way, and looks for a flight
// that breaks an invariant. docs/search.md.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <ctime>
#include <fstream>

#include "apps/command/number_check.hpp"
#include "apps/command/progress.hpp"
#include "apps/command/usage_error.hpp"
#include "apps/search/case_result.hpp"
#include "apps/search/generate.hpp"
#include "apps/search/outcome_text.hpp"
#include "apps/search/shrink.hpp"
#include "apps/search/summary.hpp"
#include "apps/sweep/process_pool.hpp"
#include "hal/linux/process.hpp"
#include "hal/platform.hpp"

namespace {

using namespace sinew;
using namespace sinew::search;

struct Options {
  std::string robot = "robots/quad/quad.toml", profile, case_text, camera, measure;
  std::uint64_t runs = 100, seed = 1, case_seed = 0;
  unsigned jobs = 0, twice_every = 16, shrink_runs = 150;
  double patience_s = 300;
  bool json = false, keep_going = false;
};

constexpr const char* kSmallCamera = "160x120";  // it still lands, and draws in a fifth of the time
constexpr std::uint64_t kMeasuredFlights = 5;

int fail(const std::string& what) {
  std::fprintf(stderr, "sinew-fuzz: %s\n", what.c_str());
  return 2;
}

bool show(const std::vector<rt::Problem>& problems, const std::string& file) {
  for (const auto& p : problems) std::fprintf(stderr, "%s\n", rt::to_string(p, file).c_str());
  return !problems.empty();
}

/// The robot and, unless it is being measured, its profile.
std::optional<FlightSettings> load(const Options& o, bool with_profile) {
  app::LoadedRobot loaded = app::load_robot(o.robot);
  for (const auto& p : loaded.problems) std::fprintf(stderr, "%s\n", app::to_string(p, loaded.robot).c_str());
  if (!loaded.problems.empty()) return std::nullopt;
  FlightSettings settings;
  settings.robot = std::move(loaded.robot);
  std::string camera = o.camera;
  if (camera.empty() && with_profile) camera = kSmallCamera;
  unsigned w = settings.robot.sim.camera_width, h = settings.robot.sim.camera_height;
  if (!camera.empty() && (std::sscanf(camera.c_str(), "%ux%u", &w, &h) != 2 || w < 16 || h < 16 ||
                          w > msg::kMaxImageWidth || h > msg::kMaxImageHeight)) {
    fail("--camera " + o.camera + ": WIDTHxHEIGHT, at most 1280x960");
    return std::nullopt;
  }
  settings.robot.sim.camera_width = w, settings.robot.sim.camera_height = h;
  if (!with_profile) return settings;
  const std::string path = o.profile.empty() ? profile_path(o.robot) : o.profile;
  std::vector<rt::Problem> problems;
  settings.profile = load_profile(path, problems);
  for (const std::string& name : settings.profile.apply(settings.robot.graph, [](const std::string&) { return 1.0; }))
    problems.push_back({0, "module." + name, "", "a module of " + o.robot});
  if (show(problems, path)) return std::nullopt;
  settings.robot.graph = app::load_robot(o.robot).robot.graph;  // as written: apply() above only found unknown names
  return settings;
}

std::vector<std::string> module_names(const FlightSettings& settings) {
  std::vector<std::string> names;
  for (const auto& [name, model] : settings.profile.module) names.push_back(name);
  return names;
}

void print(const Violation& v) {
  std::printf("failed: %s at %.6f s: %s\n", v.invariant.c_str(), msg::seconds(v.at - msg::Time{}), v.what.c_str());
}

std::string again(const Options& o, const Case& c) {
  return fmt::format("sinew-fuzz {}{}{} --case '{}'", o.robot, o.profile.empty() ? "" : " --profile " + o.profile,
                     o.camera.empty() ? "" : " --camera " + o.camera, to_string(c));
}

// ---- one case

int run_case(const Options& o) {
  const auto settings = load(o, true);
  if (!settings) return 2;
  std::string why;
  std::optional<Case> c;
  if (o.case_text.empty())
    c = generate(o.case_seed, module_names(*settings));
  else
    c = parse_case(o.case_text, why);
  if (!c) return fail(why);
  const auto outcome = fly(*settings, *c, why);
  if (!outcome) return fail(why);
  if (o.json) {
    std::printf("%s\n", to_json(*c, *outcome).c_str());
    return outcome->violation ? 1 : 0;
  }
  std::printf("case    %s\n", to_string(*c).c_str());
  std::printf("ended   after %.3f s: %s, hash %016llx\n", outcome->ended_s, to_string(outcome->ending),
              static_cast<unsigned long long>(outcome->hash));
  if (outcome->violation) {
    print(*outcome->violation);
    return 1;
  }
  Summary summary;
  summary.add(*c, excuses(*c, settings->robot.graph.failsafes), *outcome);
  std::printf("%s", summary.text().c_str());
  return 0;
}

// ---- the profile

int measure(const Options& o) {
  auto settings = load(o, false);
  if (!settings) return 2;
  ExecSamples samples;
  settings->measured = &samples;
  std::string why;
  for (std::uint64_t world = 1; world <= kMeasuredFlights; ++world) {
    Case c;
    c.world = world;
    c.gust_mps = 1;
    const auto outcome = fly(*settings, c, why);
    if (!outcome) return fail(why);
    if (outcome->violation) {
      print(*outcome->violation);
      return fail("a flight that fails measures nothing");
    }
  }
  char date[32] = "";
  const std::time_t now = std::time(nullptr);
  std::strftime(date, sizeof date, "%Y-%m-%d", std::gmtime(&now));
  ExecProfile profile;
  profile.measured = fmt::format(
      "{}, {} flights with pictures of {}x{}, processor time of each step on {} cores of: {}", date, kMeasuredFlights,
      settings->robot.sim.camera_width, settings->robot.sim.camera_height, hal::usable_cpus(), o.measure);
  for (auto& [name, list] : samples) profile.module[name] = model_of(list);
  std::ofstream out(o.profile.empty() ? profile_path(o.robot) : o.profile);
  out << to_text(profile);
  return out.flush() ? 0 : fail("the profile cannot be written");
}

// ---- the search

class Search {
 public:
  Search(const Options& o, const FlightSettings& settings)
      : options_(o),
        modules_(module_names(settings)),
        failsafes_(settings.robot.graph.failsafes),
        patience_{static_cast<std::int64_t>(o.patience_s * 1e9)},
        pool_(o.jobs, patience_) {}

  int run() {
    hal::Os& os = hal::system_os();
    const hal::Time begin = os.now();
    plan();
    progress_.expect(cases_.size());
    const bool through = fly_all(cases_, [&](std::size_t i, const CaseResult& r) { return take(i, r); });
    progress_.erase();
    const double wall_s = msg::seconds(os.now() - begin);
    if (error_) return 2;
    if (options_.json) {
      std::printf("%s\n", summary_.json().c_str());
    } else {
      std::printf("%s", summary_.text().c_str());
      std::printf("wall time           %.1f s, %.2f s a run\n", wall_s, wall_s / static_cast<double>(pool_.started()));
    }
    if (found_) std::printf("%zu of the flights failed\n", found_);
    if (found_) return 1;
    if (!failed_) {
      if (through && !options_.json) std::printf("nothing found\n");
      return through ? 0 : 2;
    }
    report();
    return 1;
  }

 private:
  static std::vector<std::string> command(const Options& o) {
    std::vector<std::string> argv{hal::program_path(), o.robot};
    if (!o.camera.empty()) argv.insert(argv.end(), {"--camera", o.camera});
    if (!o.profile.empty()) argv.insert(argv.end(), {"--profile", o.profile});
    return argv;
  }

  /// Flies the cases, each in a process of its own, and passes their results to `done` in the order of the cases.
  /// False: it did not go through to the end.
  bool fly_all(const std::vector<Case>& cases, const std::function<bool(std::size_t, const CaseResult&)>& done) {
    std::size_t next = 0;
    return pool_.run(
        [&]() -> std::optional<sweep::Job> {
          if (next == cases.size()) return std::nullopt;
          sweep::Job job{.argv = command(options_)};
          job.argv.insert(job.argv.end(), {"--case", to_string(cases[next++]), "--json"});
          return job;
        },
        [&](std::uint64_t i, const sweep::JobResult& result) {
          return done(static_cast<std::size_t>(i), case_result(result, patience_));
        },
        sweep::ProcessPool::Order::as_they_began);
  }

  /// Some cases come twice: both flights must give the same bytes.
  void plan() {
    for (std::uint64_t run = 0; run < options_.runs; ++run) {
      cases_.push_back(generate(case_seed(options_.seed, run), modules_));
      run_of_.push_back(run);
      if (options_.twice_every == 0 || run % options_.twice_every != 0) continue;
      cases_.push_back(cases_.back());
      run_of_.push_back(run);
    }
  }

  bool take(std::size_t i, const CaseResult& r) {
    progress_.add(1);
    if (!r.error.empty()) {
      progress_.erase();
      fail(fmt::format("run {}: {}\n  {}", run_of_[i] + 1, r.error, again(options_, cases_[i])));
      error_ = true;
      return false;
    }
    const bool second = i > 0 && run_of_[i] == run_of_[i - 1];
    Outcome outcome = r.outcome;
    if (second && !outcome.violation && outcome.hash != hash_)
      outcome.violation =
          Violation{"same bytes", {}, fmt::format("two runs gave {:016x} and {:016x}", hash_, outcome.hash)};
    hash_ = outcome.hash;
    if (!second) summary_.add(cases_[i], excuses(cases_[i], failsafes_), outcome);
    if (!options_.json && !second && (run_of_[i] + 1) % 100 == 0) {
      progress_.erase();
      std::printf("%llu runs\n", static_cast<unsigned long long>(run_of_[i] + 1));
      std::fflush(stdout);
    }
    if (!outcome.violation) return true;
    if (options_.keep_going) {
      progress_.erase();
      std::printf("run %llu ", static_cast<unsigned long long>(run_of_[i] + 1));
      print(*outcome.violation);
      std::printf("  %s\n", again(options_, cases_[i]).c_str());
      std::fflush(stdout);
      ++found_;
      return true;
    }
    failed_ = i;
    violation_ = *outcome.violation;
    return false;
  }

  void report() {
    const Case& c = cases_[*failed_];
    const std::uint64_t run = run_of_[*failed_];
    const Case minimal = violation_.invariant == "same bytes" ? c : shrunk(c);
    const auto seed = case_seed(options_.seed, run);
    if (options_.json) {
      Outcome o;
      o.violation = violation_;
      std::printf("%s\n", to_json(minimal, o).c_str());
      return;
    }
    std::printf("\nrun %llu, case seed %llu\n", static_cast<unsigned long long>(run + 1),
                static_cast<unsigned long long>(seed));
    print(violation_);
    std::printf("again:   %s\n", again(options_, c).c_str());
    std::printf("minimal: %s\n", again(options_, minimal).c_str());
  }

  Case shrunk(const Case& c) {
    std::size_t left = options_.shrink_runs;
    return shrink(c, [&](const std::vector<Case>& candidates) {
      std::optional<std::size_t> found;
      fly_all(candidates, [&](std::size_t i, const CaseResult& r) {
        if (left == 0) return false;
        --left;
        const auto& v = r.outcome.violation;
        if (r.error.empty() && v && v->invariant == violation_.invariant) found = i;
        return !found.has_value();
      });
      return found;
    });
  }

  const Options& options_;
  const std::vector<std::string> modules_;
  const std::vector<rt::FailsafeSpec> failsafes_;
  const hal::Duration patience_;
  sweep::ProcessPool pool_;
  app::Progress progress_{"search", true, app::ProgressOf::cases};
  std::vector<Case> cases_;
  std::vector<std::uint64_t> run_of_;  // of each case
  Summary summary_;
  std::uint64_t hash_ = 0;
  std::optional<std::size_t> failed_;
  Violation violation_;
  bool error_ = false;
  std::size_t found_ = 0;
};

}  // namespace

int main(int argc, char** argv) {
  Options o;
  CLI::App options(
      "Flies a robot in virtual time again and again, each time with other execution times, lost and late samples and\n"
      "device faults, checks what must always hold, and shrinks what fails. Exit code 0: nothing found, 1: something, "
      "2: "
      "it could not run.",
      "sinew-fuzz");
  options.add_option("robot", o.robot, "robot file")->capture_default_str();
  options.add_option("--runs", o.runs, "flights")->check(app::whole())->capture_default_str();
  options.add_option("--seed", o.seed, "of the search: the case seeds follow from it")
      ->check(app::whole())
      ->capture_default_str();
  options.add_option("--jobs", o.jobs, "flights at once; 0: one a processor")
      ->check(app::whole(0, 4096))
      ->capture_default_str();
  auto* text = options.add_option("--case", o.case_text, "fly this case only");
  auto* seed = options.add_option("--case-seed", o.case_seed, "fly the case of this seed only")
                   ->check(app::whole())
                   ->excludes(text);
  auto* measured = options.add_option("--measure", o.measure,
                                      "measure execution times, write the profile, and end; MACHINE says on what");
  options.add_option("--profile", o.profile, "execution times; default: beside the robot file, NAME_exec.toml");
  options.add_option("--camera", o.camera, "size of the pictures; default 160x120, to measure the robot file's");
  options.add_option("--twice-every", o.twice_every, "fly every so many cases twice and compare the bytes; 0: none")
      ->check(app::whole(0, UINT32_MAX))
      ->capture_default_str();
  options.add_option("--shrink-runs", o.shrink_runs, "flights to spend on shrinking")
      ->check(app::whole(0, UINT32_MAX))
      ->capture_default_str();
  options.add_option("--patience", o.patience_s, "seconds after which a flight counts as hanging")
      ->check(app::number(0))
      ->capture_default_str();
  options.add_flag("--keep-going", o.keep_going, "name every failure and go on, without shrinking");
  options.add_flag("--json", o.json, "one JSON object a line");
  try {
    options.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    if (e.get_exit_code() != 0) return fail(app::usage_error(options, e));
    return options.exit(e);  // prints the help
  }
  if (*measured) return measure(o);
  if (*text || *seed) return run_case(o);
  const auto settings = load(o, true);
  if (!settings) return 2;
  return Search(o, *settings).run();
}
