#pragma once
#include <CLI/CLI.hpp>
#include <cstdint>
#include <string>
#include <vector>

#include "apps/command/command.hpp"

namespace sinew::app {

/// Of `sinew monitor` and of the program sinew-monitor, which it starts in its place.
struct MonitorOptions {
  std::vector<std::string> files{};   // recorded runs that stand up as robots
  std::string address = "127.0.0.1";  // listen on this address only; "0.0.0.0": on all
  std::uint16_t port = 8080;          // 0: any free one
  std::vector<std::string> hosts{};   // other names by which browsers may call this machine
  std::vector<std::string> tls{};     // none, or certificate and key, files in PEM
  std::vector<std::string> with{};    // monitors of other machines: HOST:PORT or https://HOST:PORT
  std::string trust{};                // file in PEM: their certificates or CA, alone; empty: the system's
  std::string runs = "runs";          // folder of recorded runs
  std::string panels{};               // folder with panels of one's own; empty: none
  bool quiet = false;
};

inline constexpr const char* kMonitorAbout =
    "Shows the robots of this machine, and recorded runs, to browsers and other programs. Nothing of it runs in a "
    "robot's process.\n"
    "Ends with Ctrl-C. Exit code 0: it was ended, 2: it could not begin.";

void add_monitor_options(CLI::App& app, MonitorOptions& options);

/// `sinew monitor`: checks the options, then becomes sinew-monitor, so that a robot's program has no web server in it.
void add_monitor_command(CLI::App& app, CommandContext& context);

}  // namespace sinew::app
