#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <memory>

#include "apps/command/choice_check.hpp"
#include "apps/command/number_check.hpp"
#include "apps/sweep_runs/commands.hpp"
#include "apps/sweep_runs/sweep_run.hpp"
#include "apps/view/plot.hpp"

namespace sinew::app {
namespace {

struct MergeOptions {
  std::vector<std::string> files;
  std::string out;
  ReportOptions report{};
};

void describe_report(CLI::App& command, ReportOptions& o) {
  command.add_option("--against", o.against, "compare with these earlier results, run by run or seed by seed")
      ->type_name(kFileHint);
  CLI::Option& plot =
      *command
           .add_option(
               "--plot", o.plot,
               "draw a measure: how often it has which values; MEASURE:seed and MEASURE:MODULE.PARAM draw it over "
               "the seed, over a --set")
           ->type_name("MEASURE");
  CLI::Option& file = *command.add_option("-o,--output", o.plot_file, "with --plot: where it goes, SVG or PNG")
                           ->check(&why_no_plot_file)
                           ->type_name(kFileHint);
  plot.needs(&file);
  file.needs(&plot);
  command.add_option("--csv", o.csv, "write each run here, a line each")->type_name(kFileHint);
  command.add_flag("--json", o.json, "as one JSON object");
}

void describe_sweep(CLI::App& command, SweepOptions& o) {
  command.add_option("robots", o.axes.robots, "robot files")->required()->type_name(kRobotFileHint);
  command.add_option("--seeds", o.axes.seeds, "1..1000, 3,5,7 or 1..10,20 (default: the robot file's seed)")
      ->type_name("SEEDS");
  CLI::Option& set =
      *command
           .add_option("--set", o.axes.set,
                       "KEY=A,B,C or KEY=FROM:TO:COUNT[:log], with the keys of `run --set`; each --set is "
                       "combined with all others")
           ->allow_extra_args(false)
           ->type_name(kSettingHint);
  CLI::Option& fault =
      *command
           .add_option(
               "--fault", o.axes.faults,
               "a fault as `run --fault` has it, \"none\", or several in one run: 'imu:off@5&range:stuck@6'; each "
               "--fault is an alternative")
           ->allow_extra_args(false)
           ->type_name("FAULT");
  CLI::Option& params =
      *command
           .add_option("--params", o.axes.params, "files of parameters, each an alternative; none: the robot file's")
           ->delimiter(',')
           ->allow_extra_args(false)
           ->type_name(kRobotFileHint);
  command
      .add_option("--list", o.axes.list,
                  "a file with the options of one run a line, in place of --set, --fault, --params")
      ->excludes(&set)
      ->excludes(&fault)
      ->excludes(&params)
      ->type_name(kFileHint);
  command.add_option("--camera", o.axes.camera, "size of the camera's frames")->type_name("WxH");
  command.add_option("--duration", o.axes.duration_s, "stop each run after so many seconds of its own")
      ->check(number(0))
      ->type_name("S");
  command.add_option("--plant-arg", o.axes.plant_args, "one more argument for sinew-sim; may be repeated")
      ->allow_extra_args(false)
      ->type_name("ARG");
  command.add_option("--jobs", o.jobs, "runs at a time (default: one for each processor)")
      ->check(whole(0, 4096))
      ->type_name("N");
  command.add_option("--patience", o.patience_s, "real time after which a run hangs, and is ended (default: 300)")
      ->check(number(0.1))
      ->take_last()  // a packed sweep has one already
      ->type_name("S");
  command
      .add_option("--results", o.results,
                  "file of results (default: one of this sweep's own, in sweeps/ beside the recordings)")
      ->type_name(kFileHint);
  CLI::Option& shard =
      *command.add_option("--shard", o.shard, "only part I of N, as 2/5; `sinew merge` puts the parts together")
           ->type_name("I/N");
  command
      .add_option("--until-width", o.until_width,
                  "stop when the 95 % interval of the share of good runs is as narrow: 0.02 is +-1 %")
      ->check(number(0.0001, 1.0))
      ->excludes(&shard)
      ->type_name("W");
  command.add_option("--record", "\"failures\": fly the runs that failed once more, and record them")
      ->check(one_of({"failures"}))
      ->type_name("{failures}")
      ->each([&o](const std::string&) { o.record_failures = true; });
  command.add_option("--in", o.in, "folder where the names of robot files, parameters and the list begin")
      ->type_name(kFileHint);
  command
      .add_option(
          "--pack", o.pack,
          "fly nothing: make this folder with all that other machines need, and a script `run` that flies there")
      ->excludes("--results")
      ->excludes("--shard")
      ->excludes("--until-width")
      ->excludes("--record")
      ->type_name(kFileHint);
  describe_report(command, o.report);
}

/// Goes to the folder of --in; files that are written or compared keep their places. Errors: false, with `why`.
bool enter_folder(SweepOptions& o, std::string& why) {
  std::error_code error;
  for (std::string* const file : {&o.results, &o.pack, &o.report.against, &o.report.plot_file, &o.report.csv})
    if (!file->empty() && !error) *file = std::filesystem::absolute(*file, error).string();
  if (!error) std::filesystem::current_path(o.in, error);
  if (error) why = fmt::format("--in {}: {}", o.in, error.message());
  return !error;
}

int run_sweep(SweepOptions options, const rt::ModuleTypes& types) {
  std::string why;
  if (!options.in.empty() && !enter_folder(options, why)) return fail(why);
  return SweepRun(options, types).run();
}

int merge(const MergeOptions& options) {
  sweep::Merged merged;
  std::string why;
  if (!sweep::merge_results(options.files, options.out, merged, why)) return fail(why);
  Reported told;
  if (!report_results(options.out, options.report, "", told, why)) return fail(why);
  std::fwrite(told.text.data(), 1, told.text.size(), stdout);
  if (merged.missing_count == 0) return kDone;
  std::fflush(stdout);
  return fail(fmt::format("{} of {} runs are missing, such as case {}; `sinew sweep --results {}` with the sweep's "
                          "other options makes them",
                          merged.missing_count, merged.identity.cases, fmt::join(merged.missing, ", "), options.out),
              kFailed);
}

}  // namespace

void add_sweep_commands(CLI::App& app, CommandContext& context) {
  const auto sweep_options = std::make_shared<SweepOptions>();
  CLI::App& sweep = *app.add_subcommand(
      "sweep", "run robot files over seeds, settings, faults and parameters on all processors, and sum up how it went");
  describe_sweep(sweep, *sweep_options);
  sweep.callback([&context, sweep_options] {
    context.action = [&types = context.types, sweep_options] { return run_sweep(*sweep_options, types); };
  });

  const auto merge_options = std::make_shared<MergeOptions>();
  CLI::App& merging =
      *app.add_subcommand("merge", "put the results of a sweep's parts into one file, and sum up how it went");
  merging.add_option("files", merge_options->files, "files of results of one sweep")->required()->type_name(kFileHint);
  merging.add_option("--into", merge_options->out, "the file with all of them")->required()->type_name(kFileHint);
  describe_report(merging, merge_options->report);
  merging.callback([&context, merge_options] { context.action = [merge_options] { return merge(*merge_options); }; });
}

}  // namespace sinew::app
