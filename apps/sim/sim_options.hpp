#pragma once
#include <string>
#include <vector>

#include "apps/sim/game_options.hpp"
#include "apps/sim/redraw.hpp"
#include "apps/sim/simspark_options.hpp"
#include "apps/sim/usarsim_options.hpp"
#include "apps/sim/wire_options.hpp"
#include "sim_hil/plant/session.hpp"

namespace sinew::plant {

/// What sinew-sim was asked for on its command line.
struct SimulatorOptions {
  std::string listen = "unix:sinew-sim.sock";
  std::string serve = "sinew";  // the protocol: or "usarsim", "simspark", "simspark:PORT"
  std::string world = "quad", camera = "320x240", format = "yuyv", render_test;
  std::vector<std::string> reports;        // files that get the last report; "-": standard output
  std::string simspark_peer;               // of the world simspark: "HOST:PORT/TEAM"
  std::string scenes;                      // file that takes down the scenes of all pictures; empty: none
  std::vector<std::string> words, bodies;  // of the command line: all of them; of --body
  RedrawOptions redraw;
  bool list_faults = false, alone = false, lockstep = false, free_running = false;
  double wait_s = 60;
  CameraOptions view;
  SessionOptions session;  // its faults are those of devices on the protocol
  WireOptions wire;
  UsarsimOptions usarsim;
  SimsparkOptions simspark;
  GameOptions game;
  std::vector<WireServo> servos;    // of wire.servos
  std::vector<WireLineSpec> lines;  // of wire.serial
  std::vector<Fault> wire_faults;   // those that the drives at the wire play

  bool serves_simspark() const { return serve.starts_with("simspark"); }
  /// Priority of the threads of the listener and of the video node: one above physics, so that a stop line does not
  /// wait for pixels, nor the video node for physics.
  int lines_priority() const;
};

inline constexpr int kUsage = 2;  // exit code

/// Reads the command line into `options`. False after printing why: the process ends with `exit_code`, 0 when help was
/// asked for, kUsage when the options are wrong or contradict each other.
bool read_command_line(int argc, char** argv, SimulatorOptions& options, int& exit_code);

}  // namespace sinew::plant
