// run, check, graph, doctor: what is done with a robot file.
#include <CLI/CLI.hpp>
#include <cstdio>

#include "apps/command/choice_check.hpp"
#include "apps/command/number_check.hpp"
#include "apps/robot/doctor.hpp"
#include "apps/robot/linux_board.hpp"
#include "apps/robot/policy_rules.hpp"
#include "apps/robot/robot_check.hpp"
#include "apps/robot/team_rules.hpp"
#include "apps/robot/wiring_rules.hpp"
#include "apps/robot_file/robot_file.hpp"
#include "apps/run/commands.hpp"
#include "apps/run/run_command.hpp"
#include "apps/run/run_setup.hpp"
#include "apps/view/graph_json.hpp"
#include "apps/view/graph_text.hpp"
#include "drivers/joints/bus_check.hpp"

namespace sinew::app {
namespace {

struct CheckOptions {
  std::string robot, board{};
  bool dot = false, json = false, resolved = false;
};

struct Checked {
  RobotFile robot{};
  std::unique_ptr<rt::Graph> graph{};
  std::vector<rt::Problem> problems{};
  std::string calibration{};              // file of that robot, and
  std::vector<rt::Problem> calibrated{};  // what is wrong there
  bool readable = true;
  std::vector<std::string> narrower{};  // narrower_joints()

