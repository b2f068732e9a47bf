// sinew: runs, checks and shows robots.
#include <CLI/CLI.hpp>
#include <cstdio>

#include "apps/graph_text.hpp"
#include "apps/module_list.hpp"
#include "apps/robot_file.hpp"
#include "apps/run_command.hpp"

namespace {

using namespace sinew;

struct CheckOptions {
  std::string robot;
  bool dot = false;
};

// The graph of a robot file; null after its problems have been printed.
std::unique_ptr<rt::Graph> checked_graph(const std::string& path) {
  app::LoadedRobot loaded = app::load_robot(path);
  auto problems = loaded.problems;
  std::unique_ptr<rt::Graph> graph;
  if (problems.empty()) {
    graph = std::make_unique<rt::Graph>(loaded.robot.graph, app::all_modules());
    problems = graph->check({.virtual_time = true});
  }
  for (const auto& p : problems) std::fprintf(stderr, "%s\n", rt::to_string(p, path).c_str());
  if (problems.empty()) return graph;
  std::fprintf(stderr, "%zu problem%s\n", problems.size(), problems.size() == 1 ? "" : "s");
  return nullptr;
}

int check(const CheckOptions& options) {
  const auto graph = checked_graph(options.robot);
  if (!graph) return 1;
  std::printf("%s: %zu threads, %zu modules, %zu topics, %zu chains: no problems\n", options.robot.c_str(),
              graph->threads().size(), graph->modules().size(), graph->topics().size(), graph->chains().size());
  std::printf("%s", app::slot_table(*graph).c_str());
  return 0;
}

int graph(const CheckOptions& options) {
  const auto graph = checked_graph(options.robot);
  if (!graph) return 1;
  std::printf("%s", (options.dot ? app::graph_dot(*graph) : app::graph_tree(*graph)).c_str());
  return 0;
}

void describe_run(CLI::App& run, app::RunOptions& o) {
  run.add_option("robot", o.robot, "robot file (TOML)")->required();
  run.add_option("--board", o.board, "instead of the file's: sim, dataset");
  run.add_flag("--virtual", o.virtual_time,
               "virtual time: as fast as the machine can, the same bytes for the same seed");
  run.add_option("--seed", o.seed, "instead of the file's");
  run.add_option("--duration", o.duration_s, "stop after so many seconds; 0: when the mission, plant or data ends")
      ->check(CLI::NonNegativeNumber);
  run.add_option("--data", o.data, "dataset board: folder in the EuRoC/ASL form");
  run.add_option("--from", o.from_s, "dataset board: begin so many seconds after the first sample")
      ->check(CLI::NonNegativeNumber);
  run.add_option("--set", o.set, "module.param=value; may be repeated")->allow_extra_args(false);
  run.add_option("--plant", o.plant, "sim board: auto, unix:PATH or tcp:HOST:PORT");
  run.add_option("--plant-arg", o.plant_args, "one more argument for sinew-sim; may be repeated")
      ->allow_extra_args(false);
  run.add_option("--camera", o.camera, "sim board: size of the camera's frames, e.g. 640x480");
  run.add_option("--plot", o.plot, "dataset board: write a plot (SVG) of the tilt error here");
  run.add_flag("--unsupervised", o.unsupervised,
               "no parent process that stops the actuators when the runtime dies or hangs (for debuggers)");
  run.add_flag("--plain", o.plain, "no live table");
  run.add_flag("--quiet", o.quiet, "only the result");
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Sinew: an embedded real-time runtime for the onboard computers of humanoids and UAVs.", "sinew");
  app.require_subcommand(1);
  app.set_version_flag("--version", SINEW_VERSION);
  app::RunOptions run_options;
  CheckOptions check_options, graph_options;
  CLI::App* run_app = app.add_subcommand("run", "run a robot file in real or virtual time");
  describe_run(*run_app, run_options);
  CLI::App* check_app = app.add_subcommand("check", "check a robot file as a whole; all problems in one run");
  check_app->add_option("robot", check_options.robot, "robot file (TOML)")->required();
  CLI::App* graph_app = app.add_subcommand("graph", "show threads, modules and topics of a robot file as a tree");
  graph_app->add_option("robot", graph_options.robot, "robot file (TOML)")->required();
  graph_app->add_flag("--dot", graph_options.dot, "in Graphviz's language");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    const int code = app.exit(e);
    return code == 0 ? 0 : 2;
  }
  if (run_app->parsed()) return app::run_command(run_options);
  if (check_app->parsed()) return check(check_options);
  return graph(graph_options);
}
