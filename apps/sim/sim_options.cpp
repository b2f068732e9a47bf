#include "apps/sim/sim_options.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <cstdio>
#include <map>
#include <ranges>

#include "apps/command/choice_check.hpp"
#include "apps/command/number_check.hpp"
#include "apps/command/usage_error.hpp"
#include "apps/toml/body_reader.hpp"
#include "hal/platform.hpp"
#include "hal/stream.hpp"
#include "robots/robot_kind.hpp"
#include "robots/spark/world/spark_plant.hpp"

namespace sinew::plant {
namespace {

/// "640x480"; an empty text when it is one.
std::string check_size(const std::string& text) {
  unsigned w = 0, h = 0;
  char rest = 0;
  if (std::sscanf(text.c_str(), "%ux%u%c", &w, &h, &rest) == 2 && w >= 16 && h >= 16 && w <= msg::kMaxImageWidth &&
      h <= msg::kMaxImageHeight && w % 2 == 0)
    return "";
  return "'" + text + "' is not WIDTHxHEIGHT with an even width of 16..1280 and a height of 16..960";
}

/// Of --serve; an empty text when it is one.
std::string check_protocol(const std::string& text) {
  if (text == "sinew" || text == "usarsim" || !SimsparkOptions::listen_of(text).empty()) return "";
  return "'" + text + "' is no protocol; there are sinew, usarsim, simspark and simspark:PORT";
}

/// Values as they were given, by WorldOption::option; with several robots also "ROBOT=VALUE".
using GivenOptions = std::map<std::string, std::vector<std::string>>;

struct OptionHelp {
  std::string option, text;
};

/// Of all worlds, by name: what --help says of them.
std::vector<OptionHelp> world_options() {
  std::vector<OptionHelp> all;
  for (const auto& type : robots::all_worlds())
    for (const WorldOption& o : type->info.options) {
      std::string text = fmt::format("{}: {}", type->info.name, o.doc);
      text += o.value ? fmt::format(" [{}]", *o.value) : fmt::format(" [{}]", o.otherwise);
      text += ", " + o.allowed();
      if (o.per_robot) text += "; with several robots also ROBOT=VALUE";
      const auto same = std::ranges::find(all, o.option, &OptionHelp::option);
      if (same == all.end())
        all.push_back({o.option, text});
      else
        same->text += "; " + text;
    }
  return all;
}

/// "ROBOT" of "ROBOT=VALUE" and "ROBOT/FAULT", cut off; null: there is none, or no such robot, which `why` then says.
NamedRobot* cut_robot(std::string& text, char sign, WorldChoice& world, std::string& why) {
  const auto at = text.find(sign);
  if (at == std::string::npos) return nullptr;
  const std::string name = text.substr(0, at);
  const auto robot = std::ranges::find(world.robots, name, &NamedRobot::name);
  if (robot == world.robots.end()) {
    std::string known;
    for (const NamedRobot& r : world.robots) known += (known.empty() ? "" : ", ") + r.name;
    why =
        fmt::format("'{}': no robot '{}'; {}", text, name, known.empty() ? "--robot names them" : "there are " + known);
    return nullptr;
  }
  text.erase(0, at + 1);
  return &*robot;
}

/// Gives the options to the world; an empty text, or what is wrong.
std::string read_world_options(const GivenOptions& given, WorldChoice& world) {
  for (const auto& one : given) {  // a lambda takes no structured binding
    const std::string& name = one.first;
    const auto is_it = [&](const WorldOption& o) { return name == o.option; };
    const auto own = std::ranges::find_if(world.type->info.options, is_it);
    if (own == world.type->info.options.end()) {
      std::string worlds;
      for (const auto& type : robots::all_worlds())
        if (std::ranges::any_of(type->info.options, is_it))
          worlds += (worlds.empty() ? "" : ", ") + std::string(type->info.name);
      return fmt::format("--{}: only of the world {}", name, worlds);
    }
    for (std::string text : one.second) {
      std::string why;
      NamedRobot* const robot = cut_robot(text, '=', world, why);
      if (!why.empty()) return fmt::format("--{}: {}", name, why);
      if (robot && !own->per_robot)
        return fmt::format("--{}: the robots share it: a value, without '{}='", name, robot->name);
      double number = 0;
      const auto end = text.data() + text.size();
      const auto read = std::from_chars(text.data(), end, number);
      if (read.ec != std::errc() || read.ptr != end || !own->allows(number))
        return fmt::format("--{}: {}: {}", name, text, own->allowed());
      (robot ? robot->values : world.values)[own->key] = number;
    }
  }
  return "";
}

/// Gives the names to the world; an empty text, or what is wrong.
std::string read_robots(const std::vector<std::string>& names, WorldChoice& world) {
  const std::size_t most = world.type->info.most_robots;
  if (names.size() > most)
    return fmt::format("--robot: the world {} has room for {} robot{}, not {}", world.type->info.name, most,
                       most == 1 ? "" : "s", names.size());
  for (const std::string& name : names) {
    if (!sim_hil::is_name(name))
      return fmt::format("--robot: '{}': a name of letters, digits, '_', '-' and '.', at most 31 long", name);
    if (std::ranges::find(world.robots, name, &NamedRobot::name) != world.robots.end())
      return fmt::format("--robot: '{}' is there already: each robot has its own name", name);
    world.robots.push_back({name});
  }
  return "";
}

/// Reads the bodies of the robots; an empty text, or what is wrong.
std::string read_bodies(const std::vector<std::string>& files, WorldChoice& world) {
  if (!world.type->info.has_bodies)
    return files.empty() ? "" : fmt::format("--body: robots of the world {} are as they are", world.type->info.name);
  for (std::string file : files) {
    const auto names_it = [&](const NamedRobot& r) { return file.starts_with(r.name + "="); };
    const auto robot = std::ranges::find_if(world.robots, names_it);
    if (robot != world.robots.end()) file.erase(0, robot->name.size() + 1);
    app::LoadedBody loaded = app::load_body(file);
    if (!loaded.problems.empty()) return "--body: " + rt::to_string(loaded.problems[0], file);
    (robot == world.robots.end() ? world.body : robot->body) =
        std::make_shared<const kinematics::Body>(std::move(loaded.body));
  }
  for (std::size_t i = 0; i < world.robot_count(); ++i)
    if (world.info_of(i).has_bodies && !world.body_of(i))
      return fmt::format("--body: which body has {}? A file of docs/bodies.md, or a robot file that has one",
                         world.robots.empty() ? "the robot" : world.robots[i].name);
  return "";
}

void describe(CLI::App& app, SimulatorOptions& s, std::vector<std::string>& robot_names,
              std::vector<std::string>& bodies, std::vector<std::string>& faults, GivenOptions& given) {
  app.add_option("--listen", s.listen, "unix:PATH or tcp:HOST:PORT; port 0: the system chooses")->capture_default_str();
  app.add_option("--serve", s.serve,
                 "the protocol: Sinew's own (sinew), or that of USARSim (usarsim, docs/usarsim.md) or of "
                 "SimSpark (simspark or simspark:PORT, docs/simspark.md)")
      ->check(check_protocol)
      ->capture_default_str();
  auto* lockstep = app.add_flag("--lockstep", s.lockstep, "serve only runtimes that ask for lockstep");
  app.add_flag("--free", s.free_running, "serve only runtimes that ask for real time")->excludes(lockstep);
  std::vector<std::string> names;
  std::string titles = "which world:";
  for (const auto& type : robots::all_worlds()) {
    names.emplace_back(type->info.name);
    titles += (names.size() > 1 ? ", " : " ") + names.back() + " (" + type->title + ")";
  }
  app.add_option("--world", s.world, titles)->check(app::one_of(names))->capture_default_str();
  app.add_option(
         "--robot", robot_names,
         "name of a robot that the world waits for, as its runtime says it; once for each of several that share "
         "the world (default: one, of any name)")
      ->allow_extra_args(false);
  app.add_option("--body", bodies,
                 "file of its robots' body (docs/bodies.md), or a robot file that has one; with several robots also "
                 "ROBOT=FILE")
      ->allow_extra_args(false)
      ->type_name("FILE");
  app.add_option("--simspark", s.simspark_peer,
                 "world simspark: the server that the robot plays in, and its team: HOST:PORT or HOST:PORT/TEAM")
      ->type_name("SERVER");
  app.add_option("--seed", s.session.seed, "start, wind, spread and noise (default: what the runtime asks for)")
      ->check(app::whole())
      ->type_name("N");
  app.add_option("--camera", s.camera, "size of the camera's frames")->check(check_size)->capture_default_str();
  app.add_option("--format", s.format, "format of its pixels")
      ->check(app::one_of({"yuyv", "rgb8", "mono8"}))
      ->capture_default_str();
  app.add_option("--camera-noise", s.view.noise, "sigma of the pixels, grey levels")
      ->check(CLI::Range(0.0, 20.0))
      ->capture_default_str();
  for (const OptionHelp& o : world_options())
    app.add_option_function<std::vector<std::string>>(
           "--" + o.option, [&given, name = o.option](const std::vector<std::string>& texts) { given[name] = texts; },
           o.text)
        ->allow_extra_args(false)
        ->type_name("FLOAT");
  app.add_option(
         "--fault", faults,
         "[ROBOT/]DEVICE:KIND[(AMOUNT)]@FROM[+LENGTH|..UNTIL], e.g. imu:stuck@5+0.5; may be repeated; ROBOT where the "
         "world has several, else the first")
      ->allow_extra_args(false);
  app.add_flag("--list-faults", s.list_faults,
               "print every kind of fault for every device, and why some are not possible");
  s.wire.describe(app);
  s.usarsim.describe(app);
  s.simspark.describe(app);
  s.game.describe(app);
  app.add_flag(
      "--alone", s.alone,
      "real time: no runtime connects; the world begins at once, with its devices at the wire, until --duration "
      "is over or a signal comes");
  app.add_option("--report", s.reports,
                 "write the last report (JSON, one line) into this file, or - to standard output; may be repeated")
      ->allow_extra_args(false);
  app.add_option("--duration", s.session.duration_s, "end the run after so many seconds of plant time; 0: never")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  app.add_option("--priority", s.session.fifo_priority,
                 "SCHED_FIFO priority of the physics thread in real time; 0: none")
      ->check(CLI::Range(0, 99))
      ->capture_default_str();
  app.add_option("--relink", s.session.relink_s,
                 "real time: when the runtime is lost, the world waits so many seconds for another; 0: it ends")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  app.add_option("--wait", s.wait_s, "give up when no runtime has come after so many seconds")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_option("--scenes", s.scenes,
                 "take down into this new file (MCAP) what each picture depends on, so that --redraw can draw it again")
      ->type_name("FILE");
  CLI::Option& redraw = *app.add_option("--redraw", s.redraw.file,
                                        "draw the pictures of a file of --scenes again, in place of running a world")
                             ->type_name("FILE");
  CLI::Option& of = *app.add_option("--of", s.redraw.of,
                                    "all pictures of this robot, to standard output: for each a line DEVICE NUMBER "
                                    "BYTES, then its pixels")
                         ->needs(&redraw)
                         ->type_name("ROBOT");
  app.add_option("--window", s.redraw.window_s, "with --of: FROM,UNTIL, only pictures of this plant time, s")
      ->delimiter(',')
      ->expected(2)
      ->needs(&of)
      ->type_name("FROM,UNTIL");
  app.add_option("--mcap", s.redraw.mcap, "with --of: a new file for the pictures, in place of standard output")
      ->needs(&of)
      ->type_name("FILE");
  app.add_option("--at", s.redraw.at_s, "pictures from outside at these seconds of plant time")
      ->delimiter(',')
      ->needs(&redraw)
      ->excludes(&of)
      ->type_name("S");
  app.add_option("--png", s.redraw.folder, "with --at: the folder of the pictures")->needs(&redraw)->type_name("DIR");
  app.add_option("--eye", s.redraw.eye_m, "with --at: X,Y,Z of the viewer, m")
      ->delimiter(',')
      ->expected(3)
      ->needs(&redraw)
      ->type_name("X,Y,Z");
  app.add_option("--target", s.redraw.target_m, "with --at: X,Y,Z that it looks at, m")
      ->delimiter(',')
      ->expected(3)
      ->needs(&redraw)
      ->type_name("X,Y,Z");
  app.add_option("--render-test", s.render_test,
                 "write pictures of the world into this folder, time a frame, and exit");
}

/// The same with --serve usarsim and simspark: clients bring the robots, and nothing of the own protocol is there.
std::string useless_behind_door(const CLI::App& app, const std::string& serve) {
  for (const char* option :
       {"--robot", "--lockstep", "--free", "--wait", "--relink", "--alone", "--can", "--serial", "--servo", "--iio",
        "--v4l2", "--fault", "--list-faults", "--priority", "--format", "--gamecontroller"})
    if (app.count(option) > 0) return fmt::format("{}: not with --serve {}", option, serve);
  return "";
}

/// Where the world simspark finds its server; an empty text, or what is wrong.
std::string read_simspark_peer(SimulatorOptions& s) {
  constexpr const char* kWorld = "simspark";
  if (s.world != kWorld) return s.simspark_peer.empty() ? "" : "--simspark: only of the world simspark";
  if (s.list_faults) return "";
  if (s.simspark_peer.empty()) return "--world simspark: needs --simspark HOST:PORT, the server that it plays in";
  const auto slash = s.simspark_peer.find('/');
  const std::string place = s.simspark_peer.substr(0, slash);
  const std::string team = slash == std::string::npos ? "Sinew" : s.simspark_peer.substr(slash + 1);
  const bool named = !team.empty() && team.size() <= 32 && team.find_first_of(" ()") == std::string::npos;
  if (place.find(':') == std::string::npos || !named)
    return fmt::format("--simspark: '{}' is not HOST:PORT or HOST:PORT/TEAM; a team has 1 to 32 letters",
                       s.simspark_peer);
  constexpr hal::Duration kPatience = std::chrono::seconds(5);
  const auto connect = [place] { return hal::connect_stream("tcp:" + place, kPatience); };
  s.session.world.type = spark_world_in(*s.session.world.type, {connect, team});
  s.session.only = sim_hil::Mode::lockstep;  // its cycles are the robot's time
  return "";
}

/// What --redraw lacks, or has no use for; an empty text: nothing.
std::string useless_in_redraw(const CLI::App& app, const RedrawOptions& redraw) {
  if (redraw.of.empty() == redraw.at_s.empty()) return "--redraw: needs --of or --at, which say what is drawn";
  if (!redraw.at_s.empty() && redraw.folder.empty()) return "--at: needs --png, the folder of the pictures";
  for (const CLI::Option* option : app.get_options())
    if (option->count() > 0 && !RedrawOptions::has(option->get_name()))
      return fmt::format("{}: not with --redraw, which takes the world from its file", option->get_name());
  return "";
}

/// Why an option has no meaning in this world, this mode, or this way of running. An empty text: all have one.
std::string useless(const CLI::App& app, const SimulatorOptions& s) {
  struct Only {
    const char* option;
    bool useful;
    const char* where;
  };
  const bool lockstep = s.session.only == sim_hil::Mode::lockstep;
  if (!s.scenes.empty() && !s.view.painter)
    return fmt::format("--scenes: the pictures of the world {} are drawn by OpenGL, and cannot be drawn again alike",
                       s.world);
  if (!s.scenes.empty() && !s.session.seed) return "--scenes: needs --seed, which is part of the pictures' noise";
  if (!s.scenes.empty() && (s.alone || s.wire.any())) return "--scenes: not with devices at the wire";
  const Only onlys[] = {
      {"--listen", !s.alone, "only for a runtime; with --alone none connects"},
      {"--wait", !s.alone, "only for a runtime; with --alone none connects"},
      {"--relink", !s.alone && !lockstep, "only for runtimes in real time; not with --alone, not with --lockstep"},
      {"--free", !s.alone, "only for a runtime; with --alone none connects"},
      {"--lockstep", !s.alone, "only for a runtime; with --alone none connects, and the world is in real time"},
      {"--can", !lockstep, "in real time only, not with --lockstep"},
      {"--serial", !lockstep, "in real time only, not with --lockstep"},
      {"--iio", !lockstep, "in real time only, not with --lockstep"},
      {"--v4l2", !lockstep, "in real time only, not with --lockstep"},
      {"--gamecontroller", !s.alone, "only for a world with runtimes, not with --alone"},
  };
  if (const char* option = UsarsimOptions::given(app); option && s.serve != "usarsim")
    return fmt::format("{}: only with --serve usarsim", option);
  if (const char* option = SimsparkOptions::given(app); option && !s.serves_simspark())
    return fmt::format("{}: only with --serve simspark", option);
  if (s.serve != "sinew") return useless_behind_door(app, s.serve);
  for (const Only& only : onlys)
    if (app.count(only.option) > 0 && !only.useful) return fmt::format("{}: {}", only.option, only.where);
  if (s.session.world.robots.size() > 1 && (s.alone || s.wire.any()))
    return "--robot: devices at the wire and --alone are for a world of one robot";
  return s.alone && !s.wire.any() ? "--alone: nobody reaches a world without --can, --serial, --iio or --v4l2" : "";
}

/// Reads --serial; an empty text, or what is wrong.
std::string read_lines(SimulatorOptions& s) {
  std::string why;
  for (const std::string& text : s.wire.serial) {
    const auto line = parse_wire_line(text, why);
    if (!line) return "--serial: " + why;
    if (std::ranges::find(s.lines, line->path, &WireLineSpec::path) != s.lines.end())
      return fmt::format("--serial: '{}': another line has this path", text);
    s.lines.push_back(*line);
  }
  return "";
}

/// What one --servo needs besides itself; an empty text when it is there.
std::string check_place(const SimulatorOptions& s, const std::string& text, const WireServo& servo) {
  if (servo.on_line() && servo.line >= s.lines.size())
    return fmt::format("--servo: '{}' is on line {}, and there {}: each --serial makes one", text, servo.line + 1,
                       s.lines.size() == 1 ? "is 1" : fmt::format("are {}", s.lines.size()));
  if (servo.has_drive() && !servo.on_line() && s.wire.can.empty()) return "--servo: needs --can, which names its bus";
  const auto same =
      std::ranges::find_if(s.servos, [&](const WireServo& o) { return o.shares_bus(servo) && o.id == servo.id; });
  if (same == s.servos.end()) return "";
  return fmt::format("--servo: '{}' has the id {} of '{}': each drive on a bus needs its own id", text, servo.id,
                     s.wire.servos[static_cast<std::size_t>(same - s.servos.begin())]);
}

/// Checks --can, --serial and --servo against the world's joints; an empty text when they fit.
std::string read_servos(SimulatorOptions& s) {
  if (s.wire.can.empty() && s.wire.serial.empty() && s.wire.servos.empty()) return "";
  if (s.wire.can.empty() && s.wire.serial.empty()) return "--servo: needs --can, which names its bus, or --serial";
  const char* const bus = s.wire.can.empty() ? "--serial" : "--can";
  const WorldInfo& world = s.session.world.type->info;
  const WorldDevice* joints = world.find(Part::joints);
  if (!joints) return fmt::format("{}: the world {} has no joints for drives on a bus", bus, world.name);
  if (std::string wrong = read_lines(s); !wrong.empty()) return wrong;
  std::string why;
  for (const std::string& text : s.wire.servos) {
    const auto servo = parse_wire_servo(text, why);
    if (!servo) return "--servo: " + why;
    if (std::string wrong = check_place(s, text, *servo); !wrong.empty()) return wrong;
    s.servos.push_back(*servo);
  }
  if (s.servos.size() != joints->channels)
    return fmt::format(
        "--servo: {} given, but the world {} has {} joints: one for each, 'none' for one without a drive",
        s.servos.size(), world.name, joints->channels);
  const auto on_can = [](const WireServo& servo) { return servo.has_drive() && !servo.on_line(); };
  if (!s.wire.can.empty() && std::ranges::none_of(s.servos, on_can)) return "--can: there is no drive on it";
  for (std::size_t i = 0; i < s.lines.size(); ++i) {
    const auto on_it = [i](const WireServo& servo) { return servo.on_line() && servo.line == i; };
    if (std::ranges::none_of(s.servos, on_it)) return fmt::format("--serial: there is no servo on {}", s.lines[i].path);
    for (const WireLineSpec::Event& event : s.lines[i].events)
      if (event.kind != WireLineSpec::Event::Kind::gone &&
          std::ranges::none_of(s.servos, [&](const WireServo& o) { return on_it(o) && o.id == event.id; }))
        return fmt::format("--serial: no servo on {} has the id {} of its reboot=, off=, overload= or hot=",
                           s.lines[i].path, event.id);
  }
  return "";
}

/// Gives a fault to the device that plays it; an empty text, or why none does.
std::string place_fault(SimulatorOptions& s, const std::string& text, const Fault& fault) {
  const bool servos = !s.servos.empty();
  const auto at_wire = [&](const char* option, const char* how) {
    return fmt::format("--fault: '{}' strikes what goes over the protocol, but {} puts this device at the wire{}", text,
                       option, how);
  };
  if (fault.device == FaultDevice::joints && servos) {
    if (!plays(fault.kind))
      return fmt::format("--fault: '{}': drives at the wire (--servo) play off, stuck and garbage", text);
    s.wire_faults.push_back(fault);
    return "";
  }
  if (fault.device == FaultDevice::head && servos) return at_wire("--servo", "; its drives play joints:off instead");
  if (fault.device == FaultDevice::imu && !s.wire.iio.empty()) return at_wire("--iio", "");
  if (fault.device == FaultDevice::camera && !s.wire.v4l2.empty())
    return at_wire("--v4l2", "; --unplug-camera takes its plug out");
  if (s.alone) return fmt::format("--fault: '{}' strikes what goes to a runtime, and with --alone none connects", text);
  s.session.faults.push_back(fault);
  return "";
}

std::string read_faults(SimulatorOptions& s, const std::vector<std::string>& faults) {
  std::string why;
  for (std::string text : faults) {
    NamedRobot* const robot = cut_robot(text, '/', s.session.world, why);
    if (!why.empty()) return "--fault: " + why;
    auto fault = parse_fault(text, why);
    if (!fault) return "--fault: " + why;
    if (robot) fault->robot = static_cast<std::size_t>(robot - s.session.world.robots.data());
    if (const WorldInfo world = s.session.world.info_of(fault->robot); !world.has(fault->device))
      return fmt::format("--fault: fault '{}': the world {} has no device '{}'", text, world.name,
                         to_string(fault->device));
    if (std::string wrong = place_fault(s, text, *fault); !wrong.empty()) return wrong;
  }
  return "";
}

}  // namespace

int SimulatorOptions::lines_priority() const {
  return session.fifo_priority > 0 ? std::min(session.fifo_priority + 1, 99) : 0;
}

bool read_command_line(int argc, char** argv, SimulatorOptions& s, int& exit_code) {
  CLI::App app(
      "Simulated worlds for Sinew.\n"
      "Waits for the runtime of its robot, or of each of its robots, serves it until it says good-bye, and exits 0 "
      "when\n"
      "it did.",
      "sinew-sim");
  std::vector<std::string> robot_names, bodies, faults;
  GivenOptions given;
  describe(app, s, robot_names, bodies, faults, given);
  s.words.assign(argv + 1, argv + argc);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    exit_code = e.get_exit_code() == 0 ? 0 : kUsage;  // CLI11 has other exit codes
    if (exit_code == 0)
      app.exit(e);  // prints the help
    else
      std::fprintf(stderr, "sinew-sim: %s\n", app::usage_error(app, e).c_str());
    return false;
  }
  if (!s.redraw.file.empty()) {
    const std::string wrong = useless_in_redraw(app, s.redraw);
    if (wrong.empty()) return true;
    std::fprintf(stderr, "sinew-sim: %s\n", wrong.c_str());
    exit_code = kUsage;
    return false;
  }
  if (s.serve == "usarsim") {
    if (app.count("--listen") == 0) s.listen = UsarsimOptions::kListen;
    if (app.count("--world") == 0) s.world = UsarsimOptions::kWorld;
  }
  if (s.serves_simspark()) {
    if (app.count("--listen") == 0) s.listen = SimsparkOptions::listen_of(s.serve);
    if (app.count("--world") == 0) s.world = SimsparkOptions::kWorld;
  }
  std::sscanf(s.camera.c_str(), "%ux%u", &s.view.width, &s.view.height);
  s.view.format = msg::pixel_format_of(s.format);
  s.view.turned_rad = s.wire.camera_turned_rad();
  for (const auto& type : robots::all_worlds())
    if (type->info.name == s.world) s.session.world.type = type;
  if (s.lockstep) s.session.only = sim_hil::Mode::lockstep;
  if (s.free_running) s.session.only = sim_hil::Mode::free_running;
  std::string wrong = read_robots(robot_names, s.session.world);
  s.view.robots = s.session.world.robot_count();
  if (wrong.empty()) wrong = read_world_options(given, s.session.world);
  if (wrong.empty()) wrong = read_simspark_peer(s);
  if (wrong.empty() && !s.list_faults) wrong = read_bodies(bodies, s.session.world);
  s.bodies = bodies;
  s.view.room_xml = s.session.world.type->room(s.session.world.values);
  if (const auto& painter = s.session.world.type->painter)
    s.view.painter = [&] { return painter(s.view.width, s.view.height, s.session.world); };
  if (wrong.empty()) wrong = useless(app, s);
  if (wrong.empty()) wrong = s.game.read(app, s.session.world);
  if (wrong.empty()) wrong = read_servos(s);
  if (wrong.empty()) wrong = read_faults(s, faults);
  if (wrong.empty()) return true;
  std::fprintf(stderr, "sinew-sim: %s\n", wrong.c_str());
  exit_code = kUsage;
  return false;
}

}  // namespace sinew::plant
