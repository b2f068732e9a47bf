#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <memory>
#include <optional>

#include "apps/bag/bag_file.hpp"
#include "apps/command/json.hpp"
#include "apps/command/number_check.hpp"
#include "apps/replay/commands.hpp"
#include "apps/replay/comparison_report.hpp"
#include "apps/replay/drawn_again.hpp"
#include "apps/replay/recorded_robot.hpp"
#include "apps/run/run_setup.hpp"
#include "apps/view/plot.hpp"
#include "hal/linux/process.hpp"
#include "hal/platform.hpp"
#include "hal/silent_board.hpp"
#include "record/run/comparison.hpp"
#include "record/run/replay.hpp"

namespace sinew::app {
namespace {

constexpr std::size_t kRows = 20, kPlots = 4;

struct ReplayCommand {
  std::vector<std::string> files;
  std::string file;  // the one of `files` that is executed now
  std::vector<std::string> modules, set, fields;
  std::optional<double> from_s, until_s;
  bool chain = false, compare = false, json = false;
  std::string plot, truth, pictures;
};

std::string difference_text(const record::ReplayDifference& d) {
  char at[64];
  std::snprintf(at, sizeof at, "step %u at %.6f s", d.step, msg::seconds(d.now));
  return d.module + ", " + at + ": " + d.what + ": recorded " + d.recorded + ", now " + d.again;
}

Json to_json(const record::ReplayDifference& d) {
  return {{"module", d.module}, {"step", d.step},         {"time_s", msg::seconds(d.now)},
          {"what", d.what},     {"recorded", d.recorded}, {"now", d.again}};
}

Json to_json(const record::ReplayedModule& m) {
  Json json{{"steps", m.steps}, {"messages", m.messages}, {"not_compared", m.not_compared}};
  if (m.from) json["from_s"] = msg::seconds(*m.from);
  for (const auto& [key, count] : {std::pair("differing", m.differing), std::pair("missing", m.missing),
                                   std::pair("extra", m.extra), std::pair("settings_ignored", m.settings_ignored)})
    if (count > 0) json[key] = count;
  if (!m.stopped.empty()) json["stopped"] = m.stopped;
  if (m.difference) json["difference"] = to_json(*m.difference);
  return json;
}

/// Prints for each module what the first difference does not show.
void say_modules(const record::ReplayReport& report) {
  const auto count = [](std::uint64_t n) { return static_cast<unsigned long long>(n); };
  for (const auto& m : report.modules) {
    const char* const name = m.name.c_str();
    if (!m.stopped.empty()) std::printf("%s: %llu steps, then %s\n", name, count(m.steps), m.stopped.c_str());
    if (m.missing > 0) std::printf("%s: %llu recorded messages are not published now\n", name, count(m.missing));
    if (m.extra > 0)
      std::printf("%s: %llu messages are published now that the record does not have: no module latches them\n", name,
                  count(m.extra));
    if (m.settings_ignored > 0)
      std::printf("%s: --set holds; %llu settings in the record were not taken\n", name, count(m.settings_ignored));
  }
}

class ReplayRun {
 public:
  ReplayRun(const ReplayCommand& command, const rt::ModuleTypes& types) : command_(command), types_(types) {}

  int run() {
    auto progress = std::make_unique<Progress>("replay");
    const auto reader = open_recording(command_.file, *progress);
    if (!reader) return kNotBegun;
    std::string why = window_problem(*reader, command_.from_s, command_.until_s);
    if (!why.empty()) return fail(command_.file + ": " + why);
    if (!prepare(*reader, why)) return fail(why);
    const hal::Time begin = hal::system_os().now();
    const auto report = record::replay(*reader, *graph_, options_, why);
    if (!report) return fail(command_.file + ": " + why);
    progress.reset();
    report_ = *report;
    wall_s_ = msg::seconds(hal::system_os().now() - begin);
    for (const auto& m : report_.modules) steps_ += m.steps, messages_ += m.messages;
    return comparison_ ? tell_comparison() : tell();
  }

 private:
  bool prepare(record::Reader& reader, std::string& why) {
    auto spec = recorded_spec(reader, command_.file, why);
    if (!spec) {
      why = command_.file + ": " + why;
      return false;
    }
    for (const auto& setting : command_.set) {
      if (why = apply_setting(*spec, setting); !why.empty()) return false;
      options_.keep.push_back(setting.substr(0, setting.find('=')));
    }
    graph_ = configured_graph(*spec, types_, board_, command_.file, why);
    if (!graph_) return false;
    if (!command_.pictures.empty()) {
      const auto run = record::read_metadata(reader, "sinew.run");
      const auto robot = run.find("robot");
      pictures_ =
          DrawnAgain::start(command_.pictures, robot == run.end() ? std::string() : robot->second, *graph_, why);
      if (!pictures_) return false;
      options_.pictures = pictures_.get();
    }
    options_.modules = command_.modules;
    options_.from_s = command_.from_s;
    options_.until_s = command_.until_s;
    options_.chain = command_.chain;
    return !command_.compare || prepare_comparison(reader, why);
  }