  std::size_t count() const { return problems.size() + calibrated.size(); }
  std::vector<PlacedProblem> placed() const {
    std::vector<PlacedProblem> all;
    for (rt::Problem p : problems) {
      LinePlace at = robot.place_of(p.line);
      p.line = at.line;
      all.push_back({std::move(at.file), std::move(p)});
    }
    for (const rt::Problem& p : calibrated) all.push_back({calibration, p});
    return all;
  }
};

// Prints all problems of a robot file on standard error.
Checked checked_graph(const CheckOptions& options, const rt::ModuleTypes& types) {
  const std::string& path = options.robot;
  Checked checked;
  LoadedRobot loaded = load_robot(path);
  checked.readable = loaded.readable;
  OptionLines lines;
  if (rt::GraphSpec& spec = loaded.robot.graph; !options.board.empty())
    spec.board = options.board, spec.board_line = lines.line_of("--board " + options.board);
  const rt::CheckOptions how = check_options(loaded.robot);
  if (!loaded.problems.empty()) add_graph_problems(loaded, types, how);
  checked.problems = std::move(loaded.problems);
  if (checked.problems.empty()) {
    checked.graph = std::make_unique<rt::Graph>(loaded.robot.graph, types);
    checked.problems = check_robot(loaded.robot, *checked.graph, how);
  }
  if (checked.problems.empty()) {  // beside problems of the robot file itself it would not be clear which file is wrong
    const UsedCalibration used = use_calibration(loaded.robot, types);
    checked.calibration = used.file;
    checked.calibrated = used.problems;
  }
  const std::size_t n = checked.count();
  if (n == 0) checked.narrower = narrower_joints(loaded.robot);
  for (const auto& p : checked.problems) std::fprintf(stderr, "%s\n", lines.told(p, loaded.robot).c_str());
  for (const auto& p : checked.calibrated) std::fprintf(stderr, "%s\n", rt::to_string(p, checked.calibration).c_str());
  if (n > 0) std::fprintf(stderr, "%zu problem%s\n", n, n == 1 ? "" : "s");
  checked.robot = std::move(loaded.robot);
  return checked;
}

int code_of(const Checked& checked) {
  if (checked.count() == 0) return kDone;
  return checked.readable ? kFailed : kNotBegun;
}

int print_resolved(const std::string& path) {
  const LoadedRobot loaded = load_robot(path);
  if (loaded.robot.text.empty()) {
    for (const auto& p : loaded.problems) std::fprintf(stderr, "%s\n", to_string(p, loaded.robot).c_str());
    return loaded.readable ? kFailed : kNotBegun;
  }
  std::fputs(loaded.robot.text.c_str(), stdout);
  return kDone;
}

int check(const CheckOptions& options, const rt::ModuleTypes& types) {
  if (options.resolved) return print_resolved(options.robot);
  const Checked checked = checked_graph(options, types);
  const bool good = checked.count() == 0;
  if (options.json) {
    rt::Graph* const graph = good ? checked.graph.get() : nullptr;
    std::printf("%s\n", check_json(options.robot, graph, checked.placed()).c_str());
  } else if (good) {
    rt::Graph& graph = *checked.graph;
    std::printf("%s: %zu threads, %zu modules, %zu topics, %zu chains: no problems\n", options.robot.c_str(),
                graph.threads().size(), graph.modules().size(), graph.topics().size(), graph.chains().size());
    for (const std::string& joint : checked.narrower) std::printf("%s\n", joint.c_str());
    if (check_linux_devices(checked.robot).empty())
      for (const std::string& bus : drivers::describe_buses(checked.robot.devices)) std::printf("%s\n", bus.c_str());
    for (const std::string& policy : describe_policies(checked.robot)) std::printf("%s\n", policy.c_str());
    for (const std::string& cost : describe_team(checked.robot, graph))
      std::printf("says to mates: %s\n", cost.c_str());
    std::printf("%s", slot_table(graph).c_str());
  }
  return code_of(checked);
}

int graph(const CheckOptions& options, const rt::ModuleTypes& types) {
  const Checked checked = checked_graph(options, types);
  if (checked.count() > 0) return code_of(checked);
  const rt::Graph& graph = *checked.graph;
  std::string text;
  if (options.json)
    text = graph_json(graph) + "\n";
  else
    text = options.dot ? graph_dot(graph) : graph_tree(graph);
  std::printf("%s", text.c_str());
  return kDone;
}

void describe_run(CLI::App& run, RunOptions& o) {
  run.add_option("robot", o.robot, "robot file")->required()->type_name(kRobotFileHint);
  run.add_option("--name", o.name, "name on this machine for other programs, instead of the file's robot name");
  run.add_option("--board", o.board, "instead of the file's")->type_name("{sim,linux,dataset,none}");
  run.add_option("--board-of", o.board_of, "one device from another board, DEVICE=BOARD; may be repeated")
      ->allow_extra_args(false)
      ->type_name("D=B");
  run.add_flag("--virtual", o.virtual_time,
               "virtual time: as fast as the machine can, the same bytes for the same seed");
  run.add_option("--seed", o.seed, "instead of the file's")->check(whole())->type_name("N");
  run.add_option("--duration", o.duration_s, "stop after so many seconds; 0: when the mission, plant or data ends")
      ->check(number(0))
      ->type_name("S");
  run.add_option("--rate", o.rate, "sim board in real time: robot seconds per second, for a plant slower than life")
      ->check(number(0.001, 1000.0))
      ->excludes("--virtual");
  run.add_flag("--real-actuators", o.real_actuators, "real actuators may move although sensors are simulated");
  run.add_option("--data", o.data, "dataset board: folder in the EuRoC/ASL form")->type_name(kFolderHint);
  run.add_option("--from", o.from_s, "dataset board: begin so many seconds after the first sample")
      ->check(number(0))
      ->type_name("S");
  run.add_option("--params", o.params, "parameters in place of the file's, as `param save` writes them")
      ->type_name(kRobotFileHint);
  run.add_option("--set", o.set,
                 "module.param=value, or sim.key=value (of the world), device.NAME.key=value, bus.NAME.key=value; may "
                 "be repeated")
      ->allow_extra_args(false)
      ->type_name(kSettingHint);
  run.add_option_function<std::string>(
         "--plant",
         [&o](const std::string& place) {
           // A foreign server is the world of a simulator of our own.
           constexpr std::string_view kSimspark = "simspark:";
           const bool foreign = place.starts_with(kSimspark);
           o.plant = foreign ? "auto" : place;
           if (foreign) o.plant_args.push_back("--simspark=" + place.substr(kSimspark.size()));
         },
         "sim board: auto, unix:PATH or tcp:HOST:PORT; simspark:HOST:PORT[/TEAM]: a server of SimSpark")
      ->type_name("PLACE");
  run.add_option("--plant-arg", o.plant_args, "one more argument for sinew-sim (see sinew-sim --help); may be repeated")
      ->allow_extra_args(false)
      ->type_name("ARG");
  run.add_option("--fault", o.faults, "a fault for a plant of our own to play, e.g. imu:stuck@5+0.5; may be repeated")
      ->allow_extra_args(false)
      ->type_name("FAULT");
  run.add_option("--camera", o.camera, "sim board: size of the camera's frames")->type_name("WxH");
  run.add_option("--trace", o.trace, "write the time line of the last second here, for ui.perfetto.dev")
      ->type_name(kFileHint);
  run.add_option("--plot", o.plot, "dataset board: write a plot of the tilt error here, SVG or PNG")
      ->type_name(kFileHint);
  run.add_option("--runs", o.record_folder, "folder of the recordings (default: the robot file's, or runs)");
  run.add_flag("--record-images", o.record_images, "record all pixels, whatever the robot file allows");
  run.add_flag("--no-record", o.no_record, "no recording; SINEW_RECORD=off in the environment does the same");
  run.add_flag(
      "--strict", o.strict,
      "real time: do not start if the machine lacks something that timing needs; exit code 1 also when the run "
      "does not count as a measurement");
  run.add_flag("--unsupervised", o.unsupervised,
               "no parent process that stops the actuators when the runtime dies or hangs (for debuggers)");
  run.add_flag("--plain", o.plain, "no live table");
  run.add_flag("--quiet", o.quiet, "only the mission's result, one line");
  run.add_flag("--verbose", o.verbose,
               "at the end also threads, modules, losses, chains, memory, hashes, validity, and the whole time line")
      ->excludes("--quiet");
  run.add_flag("--json", o.json, "only one JSON object with the whole summary, at the end");
}

void describe_doctor(CLI::App& doctor, DoctorOptions& o) {
  doctor.add_option("robot", o.robot, "robot file: what it asks for is checked, too")->type_name(kRobotFileHint);
  doctor.add_option("--board", o.board, "instead of the file's: linux looks at its devices")
      ->type_name("{sim,linux,dataset,none}")
      ->check(one_of({"sim", "linux", "dataset", "none"}));
  CLI::Option& root =
      *doctor.add_option("--root", o.root, "folder with proc, sys and dev, e.g. a copy of another machine's")
           ->type_name(kFolderHint);
  doctor
      .add_option("--write-test", o.write_test_s,
                  "write into the folder of the recordings for so long, and measure how long the disk stalls")
      ->check(number(0.1, 3600.0))
      ->type_name("S")
      ->excludes(&root);
  doctor.add_flag("--json", o.json, "as one JSON object");
  doctor.add_flag("--strict", o.strict, "exit code 1 also for warnings");
}

CLI::App& robot_file_command(CLI::App& app, const char* name, const char* text, CheckOptions& o) {
  CLI::App& command = *app.add_subcommand(name, text);
  command.add_option("robot", o.robot, "robot file")->required()->type_name(kRobotFileHint);
  command.add_flag("--json", o.json, "as one JSON object");
  return command;
}

}  // namespace

void add_robot_commands(CLI::App& app, CommandContext& context) {
  const auto run_options = std::make_shared<RunOptions>();
  CLI::App* run = app.add_subcommand("run", "run a robot file in real or virtual time");
  describe_run(*run, *run_options);
  run->callback([&context, run_options] {
    context.action = [&types = context.types, run_options] { return run_command(*run_options, types); };
  });

  const auto check_options = std::make_shared<CheckOptions>();
  CLI::App& check_command =
      robot_file_command(app, "check", "check a robot file as a whole; all problems in one run", *check_options);
  check_command.add_option("--board", check_options->board, "as it would be with this board instead of the file's")
      ->type_name("{sim,linux,dataset,none}");
  check_command.add_flag("--resolved", check_options->resolved,
                         "print the robot file with all that it extends, unchecked");
  check_command.callback([&context, check_options] {
    context.action = [&types = context.types, check_options] { return check(*check_options, types); };
  });

  const auto graph_options = std::make_shared<CheckOptions>();
  CLI::App& graph_command =
      robot_file_command(app, "graph", "show threads, modules and topics of a robot file as a tree", *graph_options);
  graph_command.add_flag("--dot", graph_options->dot, "in Graphviz's language");
  graph_command.callback([&context, graph_options] {
    context.action = [&types = context.types, graph_options] { return graph(*graph_options, types); };
  });

  const auto doctor_options = std::make_shared<DoctorOptions>();
  CLI::App* doctor = app.add_subcommand("doctor", "check whether this machine has what timing needs");
  describe_doctor(*doctor, *doctor_options);
  doctor->callback([&context, doctor_options] {
    context.action = [&types = context.types, doctor_options] { return doctor_command(*doctor_options, types); };
  });
}

}  // namespace sinew::app
