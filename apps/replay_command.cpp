#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "apps/bag_file.hpp"
#include "apps/commands.hpp"
#include "apps/dataset_run.hpp"
#include "apps/param_value.hpp"
#include "apps/robot_file.hpp"
#include "apps/run_setup.hpp"
#include "hal/linux/os.hpp"
#include "hal/silent_board.hpp"
#include "record/run/replay.hpp"

namespace sinew::app {
namespace {

using Json = nlohmann::ordered_json;

struct ReplayCommand {
  std::string file;
  std::vector<std::string> modules, set;
  std::optional<double> from_s;
  bool json = false;
};

/// The graph that the file says it ran: its robot file, the parameters of the start, the seed.
std::unique_ptr<rt::Graph> graph_of(record::Reader& reader, const ReplayCommand& command, const rt::ModuleTypes& types,
                                    std::string& why) {
  const auto text = record::read_attachment(reader, "robot.toml");
  const auto run = record::read_metadata(reader, "sinew.run");
  if (!text || !run.contains("seed")) {
    why = "the file holds no run of Sinew";
    return nullptr;
  }
  LoadedRobot loaded = parse_robot(*text, command.file + ": robot.toml");
  for (const auto& p : loaded.problems) why += rt::to_string(p, loaded.robot.path) + "\n";
  if (!loaded.problems.empty()) return nullptr;
  rt::GraphSpec& spec = loaded.robot.graph;
  const std::string& seed = run.at("seed");
  std::from_chars(seed.data(), seed.data() + seed.size(), spec.seed);

  const auto modules = record::read_metadata(reader, "sinew.modules");
  const auto ran = [&](const std::string& name) {
    return std::any_of(modules.begin(), modules.end(), [&](const auto& m) { return m.second == name; });
  };
  if (std::any_of(spec.modules.begin(), spec.modules.end(),
                  [&](const auto& m) { return m.type == "drivers::CameraSource" && !ran(m.name); }))
    leave_out_camera(spec);
  for (const auto& param : record::read_metadata(reader, "sinew.params")) {
    const std::string &name = param.first, &value = param.second;
    const bool is_text = value.size() >= 2 && value.front() == '"';
    const auto module = std::find_if(spec.modules.begin(), spec.modules.end(),
                                     [&](const auto& m) { return m.name == name.substr(0, name.find('.')); });
    if (module == spec.modules.end()) continue;  // the guardian has none
    module->params[name.substr(name.find('.') + 1)] = {
        is_text ? rt::ParamValue(value.substr(1, value.size() - 2)) : param_value(value), 0};
  }
  for (const auto& setting : command.set)
    if (why = apply_setting(spec, setting); !why.empty()) return nullptr;
  auto graph = std::make_unique<rt::Graph>(spec, types);
  for (const auto& p : graph->check()) why += rt::to_string(p, loaded.robot.path) + "\n";
  if (!why.empty()) return nullptr;
  return graph;
}

std::string difference_text(const record::ReplayDifference& d) {
  char at[64];
  std::snprintf(at, sizeof at, "step %u at %.6f s", d.step, msg::seconds(d.now));
  return d.module + ", " + at + ": " + d.what + ": recorded " + d.recorded + ", now " + d.again;
}

Json to_json(const record::ReplayDifference& d) {
  return {{"module", d.module}, {"step", d.step},         {"time_s", msg::seconds(d.now)},
          {"what", d.what},     {"recorded", d.recorded}, {"now", d.again}};
}

int tell(const ReplayCommand& command, const record::ReplayReport& report, double wall_s) {
  const auto* first = report.first_difference();
  std::uint64_t steps = 0, messages = 0;
  Json modules = Json::object();
  for (const auto& m : report.modules) {
    steps += m.steps, messages += m.messages;
    modules[m.name] = {{"steps", m.steps}, {"messages", m.messages}, {"not_compared", m.not_compared}};
    if (!m.stopped.empty()) modules[m.name]["stopped"] = m.stopped;
    if (m.difference) modules[m.name]["difference"] = to_json(*m.difference);
  }
  const double length_s = msg::seconds(report.length);
  const bool asked_and_missed = !command.modules.empty() && !report.complete();
  const int code = first || asked_and_missed || !report.problems.empty() ? kFailed : kDone;
  if (command.json) {
    Json all{{"identical", first == nullptr}, {"steps", steps},   {"messages", messages},
             {"robot_s", length_s},           {"wall_s", wall_s}, {"modules", modules}};
    if (first) all["first_difference"] = to_json(*first);
    for (const auto& p : report.problems) all["problems"].push_back(record::to_string(p));
    std::printf("%s\n", all.dump(2, ' ', false, Json::error_handler_t::replace).c_str());
    return code;
  }
  say_problems(command.file, report.problems);
  for (const auto& m : report.modules) {
    if (!m.stopped.empty())
      std::printf("%s: %llu steps, then %s\n", m.name.c_str(), static_cast<unsigned long long>(m.steps),
                  m.stopped.c_str());
    if (m.difference && &*m.difference != first) std::printf("%s\n", difference_text(*m.difference).c_str());
  }
  if (first) std::printf("first difference: %s\n", difference_text(*first).c_str());
  std::printf("%s: %llu steps and %llu messages of %zu modules compared, %.3f s in %.3f s: %.1f times real time\n",
              first ? "NOT identical" : "identical", static_cast<unsigned long long>(steps),
              static_cast<unsigned long long>(messages), report.modules.size(), length_s, wall_s, length_s / wall_s);
  return code;
}

int replay(const ReplayCommand& command, const rt::ModuleTypes& types) {
  auto progress = std::make_unique<Progress>("replay");
  const auto reader = open_recording(command.file, *progress);
  if (!reader) return kNotBegun;
  std::string why;
  const auto graph = graph_of(*reader, command, types, why);
  if (!graph) return fail(command.file + ": " + why);
  hal::SilentBoard board;
  if (const auto configured = graph->configure(board); !configured) {
    for (const auto& p : graph->configure_problems())
      std::fprintf(stderr, "%s\n", rt::to_string(p, command.file + ": robot.toml").c_str());
    return fail(command.file + ": its modules cannot be configured");
  }
  record::ReplayOptions options;
  options.modules = command.modules;
  options.from_s = command.from_s;
  const hal::Time begin = hal::linux_os().now();
  const auto report = record::replay(*reader, *graph, options, why);
  if (!report) return fail(command.file + ": " + why);
  progress.reset();
  return tell(command, *report, msg::seconds(hal::linux_os().now() - begin));
}

}  // namespace

void add_replay_command(CLI::App& app, CommandContext& context) {
  const auto options = std::make_shared<ReplayCommand>();
  CLI::App& command = *app.add_subcommand(
      "replay", "execute the recorded steps of a run again and compare what comes out, byte for byte");
  command.add_option("file", options->file, "the recording")->required()->type_name(kFileHint);
  command.add_option("--modules", options->modules, "only these, e.g. filter,attitude")->delimiter(',');
  command.add_option("--from", options->from_s, "begin at the saved states before so many seconds of the record")
      ->check(CLI::NonNegativeNumber)
      ->type_name("S");
  command.add_option("--set", options->set, "module.param=value from the start on; may be repeated")
      ->allow_extra_args(false)
      ->type_name("M.P=V");
  command.add_flag("--json", options->json, "as one JSON object");
  command.callback(
      [&context, options] { context.action = [&types = context.types, options] { return replay(*options, types); }; });
}

}  // namespace sinew::app