  bool prepare_comparison(record::Reader& reader, std::string& why) {
    const std::string topic = command_.truth.empty() ? record::Truth::topic_of(reader) : command_.truth;
    if (!topic.empty()) truth_ = record::Truth::read(reader, *graph_, topic, why);
    if (!truth_ && !command_.truth.empty()) {
      why = command_.file + ": " + why;
      return false;
    }
    record::ComparisonOptions options;
    options.quantities = command_.fields;
    options.modules = command_.modules;
    options.from_s = command_.from_s;
    options.until_s = command_.until_s;
    options.truth = truth_ ? &*truth_ : nullptr;
    options.record = record::recorded_time(reader);
    options.curves = !command_.plot.empty();
    if (!known_fields(why)) return false;
    options_.watcher = &comparison_.emplace(*graph_, options);
    return true;
  }

  bool known_fields(std::string& why) const {
    const auto names = record::quantity_names(*graph_, command_.modules);
    for (const std::string& field : command_.fields)
      if (std::none_of(names.begin(), names.end(), [&](const auto& n) { return record::means(field, n); })) {
        why = "--fields " + field + ": no output of the modules has it; `sinew graph` shows them, " + "e.g. " +
              (names.empty() ? "none" : names.front());
        return false;
      }
    return true;
  }

  int exit_code(bool bad) const {
    const bool asked_and_missed = !command_.modules.empty() && !report_.complete();
    if (!report_.pictures.first_wrong.empty()) return kFailed;
    return bad || steps_ == 0 || asked_and_missed || !report_.problems.empty() ? kFailed : kDone;
  }

  Json summary() const {
    Json modules = Json::object();
    for (const auto& m : report_.modules) modules[m.name] = to_json(m);
    Json all{{"identical", report_.first_difference() == nullptr && steps_ > 0},
             {"steps", steps_},
             {"messages", messages_},
             {"midway", report_.midway},
             {"start_s", msg::seconds(report_.start)},
             {"robot_s", msg::seconds(report_.length)},
             {"wall_s", wall_s_},
             {"modules", modules}};
    if (const auto* first = report_.first_difference()) all["first_difference"] = to_json(*first);
    if (pictures_) {
      const record::DrawnPictures& drawn = report_.pictures;
      all["pictures"] = {{"same", drawn.same}, {"differing", drawn.differing}, {"missing", drawn.missing}};
      if (!drawn.first_wrong.empty()) all["pictures"]["first_wrong"] = drawn.first_wrong;
    }
    for (const auto& p : report_.problems) all["problems"].push_back(record::to_string(p));
    return all;
  }

  /// Of a file that begins in the middle of its run.
  void say_beginning() const {
    if (!report_.midway || command_.from_s) return;
    std::optional<rt::Time> first, last;
    for (const auto& m : report_.modules) {
      if (!m.from || m.steps == 0) continue;
      first = std::min(first.value_or(*m.from), *m.from);
      last = std::max(last.value_or(*m.from), *m.from);
    }
    if (first)
      std::printf(
          "the file begins in the middle of its run: each module begins at its first saved state there, %.3f to "
          "%.3f s of the file\n",
          msg::seconds(*first - report_.start), msg::seconds(*last - report_.start));
    else
      std::printf(
          "the file begins in the middle of its run and has no saved state (there is one of each module every "
          "5 s): take a longer part\n");
  }

  static void print(const Json& json) { std::printf("%s", to_line(json).c_str()); }

  void print_totals(const char* verdict) const {
    if (const record::DrawnPictures& drawn = report_.pictures; pictures_) {
      std::printf("pictures drawn again: %llu with the recorded hash, %llu with another one, %llu not drawn\n",
                  static_cast<unsigned long long>(drawn.same), static_cast<unsigned long long>(drawn.differing),
                  static_cast<unsigned long long>(drawn.missing));
      if (!drawn.first_wrong.empty()) std::printf("first: %s\n", drawn.first_wrong.c_str());
    }
    const double length_s = msg::seconds(report_.length);
    std::printf("%s: %llu steps and %llu messages of %zu modules compared, %.3f s in %.3f s: %.1f times real time\n",
                verdict, static_cast<unsigned long long>(steps_), static_cast<unsigned long long>(messages_),
                report_.modules.size(), length_s, wall_s_, length_s / wall_s_);
  }

  int tell() const {
    const auto* first = report_.first_difference();
    const int code = exit_code(first != nullptr);
    if (command_.json) {
      print(summary());
      return code;
    }
    say_problems(command_.file, report_.problems);
    say_beginning();
    say_modules(report_);
    for (const auto& m : report_.modules)
      if (m.difference && &*m.difference != first) std::printf("%s\n", difference_text(*m.difference).c_str());
    if (first) std::printf("first difference: %s\n", difference_text(*first).c_str());
    const char* verdict = report_.complete() ? "identical" : "identical as far as it goes";
    if (steps_ == 0) verdict = "nothing could be executed";
    if (first) verdict = "NOT identical";
    print_totals(verdict);
    return code;
  }

