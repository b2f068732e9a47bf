#pragma once
#include <optional>
#include <string>
#include <vector>

#include "rt/module_types.hpp"

namespace sinew::app {

/// The options of `sinew run`.
struct RunOptions {
  std::string robot;                  // path of the robot file
  std::string name;                   // of the robot on this machine; empty: the file's
  std::string board;                  // instead of the file's; empty: the file's
  std::vector<std::string> board_of;  // "DEVICE=BOARD"
  std::string data;                   // folder of the dataset board
  bool virtual_time = false;
  std::optional<std::uint64_t> seed;
  double rate = 1;               // sim board in real time: robot seconds per second
  double duration_s = 0;         // 0: until the mission, the plant or the data ends
  double from_s = 0;             // dataset: begin this long after its first sample
  std::string params;            // file of parameters that take the place of the robot file's; empty: none
  std::vector<std::string> set;  // "module.param=value"
  std::string plant;             // "auto", "unix:PATH", "tcp:HOST:PORT"; empty: the file's
  std::vector<std::string> plant_args;
  std::vector<std::string> faults;  // for a plant of our own: docs/faults.md
  std::string camera;               // "640x480" for a plant of our own; empty: the file's
  std::string plot;                 // where a plot goes; empty: none
  std::string trace;                // where the time line of the last second goes; empty: nowhere
  std::string record_folder;        // where recordings go; empty: the file's
  bool no_record = false;
  bool record_images = false;  // with all their pixels
  bool plain = false;          // no live table, also on a terminal
  bool quiet = false;          // only the result
  bool strict = false;  // real time: no start where `sinew doctor` has something to say, or a privilege is missing
  bool real_actuators = false;  // actuators may be real although sensors are not
  bool unsupervised = false;    // real time: no parent process beside the runtime (for debuggers)
  bool json = false;            // only one JSON object, at the end
};

/// Flies or drives a robot file. Exit code 0: everything went well (a mission: landed well in a valid run); 1: the run
/// did not; 2: it could not start.
int run_command(const RunOptions& options, const rt::ModuleTypes& types);

}  // namespace sinew::app
