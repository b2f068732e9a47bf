#pragma once
// Shared by all ways to run: the robot, its graph, and what is watched from outside.
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "apps/flight/mission_watch.hpp"
#include "apps/robot_file/robot_file.hpp"
#include "apps/run/run_command.hpp"
#include "dataset/dataset_board.hpp"
#include "rt/exec/real_time_executor.hpp"
#include "rt/exec/runner.hpp"
#include "rt/graph.hpp"
#include "rt/module_types.hpp"
#include "tap/names.hpp"
#include "tap/server.hpp"

namespace sinew::app {

/// Options that change the robot. Their values have lines below 0, so that a problem with one is
/// reported as "from --set ...".
class OptionLines {
 public:
  /// The line of what this option says.
  int line_of(std::string option);
  /// rt::to_string(), with the option in place of file and line if the problem is an option's.
  std::string told(const rt::Problem& problem, std::string_view file) const;

 private:
  std::vector<std::string> options_;
};

/// A robot file with the options applied and its graph checked.
struct Prepared {
  RobotFile robot;
  rt::ModuleTypes types;
  std::unique_ptr<rt::Graph> graph;
  std::unique_ptr<tap::Name> name;  // held until the run ends; null: the run has no socket
  OptionLines options{};
};

/// A note that follows the problems of a robot file that extends another.
std::string resolved_note(const std::string& robot);

/// Prints every problem to standard error; empty when there was one.
std::optional<Prepared> prepare(const RunOptions& options, const rt::ModuleTypes& types);

/// Configures its graph on a board; false after printing its problems, each once. `devices`: what boards say of devices
/// that they could not open, one a line. It is printed in place of "not ready" of the modules that use them.
bool configure(const Prepared& prepared, hal::Board& board, const rt::ConfigureOptions& how, const RunOptions& options,
               const std::function<std::string()>& devices = {});

/// The problems of configuring without those that a line of `devices` ("device 'imu' ...: why") explains better.
std::vector<rt::Problem> without_devices(const std::vector<rt::Problem>& problems, const std::string& devices);

/// The recorded folder of --data. `clock` is virtual time's, which then drives the board; null in real time.
std::unique_ptr<dataset::DatasetBoard> open_dataset(const RunOptions& options, const hal::Clock* clock, hal::Os& os,
                                                    std::string& why);

/// --duration as a duration.
rt::Duration run_duration(const RunOptions& options);

/// Options for this machine, with a clock at the rate of the run.
rt::RealTimeOptions real_time_options(const RunOptions& run);

/// Prints what a real-time run did not get. False when `strict` forbids to go on.
bool accept_shortfalls(const std::vector<std::string>& shortfalls, bool strict);

/// Applies "module.param=value"; returns the reason on failure. `line`: of the value.
std::string apply_setting(rt::GraphSpec& graph, const std::string& setting, int line = 0);

/// Applies "device.NAME.key=value", "device.NAME.joint.JOINT.key=value" or "bus.NAME.key=value"; returns the reason on
/// failure, empty when applied. Nothing, without any change: the setting has none of these forms.
std::optional<std::string> apply_device_setting(drivers::DeviceSpecs& devices, const std::string& setting,
                                                int line = 0);
/// The same for a command without other settings: returns the reason on failure, also for a setting of another form;
/// empty when applied.
std::string apply_only_device_setting(drivers::DeviceSpecs& devices, const std::string& setting, int line = 0);

/// Takes the robot's name on this machine, before any device is opened. In real time a name that is taken is an error,
/// printed: two runs would steer the same hardware. In virtual time nothing is steered, and the run gets a name of its
/// own, NAME-PID. Where no folder for sockets can be had the run goes on without, with a warning.
bool take_name(Prepared& prepared, const RunOptions& options);

/// The robot's socket, from here until it is destroyed; null with a warning when there can be none. `record_control`
/// answers record.* (null: there is no recorder), `clock` is the robot's, `stop` ends the run, and `complaints` are
/// what is wrong with devices (empty: none can be); all are called by any thread.
std::unique_ptr<tap::Server> open_socket(const Prepared& prepared, const RunOptions& options, rt::Runner& runner,
                                         tap::RecordControl* record_control, const hal::Clock& clock,
                                         std::function<void()> stop,
                                         std::function<std::vector<std::string>()> complaints = {});

}  // namespace sinew::app
