#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <memory>
#include <numeric>

#include "apps/bag/bag_file.hpp"
#include "apps/command/choice_check.hpp"
#include "apps/command/json.hpp"
#include "apps/command/number_check.hpp"
#include "apps/command/progress.hpp"
#include "apps/replay/commands.hpp"
#include "apps/replay/tuning.hpp"
#include "hal/platform.hpp"
#include "rt/parameters.hpp"

namespace sinew::app {
namespace {

// Not fmt::print(), which throws when the reader of a pipe is gone.
void put(const std::string& text) { std::fwrite(text.data(), 1, text.size(), stdout); }

constexpr std::size_t kTunedRows = 20;

struct TuneCommand {
  TuningTask task;
  std::string against = "truth";
  bool json = false;
};

Json to_json(const rt::ParamValue& value) {
  return std::visit([](const auto& v) { return Json(v); }, value);
}

Json to_json(const record::Deviation& d) { return {{"rms", d.rms()}, {"max", d.max}, {"messages", d.count}}; }

Json to_json(const Score& score, const std::vector<std::string>& files) {
  Json json = to_json(score.error);
  if (files.size() > 1)
    for (std::size_t f = 0; f < files.size(); ++f) {
      json["files"].push_back(to_json(score.files[f]));
      json["files"].back()["file"] = files[f];
    }
  if (score.missing > 0) json["missing"] = score.missing;
  if (!score.stopped.empty()) json["stopped"] = score.stopped;
  return json;
}

/// The points, the best first; points that do not count come last.
std::vector<std::size_t> ranked(const Tuning& tuning) {
  std::vector<std::size_t> order(tuning.points().size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    const Score &x = tuning.scores()[a], &y = tuning.scores()[b];
    return x.counts() != y.counts() ? x.counts() : x.error.rms() < y.error.rms();
  });
  return order;
}

class TuneRun {
 public:
  explicit TuneRun(const TuneCommand& command) : command_(command) {}

  int run(const rt::ModuleTypes& types) {
    std::string why;
    if (!tuning_.prepare(command_.task, types, why)) return fail(why);
    const std::size_t replays = tuning_.points().size() * command_.task.files.size();
    const hal::Time begin = hal::system_os().now();
    {
      Progress progress("tune", true, ProgressOf::cases);
      progress.expect(replays);
      if (!tuning_.run([&](std::size_t n) { progress.add(n); }, why)) return fail(why);
    }
    wall_s_ = msg::seconds(hal::system_os().now() - begin);
    best_ = tuning_.best();
    command_.json ? tell_json() : tell();
    return best_ ? kDone : kFailed;
  }

 private:
  Json values(std::size_t point) const {
    Json json = Json::object();
    for (std::size_t i = 0; i < tuning_.params().size(); ++i)
      json[tuning_.params()[i].name()] = to_json(tuning_.points()[point][i]);
    return json;
  }

  void tell_json() const {
    const auto& files = command_.task.files;
    Json all{{"error", tuning_.error_name()},
             {"unit", tuning_.unit()},
             {"against", command_.against},
             {"modules", tuning_.modules()},
             {"replays", tuning_.points().size() * files.size()},
             {"wall_s", wall_s_},
             {"points", Json::array()}};
    for (std::size_t p = 0; p < tuning_.points().size(); ++p) {
      Json point{{"params", values(p)}};
      point.update(to_json(tuning_.scores()[p], files));
      all["points"].push_back(std::move(point));
    }
    if (command_.task.against_truth) all["recorded"] = to_json(tuning_.recorded(), files);
    if (best_) {
      all["best"] = all["points"][*best_];
      all["robot_file"] = tuning_.robot_file_lines(*best_);
    }
    std::printf("%s\n", all.dump(2, ' ', false, Json::error_handler_t::replace).c_str());
  }

