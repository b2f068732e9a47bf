// sinew-learn: policies that land a quadrotor, learned on the simulated plant without pictures. docs/learning.md.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "apps/command/choice_check.hpp"
#include "apps/command/number_check.hpp"
#include "apps/command/progress.hpp"
#include "apps/command/usage_error.hpp"
#include "apps/learn/study.hpp"
#include "apps/sweep/study_run.hpp"

namespace {

using namespace sinew;
using namespace sinew::learning;

constexpr int kOk = 0, kNot = 1, kNotBegun = 2;

struct Options {
  StudyOptions study;
  std::vector<std::string> variants;
  std::string results = "runs/learning.jsonl", plots, kind = "svg", policy, variant = "continuous";
  std::uint64_t seed = 1, trials = 90, starts = 0;
  unsigned jobs = 0;
  double patience_s = 7200, goal = 0;
};

int fail(const std::string& what) {
  std::fprintf(stderr, "sinew-learn: %s\n", what.c_str());
  return kNotBegun;
}

std::vector<std::string> variant_names() {
  std::vector<std::string> names;
  for (const Variant v : kVariants) names.push_back(to_string(v));
  return names;
}

std::vector<Variant> variants_of(const std::vector<std::string>& names) {
  std::vector<Variant> all;
  for (const std::string& name : names)
    for (const Variant v : kVariants)
      if (to_string(v) == name && std::find(all.begin(), all.end(), v) == all.end()) all.push_back(v);
  return all;
}

int report(const Options& o) {
  std::vector<app::Json> cases;
  std::string why;
  if (!sweep::read_cases(o.results, cases, why)) return fail(why);
  std::printf("%s", study_table(cases).c_str());
  if (!o.plots.empty()) {
    std::error_code error;
    std::filesystem::create_directories(o.plots, error);
    why = study_plots(cases, o.plots, o.kind);
    if (!why.empty()) return fail(why);
  }
  const Best best = best_of(cases);
  std::printf("best: %s, %.0f %% landed in the median of its learning seeds\n", best.variant.c_str(), best.landed);
  return best.landed >= o.goal ? kOk : kNot;
}

int study(Options& o) {
  if (!o.variants.empty()) o.study.variants = variants_of(o.variants);
  sweep::StudyRun run{.program = "sinew-learn", .what = "learn", .results = o.results};
  run.identity = {cases_of(o.study), learning::identity(o.study)};
  run.jobs = o.jobs;
  run.patience_s = o.patience_s;
  run.run = [&o](std::uint64_t number, std::string& problem) {
    return run_case(o.study, case_of(o.study, number), problem);
  };
  run.name = [&o](std::uint64_t number) {
    const StudyCase which = case_of(o.study, number);
    return fmt::format("{} with learning seed {}", to_string(which.variant), which.seed);
  };
  switch (run_study(run)) {
    case sweep::StudyEnd::whole:
      return report(o);
    case sweep::StudyEnd::interrupted:
      return kNot;
    case sweep::StudyEnd::failed:
      break;
  }
  return kNotBegun;
}

/// One policy.
int learn_one(const Options& o) {
  LandingSchool school(variants_of({o.variant}).front(), o.seed);
  {
    app::Progress progress("learn");
    progress.expect(o.trials);
    while (school.trials() < o.trials) {
      const auto flown = school.trial();
      if (!flown) return fail(flown.error().where);
      progress.add(1);
    }
  }
  const std::string text =
      policy_file(school.policy(),
                  fmt::format("A landing policy of sinew-learn: {}, learning seed {}, {} trials (docs/learning.md).",
                              o.variant, o.seed, o.trials));
  std::ofstream out(o.policy, std::ios::binary);
  out << text;
  if (!out.flush()) return fail(o.policy + ": cannot be written");
  std::printf("%s\n", o.policy.c_str());
  if (o.starts == 0) return kOk;
  const auto seen = evaluate(school.policy(), o.starts, false);
  if (!seen) return fail(seen.error().where);
  std::printf("%llu of %llu unseen starts landed within 0.15 m at under 0.5 m/s\n",
              static_cast<unsigned long long>(seen->good), static_cast<unsigned long long>(seen->starts));
  return seen->good == seen->starts ? kOk : kNot;
}

}  // namespace

int main(int argc, char** argv) {
  Options o;
  CLI::App options(
      "Learns to land a quadrotor by least-squares policy iteration, on the simulated plant without pictures, in\n"
      "virtual time. `sinew run robots/quad/quad_learned.toml --params POLICY.toml` flies what was learned.",
      "sinew-learn");
  options.require_subcommand(1);
  CLI::App& one = *options.add_subcommand("policy", "learn one policy and write its file of parameters");
  one.add_option("file", o.policy, "the file that is written")->required();
  one.add_option("--variant", o.variant, "how it is learned")
      ->check(app::one_of(variant_names()))
      ->capture_default_str();
  one.add_option("--seed", o.seed, "learning seed")->check(app::whole(1, 1'000'000))->capture_default_str();
  one.add_option("--trials", o.trials, "flights to learn from")->check(app::whole(1, 99'999))->capture_default_str();
  one.add_option("--starts", o.starts, "unseen starts that it flies afterwards")
      ->check(app::whole(0, 400'000))
      ->capture_default_str();
  CLI::App& all = *options.add_subcommand(
      "study", "learn with each variant and many learning seeds, on all cores; goes on where it was interrupted");
  all.add_option("--variants", o.variants, "of batch, online, continuous; without it: all")
      ->check(app::one_of(variant_names()))
      ->delimiter(',');
  all.add_option("--seeds", o.study.seeds, "learning seeds of each variant")
      ->check(app::whole(1, 1'000'000))
      ->capture_default_str();
  all.add_option("--trials", o.study.trials, "flights to learn from")
      ->check(app::whole(1, 99'999))
      ->capture_default_str();
  all.add_option("--every", o.study.every, "trials from evaluation to evaluation")
      ->check(app::whole(1, 99'999))
      ->capture_default_str();
  all.add_option("--curve-starts", o.study.curve_starts, "unseen starts of each evaluation")
      ->check(app::whole(1, 400'000))
      ->capture_default_str();
  all.add_option("--goal-trials", o.study.goal_trials, "after so many trials the policy is kept")
      ->check(app::whole(1, 99'999))
      ->capture_default_str();
  all.add_option("--starts", o.study.starts, "unseen starts then")
      ->check(app::whole(1, 400'000))
      ->capture_default_str();
  all.add_option("--jobs", o.jobs, "cases at once; 0: one a processor")
      ->check(app::whole(0, 4096))
      ->capture_default_str();
  all.add_option("--patience", o.patience_s, "seconds after which a case counts as hanging")
      ->check(app::number(1))
      ->capture_default_str();
  CLI::App& told = *options.add_subcommand("report", "the table of a study, and its plots");
  for (CLI::App* command : {&all, &told}) {
    command->add_option("--results", o.results, "the study's file of results")->capture_default_str();
    command->add_option("--goal", o.goal, "exit code 1 if the best variant lands less, in % (median of its seeds)")
        ->check(app::number(0, 100))
        ->capture_default_str();
    command->add_option("--plots", o.plots, "folder for the plots; without it: none");
    command->add_option("--plot-kind", o.kind, "of the plots")
        ->check(app::one_of({"svg", "png"}))
        ->capture_default_str();
  }
  try {
    options.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    if (e.get_exit_code() != 0) return fail(app::usage_error(options, e));
    return options.exit(e);  // prints the help
  }
  if (one.parsed()) return learn_one(o);
  return all.parsed() ? study(o) : report(o);
}
