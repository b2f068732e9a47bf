#include "apps/robot_file/robot_file.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "apps/robot_file/device_table_reader.hpp"
#include "apps/robot_file/exec_reader.hpp"
#include "apps/robot_file/net_reader.hpp"
#include "apps/robot_file/policy_reader.hpp"
#include "apps/robot_file/ros2_reader.hpp"
#include "apps/robot_file/team_reader.hpp"
#include "apps/robot_file/world_options.hpp"
#include "apps/toml/body_reader.hpp"
#include "apps/toml/motion_reader.hpp"
#include "apps/toml/toml_reader.hpp"
#include "hal/did_you_mean.hpp"
#include "msg/actuators.hpp"
#include "msg/image.hpp"
#include "robots/robot_kind.hpp"

namespace sinew::app {
namespace {

using namespace std::chrono_literals;
using rt::Duration;
using rt::ThreadSpec;

constexpr double kUs = 1e3, kMs = 1e6;
constexpr Duration kLongest = 3600s;
constexpr Duration kLongestHistory = 4s;

void read_thread(TomlReader& r, rt::GraphSpec& graph) {
  ThreadSpec t;
  t.line = r.line();
  r.require("name", t.name);
  std::int64_t number = 0;
  if (!r.has("priority")) r.missing("priority", "an integer from 0 to 98; it is required");
  if (r.read("priority", number, 0, 98)) t.priority = static_cast<int>(number);
  const bool period = r.read_time("period_us", t.period, kUs, 10us, kLongest);
  const bool topics = r.read_names("trigger", t.topics);
  const bool device = r.read("device", t.device_module, "the name of a driver module in `order`");
  if (r.has("period_us") + r.has("trigger") + r.has("device") != 1)
    r.problems().push_back(
        {t.line, r.path(), "", "exactly one of period_us, trigger (topics), device (a driver module)"});
  t.trigger = topics && !period ? ThreadSpec::Trigger::topics : ThreadSpec::Trigger::period;
  if (device) t.trigger = ThreadSpec::Trigger::device;
  r.read_time("phase_us", t.phase, kUs, 0ns, kLongest);
  r.read_time("timeout_us", t.timeout, kUs, 0ns, kLongest);
  r.read_choice<ThreadSpec::Overrun>(
      "overrun", t.overrun, {{"skip", ThreadSpec::Overrun::skip}, {"catch_up", ThreadSpec::Overrun::catch_up}});
  if (r.read("catch_up_max", number, 1, 1000)) t.catch_up_max = static_cast<std::uint32_t>(number);
  r.read("cpus", t.cpus, 0, 1023);
  if (r.read("stack_kib", number, 16, 65536)) t.stack_kib = static_cast<std::uint32_t>(number);
  r.read("precise", t.precise);
  if (!r.has("order")) r.missing("order", "an array of module names; it is required");
  r.read_names("order", t.order);
  graph.threads.push_back(std::move(t));
}

void read_params(TomlReader& r, rt::ModuleSpec& m) {
  for (const auto& [key, node] : r.raw()) {
    r.take(key.str());
    rt::Located<rt::ParamValue> p;
    p.line = line_of(node);
    if (!read_param_value(node, p.value)) {
      r.problem(node, key.str(), "a boolean, a number or a string");
      continue;
    }
    m.params.emplace(std::string(key.str()), std::move(p));
  }
}

void read_inputs(TomlReader& in, rt::ModuleSpec& m) {
  for (const auto& [key, node] : in.raw()) {
    const std::string port(key.str());
    rt::Located<std::string> topic;
    topic.line = line_of(node);
    if (node.is_table()) {
      in.table(port, [&](TomlReader& r) {
        r.require("topic", topic.value, "the name of a topic; it is required");
        rt::Duration max_age{};
        if (r.read_time("max_age_ms", max_age, kMs, 1ms, kLongest)) m.max_age.emplace(port, max_age);
      });
      m.in.emplace(port, std::move(topic));
    } else if (in.read(port, topic.value, "the name of a topic, e.g. \"imu.raw\", or { topic, max_age_ms }")) {
      m.in.emplace(port, std::move(topic));
    }
  }
}

void read_module(const std::string& name, TomlReader& r, RobotFile& robot) {
  rt::ModuleSpec m;
  m.name = name;
  m.line = r.line();
  r.require("type", m.type, "the type of a module, e.g. \"control::Mixer\"; it is required");
  r.table("in", [&](TomlReader& in) { read_inputs(in, m); });
  r.table("params", [&](TomlReader& p) { read_params(p, m); });
  read_exec(r, m.exec);
  r.read("enabled", m.enabled);
  if (m.type == kPolicyType) read_policy(r, robot, m);
  robot.graph.modules.push_back(std::move(m));
}

// A topic that is written from outside.
void read_writer(TomlReader& r, rt::TopicSpec& t) {
  enum class Writer : std::uint8_t { module, external } writer = Writer::module;
  r.read_choice<Writer>("writer", writer, {{"external", Writer::external}});
  if (writer == Writer::external) {
    t.external.emplace();
    r.require("type", t.external->type, "the type of a message, e.g. \"OperatorLink\"; it is required");
    r.require("thread", t.external->thread, "the name of a thread; it is required");
    read_exec(r, t.external->exec);
    return;
  }
  for (const char* key : {"type", "thread"})
    if (const toml::node* node = r.take(key)) r.problem(*node, key, "none without writer = \"external\"");
}

void read_topic(const std::string& name, TomlReader& r, rt::GraphSpec& graph) {
  rt::TopicSpec t;
  t.name = name;
  t.line = r.line();
  r.table("image", [&](TomlReader& image) {
    std::int64_t width = 0, height = 0;
    auto format = msg::PixelFormat::yuyv;
    for (const char* key : {"width", "height"})
      if (!image.has(key)) image.missing(key, "an integer; it is required");
    image.read("width", width, 1, msg::kMaxImageWidth);
    image.read("height", height, 1, msg::kMaxImageHeight);
    image.read_choice("format", format, msg::kPixelFormats);
    t.image_pixels = static_cast<std::uint32_t>(width * height);
    t.image_bytes = t.image_pixels * msg::bytes_per_pixel(format);
  });
  read_writer(r, t);
  std::int64_t number = 0;
  if (r.read("history", number, 1, 100000)) t.history = static_cast<std::uint32_t>(number);
  r.read("wake_outsiders", t.wake_outsiders);
  graph.topics.push_back(std::move(t));
}

std::optional<rt::ActuatorSpec::Range> range_in(const toml::node& node) {
  const toml::array* pair = node.as_array();
  if (!pair || pair->size() != 2) return std::nullopt;
  const auto low = (*pair)[0].value<double>(), high = (*pair)[1].value<double>();
  if (!low || !high || !(*low <= *high)) return std::nullopt;
  return rt::ActuatorSpec::Range{*low, *high};
}

void read_actuator(const std::string& name, TomlReader& r, rt::GraphSpec& graph) {
  rt::ActuatorSpec a;
  a.name = name;
  a.line = r.line();
  r.require("command", a.command.value, "the topic of its commands; it is required");
  if (const toml::node* node = r.raw().get("command")) a.command.line = line_of(*node);
  std::int64_t channels = 1;
  if (!r.has("channels")) r.missing("channels", "an integer from 1 to 8; it is required");
  r.read("channels", channels, 1, static_cast<std::int64_t>(msg::kMaxChannels));
  a.channels = static_cast<std::uint32_t>(channels);
  if (const toml::node* node = r.raw().get("channels")) a.channels_line = line_of(*node);
  if (const toml::node* node = r.take("limit")) {
    a.limit_line = line_of(*node);
    const toml::array* list = node->as_array();
    bool good = true;
    if (list && !list->empty() && list->front().is_array()) {
      for (const toml::node& one : *list) {
        const auto range = range_in(one);
        good = good && range;
        a.channel_limits.push_back(range.value_or(rt::ActuatorSpec::Range{}));
      }
    } else if (const auto range = range_in(*node)) {
      a.min = range->min;
      a.max = range->max;
    } else {
      good = false;
    }
    if (!good)
      r.problem(*node, "limit",
                "[smallest, largest], two numbers in this order, or a list of such, one for each channel");
  } else {
    r.missing("limit", "[smallest, largest]; it is required");
  }
  r.read("rate_per_s", a.rate_per_s, 0.0, 1e9);
  if (!r.has("lease_ms")) r.missing("lease_ms", "a number from 0.1 to 10000; it is required");
  r.read_time("lease_ms", a.lease, kMs, 100us, 10s);
  using Safe = rt::ActuatorSpec::Safe;
  r.read_choice<Safe>(
      "safe", a.safe,
      {{"stop", Safe::stop}, {"hold", Safe::hold}, {"damp", Safe::damp}, {"torque_off", Safe::torque_off}});
  graph.actuators.push_back(std::move(a));
}

/// Reads which of the three kinds a condition has, and the keys of that kind.
void read_failsafe_kind(TomlReader& r, rt::FailsafeSpec& f) {
  using Kind = rt::FailsafeSpec::Kind;
  if (r.read_time("silent_ms", f.time, kMs, 1ms, kLongest)) f.kind = Kind::silent;
  if (r.read_time("stuck_ms", f.time, kMs, 1ms, kLongest)) f.kind = Kind::stuck;
  if (r.read("field", f.field.value, "the name of a number in the message, e.g. \"voltage_v\"")) {
    f.kind = Kind::value;
    f.field.line = line_of(*r.raw().get("field"));
    double limit = 0;
    if (r.read("below", limit, -1e300, 1e300)) f.below = limit;
    if (r.read("above", limit, -1e300, 1e300)) f.above = limit;
    r.read_time("for_ms", f.time, kMs, 0ns, kLongest);
  }
  if (r.has("silent_ms") + r.has("stuck_ms") + r.has("field") != 1)
    r.problems().push_back({r.line(), r.path(), "", "exactly one of silent_ms, stuck_ms, field (with below or above)"});
}

void read_failsafe(TomlReader& r, rt::GraphSpec& graph) {
  using msg::FailsafeAction;
  rt::FailsafeSpec f;
  f.line = r.line();
  r.require("name", f.name);
  r.require("topic", f.topic.value, "the name of a topic; it is required");
  if (const toml::node* node = r.raw().get("topic")) f.topic.line = line_of(*node);
  read_failsafe_kind(r, f);
  if (!r.has("action")) r.missing("action", "one of land stop; it is required");
  r.read_choice<FailsafeAction>("action", f.action, {{"land", FailsafeAction::land}, {"stop", FailsafeAction::stop}});
  auto then = FailsafeAction::none;
  rt::Duration after{};
  const bool has_then = r.read_choice<FailsafeAction>("then", then, {{"stop", FailsafeAction::stop}});
  if (r.read_time("then_after_ms", after, kMs, 0ns, kLongest) && has_then) f.stop_after = after;
  if (r.has("then") != r.has("then_after_ms"))
    r.problems().push_back({f.line, r.path(), "", "then and then_after_ms together, or neither"});
  graph.failsafes.push_back(std::move(f));
}

void read_guardian(TomlReader& r, rt::GuardianSpec& guardian) {
  using Arming = rt::GuardianSpec::Arming;
  std::int64_t priority = guardian.priority;
  r.read("priority", priority, 1, 99);
  guardian.priority = static_cast<int>(priority);
  guardian.line = r.line();
  r.read_choice<Arming>("arming", guardian.arming, {{"auto", Arming::automatic}, {"manual", Arming::manual}});
  r.read("cpus", guardian.cpus, 0, 1023);
  read_exec(r, guardian.exec);
}

void read_chain(TomlReader& r, rt::GraphSpec& graph) {
  rt::ChainSpec c;
  c.line = r.line();
  r.require("name", c.name);
  for (auto [key, target] : {std::pair{"from", &c.from}, std::pair{"to", &c.to}}) {
    r.require(key, target->value, "the name of a topic; it is required");
    if (const toml::node* node = r.raw().get(key)) target->line = line_of(*node);
  }
  r.read_time("budget_ms", c.budget, kMs, 1us, kLongest);
  r.read("allowed_misses", c.allowed_misses, 0.0, 1.0);
  graph.chains.push_back(std::move(c));
}

// Other programs find the robot by its name (tap::Name).
constexpr std::size_t kLongestName = 40;
bool in_robot_name(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
}

void read_robot(TomlReader& r, RobotFile& robot) {
  rt::GraphSpec& graph = robot.graph;
  r.require("name", graph.robot);
  constexpr const char* kBoards = "\"sim\", \"linux\", \"dataset\" or \"none\"";
  const std::vector<std::string> boards{"sim", "linux", "dataset", "none"};
  r.require("board", graph.board, std::string(kBoards) + "; it is required");
  if (!std::all_of(graph.robot.begin(), graph.robot.end(), in_robot_name) || graph.robot.size() > kLongestName)
    r.problem(*r.raw().get("name"), "name", "letters, digits, _ and -, at most 40");
  const toml::node* named = r.raw().get("board");
  if (named) graph.board_line = line_of(*named);
  if (named && named->is_string() && std::find(boards.begin(), boards.end(), graph.board) == boards.end())
    r.problem(*named, "board", kBoards + hal::did_you_mean(graph.board, boards));
  std::int64_t number = 0;
  if (r.read("seed", number, 0, INT64_MAX)) graph.seed = static_cast<std::uint64_t>(number);
  if (r.read("virtual_cores", number, 1, 64)) graph.virtual_cores = static_cast<std::uint32_t>(number);
  if (r.read("calibration", robot.calibration.value, "the path of a calibration file"))
    robot.calibration.line = line_of(*r.raw().get("calibration"));
  r.read_time("tap_history_ms", graph.tap_history, kMs, rt::Duration{0}, kLongestHistory);
  r.table("device_boards", [&](TomlReader& d) {
    for (const auto& [device, node] : d.raw()) {
      rt::Located<std::string> board;
      if (d.read(device.str(), board.value, "the name of a board")) {
        board.line = line_of(node);
        graph.device_boards.emplace(std::string(device.str()), std::move(board));
      }
    }
  });
}

void read_bounds(TomlReader& r, ValidityBounds& b) {
  constexpr double kMost = 1e6;
  r.read("plant_gap_ms", b.plant_gap_ms, 0.0, kMost);
  r.read("arrival_gap_ms", b.arrival_gap_ms, 0.0, kMost);
  r.read("late_ms", b.late_ms, 0.0, kMost);
  r.read("late_percent", b.late_percent, 0.0, 100.0);
  r.read("lost", b.lost, 0, INT64_C(1'000'000'000));
  r.read("frames_late_percent", b.frames_late_percent, 0.0, 100.0);
  r.read("commands_dropped", b.commands_dropped, 0, INT64_C(1'000'000'000));
  r.read("missed_percent", b.missed_percent, 0.0, 100.0);
  r.read("clock_ms", b.clock_ms, 0.0, kMost);
  r.read("drift_ppm", b.drift_ppm, 0.0, 1000.0);
  r.read("link_down_ms", b.link_down_ms, 0.0, kMost);
}

void read_sim(TomlReader& r, SimTable& sim) {
  constexpr const char* kPlants = "\"auto\", \"unix:PATH\" or \"tcp:HOST:PORT\"";
  if (r.read("plant", sim.plant, kPlants) && sim.plant != "auto" && !sim.plant.starts_with("unix:") &&
      !sim.plant.starts_with("tcp:"))
    r.problem(*r.raw().get("plant"), "plant", kPlants);
  std::int64_t number = 0;
  const std::vector<std::string> names = robots::world_names();
  const std::string worlds = "the name of a world of sinew-sim: " + hal::quoted(names);
  if (r.read("world", sim.world, worlds) && !robots::find_world(sim.world))
    r.problem(*r.raw().get("world"), "world", worlds + hal::did_you_mean(sim.world, names));
  for (const char* key : {"camera_width", "camera_height"})
    if (const toml::node* node = r.raw().get(key); node && !sim.camera_line) sim.camera_line = line_of(*node);
  if (r.read("camera_width", number, 16, msg::kMaxImageWidth)) sim.camera_width = static_cast<std::uint32_t>(number);
  if (r.read("camera_height", number, 16, msg::kMaxImageHeight)) sim.camera_height = static_cast<std::uint32_t>(number);
  r.read("relink_s", sim.relink_s, 0.0, 3600.0);
  read_world_options(r, sim);
  r.table("bounds", [&](TomlReader& b) { read_bounds(b, sim.bounds); });
}

void read_parent(TomlReader& r, const rt::GraphSpec& graph, ParentOptions& parent) {
  const auto shortest = shortest_hang(graph);
  if (r.read_time("hang_ms", parent.hang, kMs, 20ms, 60s) && parent.hang < shortest)
    r.problem(*r.raw().get("hang_ms"), "hang_ms",
              "at least two of the smallest lease: " + std::to_string(shortest / 1ms) + " or more");
  r.read("watchdog", parent.watchdog, "the path of a watchdog device");
  r.read_time("watchdog_timeout_ms", parent.watchdog_timeout, kMs, 1s, 600s);
  r.read("save_to", parent.save_to, "the path of a folder");
}

void read_record(TomlReader& r, RecordOptions& record) {
  constexpr double kMost = 1e6;
  r.read("enabled", record.enabled);
  r.read("folder", record.folder, "the path of a folder");
  r.read_names("topics", record.topics);
  r.read_names("threads", record.threads);
  r.table("rate_hz", [&](TomlReader& rates) {
    for (const auto& [topic, node] : rates.raw()) {
      rt::Located<double> rate;
      rate.line = line_of(node);
      if (rates.read(topic.str(), rate.value, 0.001, kMost)) record.rate_hz.emplace(std::string(topic.str()), rate);
    }
  });
  r.read("pixel_mb_per_s", record.pixel_mb_per_s, 0.0, kMost);
  r.read_choice<record::Compression>(
      "compression", record.compression,
      {{"lz4", record::Compression::lz4}, {"zstd", record::Compression::zstd}, {"none", record::Compression::none}});
  r.read("split_mb", record.split_mb, 0.0, kMost);
  r.read("split_s", record.split_s, 0.0, kMost);
  r.read("free_floor_mb", record.free_floor_mb, 0.0, kMost);
  r.read("buffer_mb", record.buffer_mb, 0.0, 4000.0);
  record.ring.enabled = r.has("ring");
  r.table("ring", [&](TomlReader& ring) {
    ring.read("seconds", record.ring.seconds, 0.1, 3600.0);
    ring.read("megabytes", record.ring.megabytes, 2.0, 1000.0);
  });
}

/// Modules that have to know the body of the robot are made with it.
void give_body(RobotFile& robot) {
  if (!robot.body.body) return;
  for (rt::ModuleSpec& m : robot.graph.modules)
    for (const robots::RobotKind& kind : robots::all_robots())
      for (const robots::BodyModule& known : kind.body_modules)
        if (known.type == m.type) m.make = [make = known.make, body = robot.body] { return make(body); };
}

}  // namespace

LinePlace RobotFile::place_of(int line) const {
  const bool elsewhere = line > 0 && static_cast<std::size_t>(line) <= places.size();
  return elsewhere ? places[static_cast<std::size_t>(line) - 1] : LinePlace{path, line};
}

std::string to_string(const rt::Problem& problem, const RobotFile& robot) {
  const LinePlace at = robot.place_of(problem.line);
  return rt::to_string({at.line, problem.key, problem.value, problem.allowed}, at.file);
}

LoadedRobot parse_robot(std::string_view text, const std::string& path) {
  LoadedRobot loaded;
  loaded.robot.path = path;
  const auto parsed = parse_toml(text, path, loaded.problems);
  if (!parsed) return loaded;
  loaded.parsed = true;
  rt::GraphSpec& graph = loaded.robot.graph;
  TomlReader root(*parsed, "", loaded.problems);
  if (!root.has("robot")) root.missing("robot", "a table with name and board; it is required");
  root.table("robot", [&](TomlReader& r) { read_robot(r, loaded.robot); });
  root.array_of_tables("thread", [&](TomlReader& r) { read_thread(r, graph); });
  root.tables_by_name("module", [&](const std::string& n, TomlReader& r) { read_module(n, r, loaded.robot); });
  root.tables_by_name("topic", [&](const std::string& n, TomlReader& r) { read_topic(n, r, graph); });
  root.tables_by_name("actuator", [&](const std::string& n, TomlReader& r) { read_actuator(n, r, graph); });
  root.array_of_tables("chain", [&](TomlReader& r) { read_chain(r, graph); });
  root.table("guardian", [&](TomlReader& r) { read_guardian(r, graph.guardian); });
  root.array_of_tables("failsafe", [&](TomlReader& r) { read_failsafe(r, graph); });
  root.tables_by_name("bus",
                      [&](const std::string& n, TomlReader& r) { read_device(n, r, loaded.robot.devices.buses); });
  root.tables_by_name("device",
                      [&](const std::string& n, TomlReader& r) { read_device(n, r, loaded.robot.devices.devices); });
  root.table("body", [&](TomlReader& r) {
    if (r.take("extends")) return;  // only a robot that is loaded is read with other files
    kinematics::Body body;
    read_body(r, body);
    r.finish();
    loaded.robot.body.body = std::make_shared<const kinematics::Body>(std::move(body));
  });
  root.table("motions", [&](TomlReader& r) {
    if (r.take("extends")) return;
    if (!loaded.robot.body.body)
      return loaded.problems.push_back({r.line(), "motions", "", "a robot with a body: [body]"});
    motion::MotionBook book;
    read_motions(r, *loaded.robot.body.body, book);
    loaded.robot.body.motions = std::make_shared<const motion::MotionBook>(std::move(book));
  });
  root.table("sim", [&](TomlReader& r) { read_sim(r, loaded.robot.sim); });
  give_body(loaded.robot);
  if (const plant::WorldInfo* world = robots::find_world(loaded.robot.sim.world);
      world && world->of(loaded.robot.sim.options).has_bodies && !root.has("body"))
    root.missing("body",
                 "a table: the robots of the world " + loaded.robot.sim.world + " have bodies (docs/bodies.md)");
  root.table("parent", [&](TomlReader& r) { read_parent(r, graph, loaded.robot.parent); });
  root.table("record", [&](TomlReader& r) { read_record(r, loaded.robot.record); });
  root.table("team", [&](TomlReader& r) { read_team(r, loaded.robot); });
  root.table("ros2", [&](TomlReader& r) { read_ros2(r, loaded.robot); });
  root.table("net", [&](TomlReader& r) { read_net(r, loaded.robot); });
  root.finish();
  std::stable_sort(graph.modules.begin(), graph.modules.end(),
                   [](const auto& a, const auto& b) { return a.line < b.line; });  // toml++ sorts tables by name
  add_team(loaded.robot, loaded.problems);
  add_net(loaded.robot, loaded.problems);
  return loaded;
}

void add_graph_problems(LoadedRobot& loaded, const rt::ModuleTypes& types, const rt::CheckOptions& options) {
  if (!loaded.parsed) return;
  // A problem of the graph repeats a problem of form if its key equals, contains or lies within the key of wrong form.
  const auto within = [](const std::string& key, const std::string& of) {
    return key == of || (key.starts_with(of) && key[of.size()] == '.');
  };
  const std::vector<rt::Problem> form = loaded.problems;
  for (rt::Problem& p : rt::Graph(loaded.robot.graph, types).check(options)) {
    const bool follows = std::any_of(
        form.begin(), form.end(), [&](const rt::Problem& f) { return within(p.key, f.key) || within(f.key, p.key); });
    if (!follows) loaded.problems.push_back(std::move(p));
  }
  std::stable_sort(loaded.problems.begin(), loaded.problems.end(),
                   [](const rt::Problem& a, const rt::Problem& b) { return a.line < b.line; });
}

std::string section_header(std::string_view section) {
  const auto is_one_of = [&](std::initializer_list<std::string_view> all) {
    return std::find(all.begin(), all.end(), section) != all.end();
  };
  const std::string name(section);
  if (is_one_of({"robot", "body", "motions", "guardian", "sim", "parent", "record", "team", "ros2", "net"}))
    return "[" + name + "]";
  if (is_one_of({"thread", "chain", "failsafe"})) return "[[" + name + "]]";
  if (is_one_of({"topic", "actuator", "device", "bus"})) return "[" + name + ".NAME]";
  return {};
}

LoadedRobot load_robot(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  if (std::error_code none; !in || std::filesystem::is_directory(path, none)) {
    LoadedRobot loaded;
    loaded.robot.path = path;
    loaded.readable = false;
    loaded.problems.push_back({0, "file", path, "a robot file that can be read"});
    return loaded;
  }
  const std::string text((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  ResolvedRobot resolved = resolve_robot(text, path);
  LoadedRobot loaded;
  if (resolved.problems.empty()) {
    loaded = parse_robot(resolved.text, path);
    loaded.robot.text = std::move(resolved.text);
    loaded.robot.extended = resolved.extended;
  } else {
    loaded.robot.path = path;
    loaded.problems = std::move(resolved.problems);
  }
  loaded.robot.places = std::move(resolved.places);
  for (rt::Problem& p : resolved.ini_problems) loaded.problems.push_back(std::move(p));
  read_networks(loaded.robot);
  const plant::WorldInfo* const world = robots::find_world(loaded.robot.sim.world);
  if (loaded.robot.body.body && world && world->of(loaded.robot.sim.options).has_bodies)
    loaded.robot.sim.body_file = path;
  return loaded;
}

}  // namespace sinew::app
