#include "apps/run/run_setup.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <sstream>

#include "apps/robot/board_rules.hpp"
#include "apps/robot/linux_board.hpp"
#include "apps/robot/robot_check.hpp"
#include "apps/robot_file/param_overlay.hpp"
#include "apps/robot_file/param_value.hpp"
#include "apps/robot_file/world_options.hpp"
#include "apps/run/ground_truth_source.hpp"
#include "apps/run/recording.hpp"
#include "hal/did_you_mean.hpp"
#include "hal/linux/process.hpp"
#include "hal/linux/run_dir.hpp"
#include "hal/linux/system_files.hpp"
#include "hal/platform.hpp"

namespace sinew::app {
bool configure(const Prepared& prepared, hal::Board& board, const rt::ConfigureOptions& how,
               const std::function<std::string()>& devices) {
  rt::Graph& graph = *prepared.graph;
  const auto ready = graph.configure(board, how);
  const std::string why = devices ? devices() : std::string();
  for (const auto& p : without_devices(graph.configure_problems(), why))
    std::fprintf(stderr, "%s\n", prepared.options.told(p, prepared.robot).c_str());
  if (ready) return true;
  std::istringstream lines(why);
  for (std::string line; std::getline(lines, line);) std::fprintf(stderr, "sinew: %s\n", line.c_str());
  if (why.empty() && graph.configure_problems().empty()) std::fprintf(stderr, "sinew: %s\n", ready.error().where);
  return false;
}

std::vector<rt::Problem> without_devices(const std::vector<rt::Problem>& problems, const std::string& devices) {
  std::vector<rt::Problem> rest;
  for (const rt::Problem& p : problems) {
    // "device 'imu': not found" of a source, "actuators 'head' of the board: ..." of the guardian.
    const bool of_device = p.allowed.starts_with("device '") || p.allowed.starts_with("actuators '");
    const auto from = p.allowed.find('\''), to = p.allowed.find('\'', from + 1);
    const bool told = of_device && to != std::string::npos &&
                      devices.find("device " + p.allowed.substr(from, to + 1 - from)) != std::string::npos;
    if (!told) rest.push_back(p);
  }
  return rest;
}

std::unique_ptr<dataset::DatasetBoard> open_dataset(const RunOptions& options, const hal::Clock* clock, hal::Os& os,
                                                    std::string& why) {
  if (options.data.empty()) {
    why = "board \"dataset\": name a folder with --data DIR";
    return nullptr;
  }
  dataset::DatasetOptions dataset;
  dataset.folder = options.data;
  dataset.from = rt::Duration{static_cast<std::int64_t>(options.from_s * 1e9)};
  dataset.clock = clock ? clock : &os;
  dataset.os = clock ? nullptr : &os;
  auto board = dataset::DatasetBoard::open(dataset, why);
  return board ? std::move(*board) : nullptr;
}

rt::Duration run_duration(const RunOptions& options) {
  return rt::Duration{static_cast<std::int64_t>(options.duration_s * 1e9)};
}

std::string apply_setting(rt::GraphSpec& graph, const std::string& setting, int line) {
  const auto dot = setting.find('.'), equals = setting.find('=');
  if (dot == std::string::npos || equals == std::string::npos || equals < dot)
    return fmt::format("--set {}: module.param=value", setting);
  const std::string module = setting.substr(0, dot);
  for (auto& m : graph.modules) {
    if (m.name != module) continue;
    m.params[setting.substr(dot + 1, equals - dot - 1)] = {param_value(setting.substr(equals + 1)), line};
    return {};
  }
  if (const std::string header = section_header(module); !header.empty())
    return fmt::format("--set {}: --set is for parameters of modules; the keys of {} are set in the robot file",
                       setting, header);
  std::string all;
  std::vector<std::string> names{"device", "bus", "sim"};  // the other forms of --set
  for (const auto& m : graph.modules) all += " " + m.name, names.push_back(m.name);
  return fmt::format("--set {}: no module {}; there are:{}{}", setting, module, all, hal::did_you_mean(module, names));
}

std::optional<std::string> apply_device_setting(drivers::DeviceSpecs& devices, const std::string& setting, int line) {
  const auto equals = setting.find('=');
  std::vector<std::string> parts;
  std::istringstream path(setting.substr(0, equals));
  for (std::string part; std::getline(path, part, '.');) parts.push_back(part);
  if (equals == std::string::npos || parts.size() < 3 || (parts[0] != "device" && parts[0] != "bus")) return {};
  const auto find = [](std::vector<drivers::DeviceSpec>& all, const std::string& name) {
    const auto it = std::find_if(all.begin(), all.end(), [&](const auto& d) { return d.name == name; });
    return it == all.end() ? nullptr : &*it;
  };
  const auto near = [](const std::vector<drivers::DeviceSpec>& all, const std::string& name) {
    std::vector<std::string> names;
    for (const auto& d : all) names.push_back(d.name);
    return hal::did_you_mean(name, names);
  };
  auto& all = parts[0] == "bus" ? devices.buses : devices.devices;
  drivers::DeviceSpec* spec = find(all, parts[1]);
  if (!spec)
    return fmt::format("--set {}: the robot file has no [{}.{}]{}", setting, parts[0], parts[1], near(all, parts[1]));
  if (parts.size() == 5 && parts[2] == "joint") {
    const auto& joints = spec->joints;
    spec = find(spec->joints, parts[3]);
    if (!spec)
      return fmt::format("--set {}: [{}.{}] has no joint {}{}", setting, parts[0], parts[1], parts[3],
                         near(joints, parts[3]));
  } else if (parts.size() != 3) {
    return fmt::format("--set {}: device.NAME.key=value, device.NAME.joint.JOINT.key=value or bus.NAME.key=value",
                       setting);
  }
  const std::string value = setting.substr(equals + 1);
  if (parts.back() == "driver")
    spec->driver = value, spec->line = line ? line : spec->line;
  else
    spec->keys[parts.back()] = {param_value(value), line};
  return std::string();
}

std::string apply_only_device_setting(drivers::DeviceSpecs& devices, const std::string& setting, int line) {
  return apply_device_setting(devices, setting, line)
      .value_or("--set " + setting + ": device.NAME.KEY=VALUE or bus.NAME.KEY=VALUE");
}

rt::RealTimeOptions real_time_options(const RunOptions& run) {
  rt::RealTimeOptions options;
  options.strict = run.strict;
  const hal::SystemFiles files("/");
  const auto runtime_us = files.number("proc/sys/kernel/sched_rt_runtime_us");
  const auto period_us = files.number("proc/sys/kernel/sched_rt_period_us");
  if (!runtime_us || !period_us) return options;
  const auto scaled = [rate = run.rate](std::int64_t us) {
    return rt::Duration{static_cast<std::int64_t>(static_cast<double>(us) * 1e3 * rate)};
  };
  options.throttle.period = scaled(*period_us);
  options.throttle.frozen = scaled(*runtime_us < 0 ? 0 : *period_us - *runtime_us);
  return options;
}

bool accept_shortfalls(const std::vector<std::string>& shortfalls, bool strict) {
  for (const auto& line : shortfalls) std::fprintf(stderr, "warning: %s\n", line.c_str());
  if (shortfalls.empty() || !strict) return true;
  std::fprintf(stderr, "sinew: --strict: not started\n");
  return false;
}

// Applies the calibration file. False after printing its problems. Without such a file the robot runs by its robot
// file.
static bool calibrate(RobotFile& robot, const rt::ModuleTypes& types) {
  if (!uses_linux_board(robot.graph)) return true;
  const UsedCalibration used = use_calibration(robot, types);
  if (used.absent)
    std::fprintf(stderr, "warning: %s: no such file: this robot is not calibrated (sinew calibrate)\n",
                 used.file.c_str());
  for (const auto& p : used.problems) std::fprintf(stderr, "%s\n", rt::to_string(p, used.file).c_str());
  return used.problems.empty();
}

int OptionLines::line_of(std::string option) {
  options_.push_back(std::move(option));
  return -static_cast<int>(options_.size());
}

std::string OptionLines::told(const rt::Problem& problem, const RobotFile& robot) const {
  if (problem.line >= 0) return to_string(problem, robot);
  return rt::to_string({0, problem.key, problem.value, problem.allowed},
                       "from " + options_[static_cast<std::size_t>(-problem.line - 1)]);
}

static bool has_module(const rt::GraphSpec& graph, std::string_view name) {
  return std::any_of(graph.modules.begin(), graph.modules.end(), [&](const auto& m) { return m.name == name; });
}

std::optional<Prepared> prepare(const RunOptions& options, const rt::ModuleTypes& types) {
  LoadedRobot loaded = load_robot(options.robot);
  if (!loaded.problems.empty()) add_graph_problems(loaded, types, {options.virtual_time, hal::usable_cpus()});
  for (const auto& p : loaded.problems) std::fprintf(stderr, "%s\n", to_string(p, loaded.robot).c_str());
  if (!loaded.problems.empty()) return std::nullopt;
  rt::GraphSpec& spec = loaded.robot.graph;
  OptionLines lines;
  if (!options.board.empty()) spec.board = options.board, spec.board_line = lines.line_of("--board " + options.board);
  for (const std::string& choice : options.board_of) {
    const auto equals = choice.find('=');
    if (equals == std::string::npos || equals == 0) {
      std::fprintf(stderr, "sinew: --board-of %s: DEVICE=BOARD\n", choice.c_str());
      return std::nullopt;
    }
    spec.device_boards[choice.substr(0, equals)] = {choice.substr(equals + 1), lines.line_of("--board-of " + choice)};
  }
  if (options.seed) spec.seed = *options.seed;
  if (!options.plant.empty()) loaded.robot.sim.plant = options.plant;
  if (!options.params.empty()) {
    const auto problems =
        apply_overlay(load_overlay(options.params), types, spec, lines.line_of("--params " + options.params));
    for (const auto& p : problems) std::fprintf(stderr, "%s\n", rt::to_string(p, options.params).c_str());
    if (!problems.empty()) return std::nullopt;
  }
  if (!calibrate(loaded.robot, types)) return std::nullopt;
  for (const auto& setting : options.set) {
    const int line = lines.line_of("--set " + setting);
    auto applied = apply_device_setting(loaded.robot.devices, setting, line);
    if (!applied && !has_module(spec, "sim")) applied = apply_sim_setting(loaded.robot.sim, setting);
    if (const std::string why = applied ? *applied : apply_setting(spec, setting, line); !why.empty()) {
      std::fprintf(stderr, "sinew: %s\n", why.c_str());
      return std::nullopt;
    }
  }
  if (!options.camera.empty()) {
    unsigned w = 0, h = 0;
    char rest = 0;
    if (std::sscanf(options.camera.c_str(), "%ux%u%c", &w, &h, &rest) != 2 || w < 16 || h < 16 ||
        w > msg::kMaxImageWidth || h > msg::kMaxImageHeight) {
      std::fprintf(stderr, "sinew: --camera %s: WIDTHxHEIGHT, at most 1280x960\n", options.camera.c_str());
      return std::nullopt;
    }
    loaded.robot.sim.camera_width = w, loaded.robot.sim.camera_height = h;
    loaded.robot.sim.camera_line = lines.line_of("--camera " + options.camera);
  }
  Prepared prepared{std::move(loaded.robot), types, nullptr, nullptr, std::move(lines)};
  if (needs_plant(prepared.robot.graph)) {
    add_ground_truth_type(prepared.types);
    add_ground_truth(prepared.robot.graph);
  }
  prepared.graph = std::make_unique<rt::Graph>(prepared.robot.graph, prepared.types);
  const auto problems = check_robot(prepared.robot, *prepared.graph, {options.virtual_time, hal::usable_cpus()});
  for (const auto& p : problems) std::fprintf(stderr, "%s\n", prepared.options.told(p, prepared.robot).c_str());
  if (!problems.empty()) return std::nullopt;
  return prepared;
}

bool take_name(Prepared& prepared, const RunOptions& options) {
  const std::string robot = options.name.empty() ? prepared.graph->spec().robot : options.name;
  std::string why;
  auto name = tap::Name::take(robot, why);
  if (!name && name.error().code == hal::Errc::busy && options.virtual_time)
    name = tap::Name::take(fmt::format("{}-{}", robot, hal::process_id()), why);
  if (name) {
    prepared.name = std::move(*name);
    return true;
  }
  const bool unusable = name.error().code == hal::Errc::busy || name.error().code == hal::Errc::bad_argument;
  std::fprintf(stderr, "sinew: %s%s\n", unusable ? "" : "warning: no socket for other programs: ", why.c_str());
  return !unusable;
}

std::unique_ptr<tap::Server> open_socket(const Prepared& prepared, const RunOptions& options, rt::Runner& runner,
                                         tap::RecordControl* record_control, const hal::Clock& clock,
                                         std::function<void()> stop,
                                         std::function<std::vector<std::string>()> complaints) {
  if (!prepared.name) return nullptr;
  auto server = tap::Server::open(*prepared.name, *prepared.graph, runner, hal::system_os(),
                                  {.board = prepared.graph->spec().board,
                                   .virtual_time = options.virtual_time,
                                   .stop = std::move(stop),
                                   .robot_file = std::filesystem::absolute(options.robot).lexically_normal().string(),
                                   .clock = &clock,
                                   .record_control = record_control,
                                   .complaints = std::move(complaints)});
  if (server) return std::move(*server);
  std::fprintf(stderr, "sinew: warning: no socket for other programs: %s: %s\n", prepared.name->path().c_str(),
               server.error().where);
  return nullptr;
}

}  // namespace sinew::app