  int tell_comparison() const {
    auto compared = comparison_->result();
    std::erase_if(compared, [](const auto& q) { return q.now.count == 0 && q.one_sided == 0; });
    sort_by_difference(compared);
    if (!command_.plot.empty() && !write_plot(compared)) return kFailed;
    const int code = exit_code(false);
    if (command_.json) {
      Json all = summary();
      all["compared"] = Json::array();
      for (const auto& q : compared) all["compared"].push_back(comparison_json(q, report_.start));
      print(all);
      return code;
    }
    say_problems(command_.file, report_.problems);
    say_beginning();
    say_modules(report_);
    std::printf("%s", comparison_table(compared, report_.start, command_.fields.empty() ? kRows : 10 * kRows).c_str());
    print_totals(report_.first_difference() ? "NOT identical" : "identical");
    if (!command_.plot.empty()) std::printf("plot: %s\n", command_.plot.c_str());
    return code;
  }

  bool write_plot(const std::vector<record::ComparedQuantity>& compared) const {
    const auto plots = comparison_plots(compared, command_.fields.empty() ? kPlots : 4 * kPlots);
    const std::string why = write_plots(command_.plot, plots);
    return why.empty() || fail("--plot " + why, kFailed) == kDone;
  }

  const ReplayCommand& command_;
  const rt::ModuleTypes& types_;
  hal::SilentBoard board_;
  std::unique_ptr<rt::Graph> graph_;
  std::unique_ptr<DrawnAgain> pictures_;  // null: steps have the pixels of the file
  std::optional<record::Truth> truth_;
  std::optional<record::Comparison> comparison_;
  record::ReplayOptions options_;
  record::ReplayReport report_;
  double wall_s_ = 0;
  std::uint64_t steps_ = 0, messages_ = 0;
};

int replay_each(const ReplayCommand& command, const rt::ModuleTypes& types) {
  const auto files = each_file_once(command.files);
  if (files.size() > 1 && !command.plot.empty())
    return fail(
        fmt::format("--plot draws one recording, and {} are named: name one, such as {}", files.size(), files.back()));
  int worst = kDone;
  for (const std::string& file : files) {
    ReplayCommand one = command;
    one.file = file;
    if (files.size() > 1 && !command.json) std::printf("%s\n", file.c_str()), std::fflush(stdout);
    worst = std::max(worst, ReplayRun(one, types).run());
    if (hal::stop_requested()) break;
  }
  return worst;
}

}  // namespace

void add_replay_command(CLI::App& app, CommandContext& context) {
  const auto options = std::make_shared<ReplayCommand>();
  CLI::App& command = *app.add_subcommand(
      "replay", "execute the recorded steps of a run again and compare what comes out, byte for byte");
  command.add_option("files", options->files, "the recordings")->required()->type_name(kFileHint);
  command.add_option("--modules", options->modules, "only these, e.g. filter,attitude")
      ->delimiter(',')
      ->type_name(kModuleHint)
      ->allow_extra_args(false);
  command.add_option("--from", options->from_s, "begin at the saved states before so many seconds of the record")
      ->check(number(0))
      ->type_name("S");
  command.add_option("--until", options->until_s, "end so many seconds into the record")
      ->check(number(0))
      ->type_name("S");
  command.add_option("--set", options->set, "module.param=value from the start on; may be repeated")
      ->allow_extra_args(false)
      ->type_name("M.P=V");
  command.add_flag("--chain", options->chain,
                   "modules latch what the others publish now, not what these did in the record");
  CLI::Option& compare = *command.add_flag("--compare", options->compare,
                                           "go on behind differences; RMS and maximum of each field that differs");
  command.add_option("--fields", options->fields, "with --compare: only these, e.g. filter.state,tilt")
      ->delimiter(',')
      ->type_name(kFieldHint)
      ->allow_extra_args(false)
      ->needs(&compare);
  command.add_option("--plot", options->plot, "with --compare: both versions over time, as SVG or PNG")
      ->needs(&compare)
      ->check(&why_no_plot_file)
      ->type_name(kFileHint);
  command.add_option("--truth", options->truth, "with --compare: the topic of ground truth [ground_truth]")
      ->needs(&compare)
      ->type_name("TOPIC");
  command
      .add_option("--pictures", options->pictures,
                  "draw pixels that the recording does not have again, from this file of scenes (sinew-sim --scenes), "
                  "and compare them with the recorded hashes")
      ->type_name(kFileHint);
  command.add_flag("--json", options->json, "as one JSON object; of several recordings one a line");
  command.callback([&context, options] {
    context.action = [&types = context.types, options] { return replay_each(*options, types); };
  });
}

}  // namespace sinew::app
