#include "apps/sim/simspark_options.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>

namespace sinew::plant {
namespace {

constexpr const char* kSimsparkOptions[] = {"--monitor-listen", "--players",  "--agents",    "--sync",
                                            "--exact-beam",     "--kick-off", "--half-time", "--patience"};

}  // namespace

void SimsparkOptions::describe(CLI::App& app) {
  app.add_option("--monitor-listen", monitor_listen, "simspark: where monitors are served: tcp:HOST:PORT, or none")
      ->capture_default_str();
  app.add_option("--players", players, "simspark: so many bodies are there; more agents are refused")
      ->check(CLI::Range(std::size_t{1}, simspark::kMostPlayers))
      ->capture_default_str();
  app.add_flag("--sync", sync, "simspark: a cycle begins when all players have said (syn); else every 20 ms");
  app.add_option("--agents", agents, "simspark, --sync: the first cycle waits for so many players")
      ->check(CLI::Range(std::size_t{1}, simspark::kMostPlayers))
      ->capture_default_str();
  app.add_option("--patience", patience_s, "simspark, --sync: an agent without (syn) for so many seconds is let go")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_flag("--exact-beam", exact_beam, "simspark: beams end where they are told to; else within 5 cm, 10 degrees");
  app.add_option("--kick-off", kick_off_s, "simspark: kick-off for the left team after so many seconds; 0: a monitor's")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  app.add_option("--half-time", half_s, "simspark: length of a half, s")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
}

const char* SimsparkOptions::given(const CLI::App& app) {
  const auto found = std::ranges::find_if(kSimsparkOptions, [&](const char* o) { return app.count(o) > 0; });
  return found == std::end(kSimsparkOptions) ? nullptr : *found;
}

std::string SimsparkOptions::listen_of(const std::string& serve) {
  constexpr std::string_view kName = "simspark";
  if (serve == kName) return kListen;
  if (!serve.starts_with(std::string(kName) + ":")) return "";
  unsigned port = 0;
  const char* const end = serve.data() + serve.size();
  const auto read = std::from_chars(serve.data() + kName.size() + 1, end, port);
  constexpr unsigned kMostPort = 65535;
  return read.ec == std::errc() && read.ptr == end && port <= kMostPort ? "tcp:127.0.0.1:" + std::to_string(port) : "";
}

simspark::ServerOptions SimsparkOptions::server() const {
  simspark::ServerOptions o;
  o.sync = sync;
  o.agents = agents;
  o.patience = hal::Duration{static_cast<std::int64_t>(patience_s * 1e9)};
  return o;
}

}  // namespace sinew::plant
