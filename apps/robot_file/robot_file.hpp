#pragma once
// Robot files: TOML to rt::GraphSpec, with every problem named at once.
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "apps/robot_file/extends.hpp"
#include "apps/robot_file/parent_options.hpp"
#include "apps/robot_file/record_options.hpp"
#include "apps/robot_file/validity.hpp"
#include "drivers/device_spec.hpp"
#include "net/ros2/bridge_spec.hpp"
#include "policy/plan.hpp"
#include "robots/robot_kind.hpp"
#include "rt/graph.hpp"
#include "team/link.hpp"

namespace sinew::app {

/// How the sim board reaches its plant.
struct SimTable {
  std::string plant = "auto";  // "auto": start sinew-sim; else "unix:PATH" or "tcp:HOST:PORT"
  std::string world = "quad";  // of a plant that is started
  std::uint32_t camera_width = 320, camera_height = 240;
  int camera_line = 0;
  double relink_s = 10;                                  // real time: how long a lost plant is looked for
  std::optional<std::uint64_t> seed{};                   // of the world; none: the robot's
  std::map<std::string, double, std::less<>> options{};  // of the world, by key (plant::WorldOption)
  std::string body_file{};  // that has the robot's body, where the world's robots have one; set by load_robot()
  ValidityBounds bounds;
};

/// `[team]`: what the robot says to mates and hears from them.
struct TeamTable {
  int line = 0;
  team::LinkOptions link{};
  std::map<std::string, int> said_lines{};  // by topic
  std::string device{};                     // of the radio; empty: "radio"
  rt::ExecModel exec{};
};

/// `[net]`: of the program `sinew net` beside the robot, which has DDS (docs/net.md).
struct NetTable {
  int line = 0;
  std::uint32_t domain = 0;
  std::vector<std::string> interfaces{};  // names or IPv4 addresses; empty: the one that Cyclone DDS finds best
  bool multicast = true;                  // false: only `peers` are looked for
  std::vector<std::string> peers{};       // "10.0.0.2", "10.0.0.2:7410"
  std::uint32_t most_on_a_machine = 32;   // participants of a machine that can be found by unicast
  std::string extra{};                    // elements in Cyclone's words
  /// Paths of files, from the working directory; all or none.
  std::string identity_ca{}, certificate{}, private_key{}, permissions_ca{}, governance{}, permissions{};
  bool secure() const { return !identity_ca.empty(); }
};

/// A module policy::Policy: its tables, and its network's file, which all modules that are made of it share.
struct PolicyTable {
  policy::PolicyOptions options;
  std::shared_ptr<policy::PolicyFile> file;  // without bytes until read_networks(), or until a recording gives them
};

struct RobotFile {
  std::string path;
  std::string text{};     // as it was read, with all that it extends; only from load_robot()
  bool extended = false;  // `text` is not the file's own
  std::vector<LinePlace>
      places{};  // of the lines of `text`, as ResolvedRobot has them; behind them those of other files
  rt::GraphSpec graph;
  SimTable sim;
  ParentOptions parent;
  RecordOptions record;
  std::vector<PolicyTable> policies{};
  std::optional<TeamTable> team{};
  std::optional<ros2::BridgeSpec> ros2{};
  std::optional<NetTable> net{};
  robots::RobotBody body{};              // [body] and [motions] (docs/bodies.md, docs/walking.md)
  drivers::DeviceSpecs devices;          // of the board `linux`
  rt::Located<std::string> calibration;  // file of what differs from one such robot to the next; empty: none

  /// File and line where somebody wrote what a problem with this robot names as `line`.
  LinePlace place_of(int line) const;
};

/// rt::to_string() with the file and line where the key stands: of a robot that extends another file, often that one.
std::string to_string(const rt::Problem& problem, const RobotFile& robot);

struct LoadedRobot {
  RobotFile robot;
  // Of form only (keys, types, ranges of the file); rt::Graph::check() does the rest.
  std::vector<rt::Problem> problems{};
  bool readable = true;  // the file could be read at all
  bool parsed = false;   // and is TOML
};

/// Adds the problems that rt::Graph::check() finds in the graph as read, without those that follow from problems of
/// form.
void add_graph_problems(LoadedRobot& loaded, const rt::ModuleTypes& types, const rt::CheckOptions& options);

/// Reads the text of a robot file, and no other file: networks of policies come with load_robot(). Never stops at the
/// first problem, except for TOML that does not parse.
/// Source:  docs/robot-file.md lists all keys.
LoadedRobot parse_robot(std::string_view text, const std::string& path);

/// The header of the keys of `section` in a robot file: "[guardian]", "[[thread]]", "[actuator.NAME]". Empty: there is
/// no such section, or it is `module`.
std::string section_header(std::string_view section);

/// Reads a robot file from disk, with the networks that it names; a file that cannot be read is one problem.
LoadedRobot load_robot(const std::string& path);

}  // namespace sinew::app
