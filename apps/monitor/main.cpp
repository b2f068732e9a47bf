// sinew-monitor: shows the robots of this machine to browsers and other programs. docs/monitor.md.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <atomic>
#include <cstdio>
#include <thread>

#include "apps/command/command.hpp"
#include "apps/command/number_check.hpp"
#include "apps/command/usage_error.hpp"
#include "hal/linux/process.hpp"
#include "hal/linux/run_dir.hpp"
#include "hal/platform.hpp"
#include "monitor/gate.hpp"
#include "monitor/site.hpp"
#include "monitor/token_file.hpp"

namespace {

using namespace sinew;
using namespace std::chrono_literals;

struct Options {
  monitor::ServerOptions server{};
  std::vector<std::string> hosts{}, tls{};
  std::string panels{};
  bool quiet = false;
};

bool is_loopback(const std::string& address) { return address.starts_with("127.") || address == "localhost"; }

/// As browsers write them in the header Host; port 80 and 443 go without.
std::vector<std::string> names_with_port(const Options& o, std::uint16_t port) {
  std::vector<std::string> names{"127.0.0.1", "localhost", o.server.address}, all;
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

int run(Options o) {
  if (!o.tls.empty()) o.server.certificate = o.tls[0], o.server.key = o.tls[1];
  o.server.every_response = monitor::protective_headers();
  o.server.subprotocols = monitor::LiveSite::subprotocols();
  std::string why;
  // The site needs the server's port for the names by which it may be called, and the server needs whom to ask.
  std::unique_ptr<monitor::Site> site;
  const auto server = monitor::Server::open(
      o.server,
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
  monitor::Robots robots;
  monitor::Site::Options options;
  options.gate.hosts = names_with_port(o, server->port());
  options.gate.token = token->token();
  options.gate.commands = is_loopback(o.server.address) || !o.tls.empty();
  options.panels = o.panels;
  site = std::make_unique<monitor::Site>(robots, *server, std::move(options));
  if (!o.quiet) {
    std::printf("http%s://%s:%u\n", o.tls.empty() ? "" : "s", o.server.address.c_str(), server->port());
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
  return app::kDone;
}

}  // namespace

int main(int argc, char** argv) {
  Options o;
  CLI::App options(
      "Shows the robots of this machine to browsers and other programs. Nothing of it runs in a robot's process.\n"
      "Ends with Ctrl-C. Exit code 0: it was ended, 2: it could not begin.",
      "sinew monitor");
  options.add_option("--address", o.server.address, "listen on this address only; 0.0.0.0: on all")
      ->capture_default_str();
  options.add_option("--port", o.server.port, "0: any free one")->check(app::whole(0, 65535))->capture_default_str();
  options.add_option("--host", o.hosts, "another name by which browsers may call this machine")->type_name("NAME");
  options.add_option("--tls", o.tls, "files in PEM; other addresses than loopback take commands only with it")
      ->expected(2)
      ->type_name("CERTIFICATE KEY");
  options.add_option("--panels", o.panels, "folder with panels of one's own, each a .js file (docs/monitor.md)")
      ->check(CLI::ExistingDirectory)
      ->type_name("FOLDER");
  options.add_flag("--quiet", o.quiet, "do not print address and token");
  try {
    options.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    if (e.get_exit_code() != 0) return fail(app::usage_error(options, e));
    return options.exit(e);  // prints the help
  }
  return run(std::move(o));
}