  void tell() const {
    const auto& task = command_.task;
    std::string window;
    if (task.from_s) window += fmt::format(" from {:g} s", *task.from_s);
    if (task.until_s) window += fmt::format(" until {:g} s", *task.until_s);
    put(fmt::format("{}{}, RMS against the {}{}; executed again: {}\n", tuning_.error_name(),
                    tuning_.unit().empty() ? "" : " (" + tuning_.unit() + ")",
                    command_.against == "truth" ? "truth" : "record", window, fmt::join(tuning_.modules(), ", ")));
    std::vector<std::size_t> widths;
    for (const auto& p : tuning_.params()) {
      widths.push_back(std::max<std::size_t>(p.name().size(), 8));
      put(fmt::format("{:>{}}  ", p.name(), widths.back()));
    }
    put(fmt::format("{:>11} {:>11} {:>9}\n", "error", "maximum", "messages"));
    const auto order = ranked(tuning_);
    for (std::size_t i = 0; i < std::min(kTunedRows, order.size()); ++i) tell_row(order[i], widths);
    if (order.size() > kTunedRows) put(fmt::format("and {} more: --json has all\n", order.size() - kTunedRows));
    if (task.against_truth) {
      const auto& recorded = tuning_.recorded().error;
      std::size_t width = 0;
      for (const std::size_t w : widths) width += w + 2;
      put(fmt::format("{:>{}}{:>11.4g} {:>11.4g} {:>9}\n", "as recorded  ", width, recorded.rms(), recorded.max,
                      recorded.count));
    }
    put(fmt::format("{} replays in {:.2f} s\n", order.size() * task.files.size(), wall_s_));
    if (best_)
      put(fmt::format("best, for the robot file:\n{}\n", tuning_.robot_file_lines(*best_)));
    else
      std::fflush(stdout), fail("no combination could be executed to its end with its messages published", kFailed);
  }

  void tell_row(std::size_t point, const std::vector<std::size_t>& widths) const {
    const Score& score = tuning_.scores()[point];
    for (std::size_t i = 0; i < widths.size(); ++i)
      put(fmt::format("{:>{}}  ", rt::to_string(tuning_.points()[point][i]), widths[i]));
    put(fmt::format("{:>11.4g} {:>11.4g} {:>9}", score.error.rms(), score.error.max, score.error.count));
    if (!score.stopped.empty())
      put(fmt::format("  {}", score.stopped.front()));
    else if (!score.counts())
      put(fmt::format("  does not count: {} messages are missing", score.missing));
    put(fmt::format("\n"));
  }

  const TuneCommand& command_;
  Tuning tuning_;
  double wall_s_ = 0;
  std::optional<std::size_t> best_;
};

}  // namespace

void add_tune_command(CLI::App& app, CommandContext& context) {
  const auto options = std::make_shared<TuneCommand>();
  TuningTask& task = options->task;
  CLI::App& command = *app.add_subcommand(
      "tune", "execute recordings again with many combinations of parameters, and find the one with the least error");
  command.add_option("files", task.files, "the recordings")->required()->type_name(kFileHint);
  command.add_option("--param", task.params, "MODULE.PARAM=FROM:TO:COUNT[:log] or MODULE.PARAM=A,B,C; may be repeated")
      ->required()
      ->allow_extra_args(false)
      ->type_name("M.P=VALUES");
  command
      .add_option("--error", task.error,
                  "the quantity whose RMS error shall be small, e.g. tilt or filter.state.v_world_mps.x")
      ->required()
      ->type_name("FIELD");
  command.add_option("--against", options->against, "what it is compared with [truth]")
      ->check(one_of({"truth", "recorded"}).description(""))
      ->type_name("{truth,recorded}");
  command.add_option("--truth", task.truth, "the topic of ground truth [ground_truth]")->type_name("TOPIC");
  command.add_option("--from", task.from_s, "errors count from so many seconds of the record on")
      ->check(number(0))
      ->type_name("S");
  command.add_option("--until", task.until_s, "and until then")->check(number(0))->type_name("S");
  command.add_option("--jobs", task.jobs, "replays at a time [as many as processors]")
      ->check(whole(1, 256))
      ->type_name("N");
  command.add_option("--patience", task.patience_s, "a replay that takes more seconds counts as hanging [600]")
      ->check(number(0))
      ->type_name("S");
  command.add_flag("--json", options->json, "as one JSON object");
  command.callback([&context, options] {
    options->task.against_truth = options->against == "truth";
    options->task.files = each_file_once(options->task.files);
    context.action = [&types = context.types, options] { return TuneRun(*options).run(types); };
  });
}

}  // namespace sinew::app
