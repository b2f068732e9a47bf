#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <memory>

#include "apps/command/place.hpp"
#include "apps/monitor/monitor_options.hpp"

namespace sinew::app {
namespace {

constexpr const char* kProgram = "sinew-monitor";

int become_monitor(const MonitorOptions& o) {
  const std::string program = find_program(kProgram);
  if (program.empty())
    return fail(std::string(kProgram) +
                " is missing beside sinew and in PATH; it is built where libwebsockets is (Debian: libwebsockets-dev "
                "libturbojpeg0-dev)");
  std::vector<std::string> arguments{program, "--address", o.address, "--port", std::to_string(o.port)};
  for (const std::string& name : o.hosts) arguments.insert(arguments.end(), {"--host", name});
  if (!o.tls.empty()) arguments.insert(arguments.end(), {"--tls", o.tls[0], o.tls[1]});
  for (const std::string& address : o.with) arguments.insert(arguments.end(), {"--with", address});
  if (!o.trust.empty()) arguments.insert(arguments.end(), {"--trust", o.trust});
  arguments.insert(arguments.end(), {"--runs", o.runs});
  if (!o.panels.empty()) arguments.insert(arguments.end(), {"--panels", o.panels});
  if (o.quiet) arguments.push_back("--quiet");
  if (!o.files.empty()) arguments.push_back("--");
  arguments.insert(arguments.end(), o.files.begin(), o.files.end());
  std::vector<char*> argv;
  for (std::string& argument : arguments) argv.push_back(argument.data());
  argv.push_back(nullptr);
  execv(argv[0], argv.data());
  return fail(program + ": " + std::strerror(errno));
}

}  // namespace

void add_monitor_command(CLI::App& app, CommandContext& context) {
  const auto options = std::make_shared<MonitorOptions>();
  CLI::App* monitor = app.add_subcommand("monitor", kMonitorAbout);
  add_monitor_options(*monitor, *options);
  monitor->callback([&context, options] { context.action = [options] { return become_monitor(*options); }; });
}

}  // namespace sinew::app
