#pragma once
// RoboCup's game controller: what it sends to the robots of both teams (UDP 3838), and what they answer (UDP 3939).
// Little-endian, fields without padding. Two layouts share the ports and the words "RGme" and "RGrt":
// - version 12, answers of version 2: the Humanoid League until 2025;
// - version 19, answers of version 4: the Humanoid Soccer League from 2026 on.
// Source:  RoboCup-Humanoid-TC/GameController, game_controller_msgs/headers/new_RoboCupGameControlData.h of 2025-07-10
//          (12); RoboCup-HumanoidSoccerLeague/GameController, the same folder's RoboCupGameControlData.h of 2026-03-06
//          (19). docs/devices.md#the-game-controller says what is taken for what.
#include <array>
#include <cstdint>
#include <span>

#include "msg/referee.hpp"

namespace sinew::wire {

inline constexpr std::uint16_t kGamePort = 3838, kGameAnswerPort = 3939;
inline constexpr std::uint8_t kNoTeam = 255;  // GamePacket::kicking_team: nobody's, a dropped ball
inline constexpr std::uint8_t kGameMostPlayers = 20;

enum class GameLayout : std::uint8_t { humanoid = 12, humanoid_soccer = 19 };
/// Players of a team in a packet: 11, 20.
constexpr std::uint8_t most_players(GameLayout layout) { return layout == GameLayout::humanoid ? 11 : 20; }
/// Bytes of a packet.
constexpr std::size_t game_packet_bytes(GameLayout layout) { return layout == GameLayout::humanoid ? 688 : 198; }
inline constexpr std::size_t kGameMostBytes = 688;

enum class GamePart : std::uint8_t { normal, shoot_out, extra_time, timeout };
enum class GameSetPlay : std::uint8_t {
  none,
  direct_free_kick,
  indirect_free_kick,
  penalty_kick,
  throw_in,
  goal_kick,
  corner_kick,
};

struct GamePlayer {
  std::uint8_t penalty = 0;       // the layout's own number: game_penalty()
  std::uint8_t seconds_left = 0;  // of it
  std::uint8_t warnings = 0, yellow_cards = 0;
  std::uint8_t red_cards = 0;  // version 12
  bool operator==(const GamePlayer&) const = default;
};

struct GameTeam {
  std::uint8_t number = 0;
  std::uint8_t colour = 0;             // of the field players: kGameBlue, ...
  std::uint8_t goalkeeper_colour = 0;  // version 19
  std::uint8_t goalkeeper = 0;         // its number; 0: none
  std::uint8_t score = 0, penalty_shot = 0;
  std::uint16_t single_shots = 0;                     // bit i: the shot i was a goal
  std::uint16_t message_budget = 0;                   // version 19: messages to mates that are left
  std::array<GamePlayer, kGameMostPlayers> player{};  // the one with number 1 first
  bool operator==(const GameTeam&) const = default;
};
inline constexpr std::uint8_t kGameBlue = 0, kGameRed = 1;

/// One packet of the game controller.
struct GamePacket {
  GameLayout layout = GameLayout::humanoid_soccer;
  std::uint8_t number = 0;  // counts packets, wraps
  std::uint8_t players_per_team = 0;
  std::uint8_t competition = 0;  // version 12: 0 kid, 1 adult, 2 drop-in; 19: 0 small, 1 middle, 2 large
  msg::GamePhase state = msg::GamePhase::initial;
  GamePart part = GamePart::normal;
  GameSetPlay set_play = GameSetPlay::none;
  std::uint8_t set_play_step = 0;  // version 12: 0 everybody stands, 1 places are taken, 2 everybody stands again
  bool stopped = false;            // version 19: play is stopped
  bool first_half = true;
  std::uint8_t kicking_team = kNoTeam;  // its number
  std::int16_t seconds_left = 0;        // of the half; below 0: overtime
  std::int16_t secondary_seconds = 0;   // of what is on: ready, until the ball is free, a time-out
  std::array<GameTeam, 2> team{};       // the first defends the left goal, seen from the game controller's table
  bool operator==(const GamePacket&) const = default;
};

/// Reads a packet. Null: `out` holds it. Else why it is none, in words; `out` is then unspecified.
/// RT:  yes.
const char* read_game_packet(std::span<const std::uint8_t> bytes, GamePacket& out) noexcept;
/// Writes a packet: game_packet_bytes() of its layout; fields that only the other layout has are left out. 0: `out` is
/// too small, a number is out of its range, or version 12 has no word for it (a set play in extra time, a shoot-out or
/// a time-out; a step without a set play).
std::size_t write_game_packet(const GamePacket& packet, std::span<std::uint8_t> out) noexcept;

/// The meaning of a penalty's number. Numbers that the layout does not have are `other`.
msg::GamePenalty game_penalty(GameLayout layout, std::uint8_t number) noexcept;
/// The other way; a penalty that the layout does not have gets the number of one that also keeps the robot out.
std::uint8_t game_penalty_number(GameLayout layout, msg::GamePenalty penalty) noexcept;

/// What the packet says to a player: RefereeState without its stamp. While play is stopped, and where a set play of
/// version 12 has everybody stand, the phase is `set`. Team 0 is the one in blue shirts, and where none is in blue the
/// one that is not in red.
/// False: the team is in none of the two, or has no such player.
bool said_by_packet(const GamePacket& packet, std::uint8_t team, std::uint8_t player, msg::RefereeState& out) noexcept;

/// What a robot says back.
struct GameAnswer {
  enum class Word : std::uint8_t {
    penalised_by_hand = 0,
    unpenalised_by_hand = 1,
    alive = 2,
    is_goalkeeper = 3,
    ready_after_interruption = 4,
  };
  GameLayout layout = GameLayout::humanoid_soccer;  // of the packet that it answers
  std::uint8_t team = 0, player = 0;                // 1 to most_players()
  Word word = Word::alive;                          // version 2: only there; 4 is always `alive`
  bool fallen = false;                              // version 4 from here on
  /// Where it is, and where the ball is seen from it. Frame: the other goal is at +x, y to the left; from the robot
  /// x to the front, y to the left. In mm, as on the wire.
  std::array<float, 2> position_mm{};
  float heading_rad = 0;
  float ball_age_s = -1;  // below 0: it has not seen it
  std::array<float, 2> ball_mm{};
  bool operator==(const GameAnswer&) const = default;
};
inline constexpr std::size_t kGameMostAnswerBytes = 32;

/// Reads an answer. Null: `out` holds it. Else why it is none, in words.
const char* read_game_answer(std::span<const std::uint8_t> bytes, GameAnswer& out) noexcept;
/// Writes an answer: 8 or 32 bytes. 0: `out` is too small, or there is no such player, word or number.
std::size_t write_game_answer(const GameAnswer& answer, std::span<std::uint8_t> out) noexcept;

}  // namespace sinew::wire
