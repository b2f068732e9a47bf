#include "apps/sim/game_options.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <charconv>
#include <cstdio>

#include "apps/command/choice_check.hpp"
#include "apps/command/number_check.hpp"
#include "hal/linux/udp_radio.hpp"
#include "sim_hil/worlds/world.hpp"

namespace sinew::plant {
namespace {

constexpr const char* kGameOptions[] = {"--gamecontroller-teams", "--gamecontroller-version",
                                        "--gamecontroller-answers"};

/// "1,2"; false: they are no two different numbers of teams.
bool read_teams(std::string_view text, std::array<std::uint8_t, 2>& teams) {
  const char* at = text.data();
  const char* const end = at + text.size();
  const auto first = std::from_chars(at, end, teams[0]);
  if (first.ec != std::errc() || first.ptr == end || *first.ptr != ',') return false;
  const auto second = std::from_chars(first.ptr + 1, end, teams[1]);
  const auto is_team = [](std::uint8_t t) { return t >= 1 && t != wire::kNoTeam; };
  return second.ec == std::errc() && second.ptr == end && is_team(teams[0]) && is_team(teams[1]) &&
         teams[0] != teams[1];
}

}  // namespace

void GameOptions::describe(CLI::App& app) {
  app.add_option("--gamecontroller", to,
                 "sends what the referee says to this address as RoboCup's game controller does "
                 "(docs/devices.md#the-game-controller), for example 127.0.0.1:3838; may be repeated")
      ->allow_extra_args(false)
      ->type_name("ADDRESS:PORT");
  app.add_option("--gamecontroller-teams", teams, "numbers of the blue and the red team in its packets, 1 to 254")
      ->capture_default_str()
      ->type_name("BLUE,RED");
  app.add_option("--gamecontroller-version", version,
                 "of its packets: 19, the Humanoid Soccer League's from 2026 on, or 12, the Humanoid League's before")
      ->check(app::one_of({"12", "19"}))
      ->capture_default_str();
  app.add_option("--gamecontroller-answers", answers, "UDP port at which it hears answers, and sends from")
      ->check(app::whole(1, 65535))
      ->capture_default_str();
}

std::string GameOptions::read(const CLI::App& app, const WorldChoice& world) {
  for (const char* option : kGameOptions)
    if (app.count(option) > 0 && to.empty()) return fmt::format("{}: only with --gamecontroller", option);
  if (to.empty()) return "";
  for (const std::string& text : to) {
    const auto peer = hal::udp_address(text);
    if (!peer || peer->ipv4 == 0 || peer->is_multicast())
      return fmt::format("--gamecontroller: '{}': an address and a port, 127.0.0.1:3838", text);
    peers.push_back(*peer);
  }
  const WorldInfo& info = world.type->info;
  if (info.value(world.values, "referee").value_or(0) != 1)
    return fmt::format("--gamecontroller: the world {} has no referee{}", info.name,
                       info.find_option("referee") ? "; --referee 1 gives it one" : "");
  if (!read_teams(teams, feed.teams))
    return fmt::format("--gamecontroller-teams: '{}': two different numbers from 1 to 254, 1,2", teams);
  feed.layout = version == "12" ? wire::GameLayout::humanoid : wire::GameLayout::humanoid_soccer;
  return "";
}

bool open_game(const GameOptions& options, std::size_t robots, hal::Os& os, GameSender& sender) {
  if (!options.any()) return true;
  hal::RadioSpec spec;
  spec.peers = options.peers, spec.port = options.answers;
  std::string why;
  auto radio = hal::UdpRadio::open(spec, os, why);
  if (!radio) {
    std::fprintf(stderr, "sinew-sim: --gamecontroller: %s\n", why.c_str());
    return false;
  }
  sender.radio = std::move(*radio);
  sender.feed = std::make_unique<GameFeed>(*sender.radio, options.feed, robots);
  return true;
}

}  // namespace sinew::plant
