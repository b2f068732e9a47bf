#pragma once
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "hal/radio.hpp"
#include "sim_hil/worlds/world.hpp"
#include "wire/game_controller.hpp"

namespace sinew::plant {

struct GameFeedOptions {
  wire::GameLayout layout = wire::GameLayout::humanoid_soccer;
  std::array<std::uint8_t, 2> teams{1, 2};  // numbers of blue and red
};

/// What the referee of a world says to its robots, as packets of RoboCup's game controller (wire/game_controller.hpp),
/// whenever he says something: twice a second of the world's time. A robot's number is its place among the robots of
/// its team, 1 first.
/// RefereeState does not say for how long the other team has to keep away from the ball: while it does, the packet has
/// one second of it left.
/// Thread:  the world's.   RT: yes, as far as the radio's.
class GameFeed {
 public:
  /// `radio` sends to robots, and hears their answers.
  GameFeed(hal::Radio& radio, const GameFeedOptions& options, std::size_t robots);

  /// After each step of the world.
  void step(World& world) noexcept;

  std::uint64_t sent() const { return sent_; }
  /// Answers of the robot with this number. Team: 0 blue, 1 red.
  std::uint64_t answers(std::size_t team, std::uint8_t player) const { return answers_[team][player]; }
  /// Datagrams that were no answer of a robot of this game.
  std::uint64_t others() const { return others_; }
  /// "game controller: 120 packets sent; answers of team 1: 118 of robot 1, 0 of robot 2".
  std::string text() const;

 private:
  void put_robot(std::size_t robot, std::array<std::uint8_t, 2>& players) noexcept;
  void send() noexcept;
  void hear() noexcept;

  hal::Radio& radio_;
  const GameFeedOptions options_;
  std::vector<msg::RefereeState> said_;  // to each robot
  wire::GamePacket packet_;
  msg::Datagram datagram_;
  std::uint64_t sent_ = 0, others_ = 0;
  std::array<std::uint8_t, 2> players_{};  // of each team
  std::array<std::array<std::uint64_t, wire::kGameMostPlayers + 1>, 2> answers_{};
};

}  // namespace sinew::plant
