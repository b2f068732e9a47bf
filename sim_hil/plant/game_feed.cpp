#include "sim_hil/plant/game_feed.hpp"

#include <algorithm>

namespace sinew::plant {
namespace {

constexpr int kMostAnswersAtOnce = 64;  // that a packet's turn reads

/// Whole seconds as the game controller tells them: what has begun counts.
template <class T>
T seconds_told(double seconds, double most) {
  const double up = std::clamp(seconds, 0.0, most);
  const auto whole = static_cast<T>(up);
  return static_cast<double>(whole) < up ? static_cast<T>(whole + 1) : whole;
}

std::uint8_t goals_told(std::uint32_t goals) { return static_cast<std::uint8_t>(std::min(goals, 255u)); }

}  // namespace

GameFeed::GameFeed(hal::Radio& radio, const GameFeedOptions& options, std::size_t robots)
    : radio_(radio), options_(options), said_(robots) {}

void GameFeed::step(World& world) noexcept {
  bool any = false;
  for (std::size_t i = 0; i < std::min(said_.size(), world.robots()); ++i) {
    const Due& due = world.robot(i).due();
    if (!due.referee) continue;
    said_[i] = due.referee_sample;
    any = true;
  }
  if (!any) return;
  hear();
  send();
}

/// The team that attacks to the right defends the left goal, and comes first.
void GameFeed::put_robot(std::size_t robot, std::array<std::uint8_t, 2>& players) noexcept {
  const msg::RefereeState& said = said_[robot];
  const std::size_t own = said.team % 2, at = said.attacks_right == 1 ? 0 : 1;
  if (robot == 0) {
    packet_.state = said.phase;
    packet_.first_half = said.half <= 1;
    packet_.seconds_left = seconds_told<std::int16_t>(said.left_s, 32767);
    packet_.kicking_team = said.kick == msg::GameKick::any   ? wire::kNoTeam
                           : said.kick == msg::GameKick::own ? options_.teams[own]
                                                             : options_.teams[1 - own];
    const bool waits = said.phase == msg::GamePhase::playing && said.kick != msg::GameKick::any;
    packet_.secondary_seconds = waits ? 1 : 0;
    packet_.team[at].number = options_.teams[own], packet_.team[1 - at].number = options_.teams[1 - own];
    packet_.team[at].colour = own == 0 ? wire::kGameBlue : wire::kGameRed;
    packet_.team[1 - at].colour = own == 0 ? wire::kGameRed : wire::kGameBlue;
    packet_.team[at].score = goals_told(said.own_goals), packet_.team[1 - at].score = goals_told(said.other_goals);
  }
  if (players[own] >= wire::most_players(packet_.layout)) return;
  wire::GamePlayer& player = packet_.team[at].player[players[own]++];
  player.penalty = wire::game_penalty_number(packet_.layout, said.penalty);
  player.seconds_left = seconds_told<std::uint8_t>(said.penalty_left_s, 255);
}

void GameFeed::send() noexcept {
  packet_ = {};
  packet_.layout = options_.layout;
  packet_.number = static_cast<std::uint8_t>(sent_);
  std::array<std::uint8_t, 2> players{};
  for (std::size_t i = 0; i < said_.size(); ++i) put_robot(i, players);
  players_ = players;
  packet_.players_per_team = std::max(players[0], players[1]);
  std::array<std::uint8_t, wire::kGameMostBytes> bytes{};
  const std::size_t size = wire::write_game_packet(packet_, bytes);
  // One that is lost is the radio's complaint; the next comes soon.
  if (size > 0 && radio_.send(std::span(bytes).first(size))) ++sent_;
}

void GameFeed::hear() noexcept {
  for (int i = 0; i < kMostAnswersAtOnce; ++i) {
    const auto read = radio_.read(datagram_);
    if (!read || !*read) return;
    wire::GameAnswer answer;
    const auto* const team = wire::read_game_answer(datagram_.bytes(), answer)
                                 ? options_.teams.end()
                                 : std::ranges::find(options_.teams, answer.team);
    if (team == options_.teams.end())
      ++others_;
    else
      ++answers_[static_cast<std::size_t>(team - options_.teams.begin())][answer.player];
  }
}

std::string GameFeed::text() const {
  std::string text = "game controller: " + std::to_string(sent_) + " packets sent";
  for (std::size_t team = 0; team < 2; ++team) {
    if (players_[team] == 0) continue;
    text += "; answers of team " + std::to_string(options_.teams[team]) + ":";
    for (std::uint8_t player = 1; player <= players_[team]; ++player)
      text += std::string(player > 1 ? ", " : " ") + std::to_string(answers_[team][player]) + " of robot " +
              std::to_string(player);
  }
  if (others_ > 0) text += "; " + std::to_string(others_) + " datagrams of others";
  return text;
}

}  // namespace sinew::plant
