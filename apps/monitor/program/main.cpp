// sinew-monitor: shows the robots of this machine to browsers and other programs. docs/monitor.md.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <atomic>
#include <cstdio>
#include <thread>

#include "apps/command/command.hpp"
#include "apps/command/place.hpp"
#include "apps/command/usage_error.hpp"
#include "apps/monitor/monitor_options.hpp"
#include "hal/linux/process.hpp"
#include "hal/linux/run_dir.hpp"
#include "hal/platform.hpp"
#include "monitor/gate.hpp"
#include "monitor/site.hpp"
#include "monitor/token_file.hpp"

namespace {

using namespace sinew;
using namespace std::chrono_literals;

bool is_loopback(const std::string& address) { return address.starts_with("127.") || address == "localhost"; }

/// As browsers write them in the header Host; port 80 and 443 go without.
std::vector<std::string> names_with_port(const app::MonitorOptions& o, std::uint16_t port) {
  std::vector<std::string> names{"127.0.0.1", "localhost", o.address}, all;
  names.insert(names.end(), o.hosts.begin(), o.hosts.end());
  for (const std::string& name : names) {
    all.push_back(fmt::format("{}:{}", name, port));
    if (port == (o.tls.empty() ? 80 : 443)) all.push_back(name);
  }
  return all;
}

int fail(const std::string& why) {
  std::fprintf(stderr, "sinew-monitor: %s\n", why.c_str());
  return app::kNotBegun;
}

int run(const app::MonitorOptions& o) {
  monitor::ServerOptions listen;
  listen.address = o.address, listen.port = o.port;
  if (!o.tls.empty()) listen.certificate = o.tls[0], listen.key = o.tls[1];
  listen.trust = o.trust;
  listen.every_response = monitor::protective_headers();
  listen.subprotocols = monitor::LiveSite::subprotocols();
  listen.most_message_bytes = foxglove::kMostClientBytes;
  std::string why;
  // The site needs the server's port for the names by which it may be called, and the server needs whom to ask.
  std::unique_ptr<monitor::Site> site;
  const auto server = monitor::Server::open(
      listen,
      [&site](monitor::Request request, monitor::ConnectionId id, const monitor::Server::Reply& reply) {
        site->answer(std::move(request), id, reply);
      },
      [&site](const monitor::Request& request, monitor::ConnectionId id, monitor::Response& refusal) {
        return site->open_socket(request, id, refusal);
      },
      why);
  if (!server) return fail(why);
  const auto token = monitor::TokenFile::make(why);
  if (!token) return fail(why);
  const std::string sinew = app::find_program("sinew");
  if (sinew.empty() && !o.files.empty())
    return fail("sinew is missing beside sinew-monitor and in PATH; it plays recorded files");
  monitor::Robots robots;
  monitor::Site::Options options;
  options.gate.hosts = names_with_port(o, server->port());
  options.gate.token = token->token();
  options.gate.commands = is_loopback(o.address) || !o.tls.empty();
  options.panels = o.panels;
  options.sinew = sinew;
  options.runs = {o.runs, o.files, [](const std::string& path, const std::string& recorded_why) {
                    std::fprintf(stderr, "sinew-monitor: %s: %s\n", path.c_str(), recorded_why.c_str());
                  }};
  site = std::make_unique<monitor::Site>(robots, *server, std::move(options));
  for (const std::string& address : o.with)
    if (!site->add_monitor(address, why)) {
      site.reset();
      return fail(why);
    }
  if (!o.quiet) {
    std::printf("http%s://%s:%u\n", o.tls.empty() ? "" : "s", o.address.c_str(), server->port());
    std::printf("token for commands: %s (also in %s)\n", token->token().c_str(), token->path().c_str());
    std::fflush(stdout);
  }
  hal::stop_requested();  // from now on a signal only asks
  std::atomic<bool> over{false};
  std::thread signals([&] {
    hal::Os& os = hal::system_os();
    while (!hal::stop_requested() && !over.load()) os.sleep_until(os.now() + 100ms);
    server->stop();
  });
  server->run();
  over.store(true);
  signals.join();
  site.reset();  // it looks at the robots, and has threads that do
  return app::kDone;
}

}  // namespace

int main(int argc, char** argv) {
  app::MonitorOptions o;
  CLI::App options(app::kMonitorAbout, "sinew monitor");
  app::add_monitor_options(options, o);
  try {
    options.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    if (e.get_exit_code() != 0) return fail(app::usage_error(options, e));
    return options.exit(e);  // prints the help
  }
  return run(o);
}
