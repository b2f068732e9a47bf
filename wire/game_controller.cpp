#include "wire/game_controller.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <optional>
#include <string_view>

namespace sinew::wire {
namespace {

using msg::GamePenalty;

constexpr std::string_view kPacketWord = "RGme", kAnswerWord = "RGrt";
constexpr std::size_t kCoachBytes = 253 + 6;  // version 12: the coach's message, and the coach as a player
constexpr std::uint8_t kFirstSetPlay12 = 4;   // of the secondary state; 0 to 3 are GamePart
constexpr std::uint8_t kAnswerHumanoid = 2, kAnswerSoccer = 4;
constexpr std::uint8_t kUnknownPenalty12 = 255;

/// In the order of version 12's secondary states.
constexpr std::array kSetPlays12{GameSetPlay::direct_free_kick, GameSetPlay::indirect_free_kick,
                                 GameSetPlay::penalty_kick,     GameSetPlay::corner_kick,
                                 GameSetPlay::goal_kick,        GameSetPlay::throw_in};

struct PenaltyNumber {
  std::uint8_t number = 0;
  GamePenalty penalty{};
};
/// Of several numbers for a penalty the first is written.
constexpr PenaltyNumber kPenalties12[] = {
    {0, GamePenalty::none},
    {30, GamePenalty::ball_holding},
    {31, GamePenalty::pushing},
    {33, GamePenalty::illegal_position},  // in the defence
    {32, GamePenalty::illegal_position},  // in the attack
    {34, GamePenalty::incapable},         // or picked up: one number for both
    {6, GamePenalty::left_field},
    {3, GamePenalty::motion_in_set},
    {14, GamePenalty::substitute},
    {15, GamePenalty::by_hand},
    {35, GamePenalty::service},
    {1, GamePenalty::ball_holding},
    {2, GamePenalty::pushing},
    {4, GamePenalty::incapable},
    {5, GamePenalty::illegal_position},
    {8, GamePenalty::picked_up},
};
constexpr PenaltyNumber kPenalties19[] = {
    {0, GamePenalty::none},          {1, GamePenalty::illegal_position},
    {2, GamePenalty::motion_in_set}, {3, GamePenalty::game_stuck},
    {4, GamePenalty::incapable},     {5, GamePenalty::picked_up},
    {6, GamePenalty::ball_holding},  {7, GamePenalty::left_field},
    {8, GamePenalty::ball_holding},  // by arms or hands
    {9, GamePenalty::pushing},       {10, GamePenalty::sent_off},
    {11, GamePenalty::substitute},
};

std::span<const PenaltyNumber> penalties(GameLayout layout) {
  if (layout == GameLayout::humanoid) return kPenalties12;
  return kPenalties19;
}

/// Takes numbers off the front of a packet whose size has been checked.
class GameBytes {
 public:
  explicit GameBytes(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}
  std::uint8_t u8() { return bytes_[at_++]; }
  std::uint16_t u16() {
    const std::uint8_t low = u8();
    return static_cast<std::uint16_t>(u8() << 8 | low);
  }
  std::int16_t i16() { return static_cast<std::int16_t>(u16()); }
  float f32() {
    const std::uint32_t low = u16();
    return std::bit_cast<float>(static_cast<std::uint32_t>(u16()) << 16 | low);
  }
  void skip(std::size_t bytes) { at_ += bytes; }

 private:
  std::span<const std::uint8_t> bytes_;
  std::size_t at_ = 0;
};

/// Writes numbers into a buffer whose size has been checked.
class GameSink {
 public:
  explicit GameSink(std::span<std::uint8_t> out) : out_(out) {}
  void word(std::string_view text) {
    for (const char c : text) u8(static_cast<std::uint8_t>(c));
  }
  void u8(std::uint8_t value) { out_[at_++] = value; }
  void u16(std::uint16_t value) {
    u8(static_cast<std::uint8_t>(value));
    u8(static_cast<std::uint8_t>(value >> 8));
  }
  void i16(std::int16_t value) { u16(static_cast<std::uint16_t>(value)); }
  void f32(float value) {
    const auto bits = std::bit_cast<std::uint32_t>(value);
    u16(static_cast<std::uint16_t>(bits));
    u16(static_cast<std::uint16_t>(bits >> 16));
  }
  void zeros(std::size_t bytes) {
    for (std::size_t i = 0; i < bytes; ++i) u8(0);
  }
  std::size_t written() const { return at_; }

 private:
  std::span<std::uint8_t> out_;
  std::size_t at_ = 0;
};

bool begins_with(std::span<const std::uint8_t> bytes, std::string_view word) {
  return bytes.size() >= word.size() && std::equal(word.begin(), word.end(), bytes.begin(),
                                                   [](char c, std::uint8_t b) { return b == std::uint8_t(c); });
}

GamePlayer player12(GameBytes& get, bool& keeps_goal) {
  GamePlayer p;
  p.penalty = get.u8(), p.seconds_left = get.u8();
  p.warnings = get.u8(), p.yellow_cards = get.u8(), p.red_cards = get.u8();
  keeps_goal = get.u8() != 0;
  return p;
}

const char* read_packet12(GameBytes& get, GamePacket& out) {
  out.number = get.u8(), out.players_per_team = get.u8(), out.competition = get.u8();
  const std::uint8_t state = get.u8(), first_half = get.u8();
  if (state > 4) return "an unknown state of the game";
  out.state = static_cast<msg::GamePhase>(state);
  out.first_half = first_half != 0;
  out.kicking_team = get.u8();
  const std::uint8_t secondary = get.u8(), set_play_team = get.u8();
  out.set_play_step = get.u8();
  get.skip(2 + 1 + 2);  // the rest of that; who put the ball out, and when: nobody tells it any more
  if (secondary < kFirstSetPlay12) {
    out.part = static_cast<GamePart>(secondary);
    out.set_play_step = 0;
  } else if (secondary - kFirstSetPlay12 < int(kSetPlays12.size())) {
    out.set_play = kSetPlays12[secondary - kFirstSetPlay12];
    out.kicking_team = set_play_team;
    if (out.set_play_step > 2) return "an unknown step of a set play";
  } else {
    return "an unknown secondary state";
  }
  out.seconds_left = get.i16(), out.secondary_seconds = get.i16();
  for (GameTeam& team : out.team) {
    team.number = get.u8(), team.colour = get.u8();
    team.score = get.u8(), team.penalty_shot = get.u8();
    team.single_shots = get.u16();
    get.skip(1 + kCoachBytes);
    for (std::uint8_t i = 0; i < most_players(GameLayout::humanoid); ++i) {
      bool keeps_goal = false;
      team.player[i] = player12(get, keeps_goal);
      if (keeps_goal && team.goalkeeper == 0) team.goalkeeper = static_cast<std::uint8_t>(i + 1);
    }
  }
  return nullptr;
}

const char* read_packet19(GameBytes& get, GamePacket& out) {
  out.number = get.u8(), out.players_per_team = get.u8(), out.competition = get.u8();
  out.stopped = get.u8() != 0;
  const std::uint8_t part = get.u8(), state = get.u8(), set_play = get.u8();
  if (part > 3) return "an unknown part of the game";
  if (state > 4) return "an unknown state of the game";
  if (set_play > 6) return "an unknown set play";
  out.part = static_cast<GamePart>(part);
  out.state = static_cast<msg::GamePhase>(state);
  out.set_play = static_cast<GameSetPlay>(set_play);
  out.first_half = get.u8() != 0;
  out.kicking_team = get.u8();
  out.seconds_left = get.i16(), out.secondary_seconds = get.i16();
  for (GameTeam& team : out.team) {
    team.number = get.u8(), team.colour = get.u8(), team.goalkeeper_colour = get.u8();
    team.goalkeeper = get.u8(), team.score = get.u8(), team.penalty_shot = get.u8();
    team.single_shots = get.u16(), team.message_budget = get.u16();
    if (team.goalkeeper > kGameMostPlayers) return "a goalkeeper whose number no player has";
    for (GamePlayer& p : team.player) {
      p.penalty = get.u8(), p.seconds_left = get.u8();
      p.warnings = get.u8(), p.yellow_cards = get.u8();
    }
  }
  return nullptr;
}

/// Of a packet of version 12; nothing: it has no word for this.
std::optional<std::uint8_t> secondary_state(const GamePacket& p) {
  if (p.set_play == GameSetPlay::none) {
    if (p.set_play_step != 0) return std::nullopt;
    return static_cast<std::uint8_t>(p.part);
  }
  const auto* const play = std::ranges::find(kSetPlays12, p.set_play);
  if (p.part != GamePart::normal || play == kSetPlays12.end() || p.set_play_step > 2) return std::nullopt;
  return static_cast<std::uint8_t>(kFirstSetPlay12 + (play - kSetPlays12.begin()));
}

bool can_be_written(const GamePacket& p) {
  const bool known = p.layout == GameLayout::humanoid || p.layout == GameLayout::humanoid_soccer;
  return known && p.state <= msg::GamePhase::finished && p.part <= GamePart::timeout &&
         p.set_play <= GameSetPlay::corner_kick &&
         std::ranges::all_of(p.team, [&](const GameTeam& team) { return team.goalkeeper <= most_players(p.layout); });
}

void write_packet12(const GamePacket& p, std::uint8_t secondary, GameSink& put) {
  put.u16(static_cast<std::uint16_t>(p.layout));
  put.u8(p.number), put.u8(p.players_per_team), put.u8(p.competition);
  put.u8(static_cast<std::uint8_t>(p.state)), put.u8(p.first_half ? 1 : 0), put.u8(p.kicking_team);
  put.u8(secondary);
  put.u8(p.set_play == GameSetPlay::none ? 0 : p.kicking_team), put.u8(p.set_play_step), put.zeros(2);
  put.u8(0), put.u16(0xFFFF);  // nobody put the ball out
  put.i16(p.seconds_left), put.i16(p.secondary_seconds);
  for (const GameTeam& team : p.team) {
    put.u8(team.number), put.u8(team.colour), put.u8(team.score), put.u8(team.penalty_shot);
    put.u16(team.single_shots);
    put.zeros(1 + kCoachBytes);
    for (std::uint8_t i = 0; i < most_players(GameLayout::humanoid); ++i) {
      const GamePlayer& one = team.player[i];
      put.u8(one.penalty), put.u8(one.seconds_left);
      put.u8(one.warnings), put.u8(one.yellow_cards), put.u8(one.red_cards);
      put.u8(team.goalkeeper == i + 1 ? 1 : 0);
    }
  }
}

void write_packet19(const GamePacket& p, GameSink& put) {
  put.u8(static_cast<std::uint8_t>(p.layout));
  put.u8(p.number), put.u8(p.players_per_team), put.u8(p.competition), put.u8(p.stopped ? 1 : 0);
  put.u8(static_cast<std::uint8_t>(p.part)), put.u8(static_cast<std::uint8_t>(p.state));
  put.u8(static_cast<std::uint8_t>(p.set_play)), put.u8(p.first_half ? 1 : 0), put.u8(p.kicking_team);
  put.i16(p.seconds_left), put.i16(p.secondary_seconds);
  for (const GameTeam& team : p.team) {
    put.u8(team.number), put.u8(team.colour), put.u8(team.goalkeeper_colour), put.u8(team.goalkeeper);
    put.u8(team.score), put.u8(team.penalty_shot), put.u16(team.single_shots), put.u16(team.message_budget);
    for (const GamePlayer& one : team.player)
      put.u8(one.penalty), put.u8(one.seconds_left), put.u8(one.warnings), put.u8(one.yellow_cards);
  }
}

/// Where robots stand although the game is on.
bool stands(const GamePacket& p, bool own_kick) {
  if (p.stopped) return true;
  if (p.layout != GameLayout::humanoid || p.set_play == GameSetPlay::none) return false;
  return p.set_play_step != 1 || own_kick;  // those that wait may take their places
}

msg::GameKick kick_of(const GamePacket& p, std::uint8_t team) {
  const bool waits = p.state != msg::GamePhase::playing || p.set_play != GameSetPlay::none ||
                     p.part == GamePart::shoot_out || p.secondary_seconds > 0;
  if (!waits || p.kicking_team == kNoTeam) return msg::GameKick::any;
  return p.kicking_team == team ? msg::GameKick::own : msg::GameKick::other;
}

std::uint32_t colour_of(std::uint8_t own, std::uint8_t other) {
  if (own == kGameRed) return 1;
  return own != kGameBlue && other == kGameBlue ? 1 : 0;
}

bool finite(const GameAnswer& a) {
  return std::isfinite(a.position_mm[0]) && std::isfinite(a.position_mm[1]) && std::isfinite(a.heading_rad) &&
         std::isfinite(a.ball_age_s) && std::isfinite(a.ball_mm[0]) && std::isfinite(a.ball_mm[1]);
}

}  // namespace

const char* read_game_packet(std::span<const std::uint8_t> bytes, GamePacket& out) noexcept {
  if (!begins_with(bytes, kPacketWord)) return "no packet of a game controller";
  if (bytes.size() < 6) return "cut off";
  out = {};
  // Version 12 is a word of two bytes, 19 one byte.
  if (bytes[4] == std::uint8_t(GameLayout::humanoid) && bytes[5] == 0)
    out.layout = GameLayout::humanoid;
  else if (bytes[4] != std::uint8_t(GameLayout::humanoid_soccer))
    return "a version other than 12 and 19";
  if (bytes.size() != game_packet_bytes(out.layout)) return "a size that its version does not have";
  GameBytes get(bytes);
  get.skip(kPacketWord.size());
  if (out.layout == GameLayout::humanoid) {
    get.skip(2);
    return read_packet12(get, out);
  }
  get.skip(1);
  return read_packet19(get, out);
}

std::size_t write_game_packet(const GamePacket& packet, std::span<std::uint8_t> out) noexcept {
  if (!can_be_written(packet) || out.size() < game_packet_bytes(packet.layout)) return 0;
  GameSink put(out);
  put.word(kPacketWord);
  if (packet.layout == GameLayout::humanoid) {
    const auto secondary = secondary_state(packet);
    if (!secondary) return 0;
    write_packet12(packet, *secondary, put);
  } else {
    write_packet19(packet, put);
  }
  return put.written();
}

GamePenalty game_penalty(GameLayout layout, std::uint8_t number) noexcept {
  const auto all = penalties(layout);
  const auto it = std::ranges::find(all, number, &PenaltyNumber::number);
  return it == all.end() ? GamePenalty::other : it->penalty;
}

std::uint8_t game_penalty_number(GameLayout layout, GamePenalty penalty) noexcept {
  const auto all = penalties(layout);
  const auto number = [&](GamePenalty p, std::uint8_t otherwise) {
    const auto it = std::ranges::find(all, p, &PenaltyNumber::penalty);
    return it == all.end() ? otherwise : it->number;
  };
  const std::uint8_t otherwise =
      layout == GameLayout::humanoid ? kUnknownPenalty12 : number(GamePenalty::picked_up, kUnknownPenalty12);
  return number(penalty, otherwise);
}

bool said_by_packet(const GamePacket& packet, std::uint8_t team, std::uint8_t player, msg::RefereeState& out) noexcept {
  const bool first = packet.team[0].number == team;
  if ((!first && packet.team[1].number != team) || player == 0 || player > most_players(packet.layout)) return false;
  const GameTeam& own = packet.team[first ? 0 : 1];
  const GameTeam& other = packet.team[first ? 1 : 0];
  const GamePlayer& one = own.player[player - 1u];
  out = {};
  out.left_s = packet.seconds_left;
  out.penalty = game_penalty(packet.layout, one.penalty);
  out.penalty_left_s = out.penalty == GamePenalty::none ? 0 : one.seconds_left;
  out.kick = kick_of(packet, team);
  out.phase = packet.state;
  if (out.phase == msg::GamePhase::playing && stands(packet, out.kick == msg::GameKick::own))
    out.phase = msg::GamePhase::set;
  out.half = packet.first_half ? 1 : 2;
  out.own_goals = own.score;
  out.other_goals = other.score;
  out.team = colour_of(own.colour, other.colour);
  out.attacks_right = first ? 1 : 0;
  return true;
}

const char* read_game_answer(std::span<const std::uint8_t> bytes, GameAnswer& out) noexcept {
  if (!begins_with(bytes, kAnswerWord)) return "no answer to a game controller";
  if (bytes.size() < 5) return "cut off";
  out = {};
  GameBytes get(bytes);
  get.skip(kAnswerWord.size());
  const std::uint8_t version = get.u8();
  if (version == kAnswerHumanoid)
    out.layout = GameLayout::humanoid;
  else if (version != kAnswerSoccer)
    return "a version other than 2 and 4";
  if (bytes.size() != (version == kAnswerHumanoid ? 8u : 32u)) return "a size that its version does not have";
  if (version == kAnswerHumanoid) {
    out.team = get.u8(), out.player = get.u8();
    const std::uint8_t word = get.u8();
    if (word > 4) return "an unknown word";
    out.word = static_cast<GameAnswer::Word>(word);
  } else {
    out.player = get.u8(), out.team = get.u8();
    const std::uint8_t fallen = get.u8();
    if (fallen > 1) return "neither fallen nor not";
    out.fallen = fallen == 1;
    out.position_mm = {get.f32(), get.f32()};
    out.heading_rad = get.f32(), out.ball_age_s = get.f32();
    out.ball_mm = {get.f32(), get.f32()};
    if (!finite(out)) return "a place that is no finite number";
  }
  if (out.player == 0 || out.player > most_players(out.layout)) return "a number that no player has";
  return nullptr;
}

std::size_t write_game_answer(const GameAnswer& answer, std::span<std::uint8_t> out) noexcept {
  const bool humanoid = answer.layout == GameLayout::humanoid;
  if (out.size() < (humanoid ? 8u : 32u) || answer.player == 0 || answer.player > most_players(answer.layout) ||
      answer.word > GameAnswer::Word::ready_after_interruption || !finite(answer))
    return 0;
  GameSink put(out);
  put.word(kAnswerWord);
  if (humanoid) {
    put.u8(kAnswerHumanoid), put.u8(answer.team), put.u8(answer.player), put.u8(static_cast<std::uint8_t>(answer.word));
    return put.written();
  }
  put.u8(kAnswerSoccer), put.u8(answer.player), put.u8(answer.team), put.u8(answer.fallen ? 1 : 0);
  for (const float mm : answer.position_mm) put.f32(mm);
  put.f32(answer.heading_rad), put.f32(answer.ball_age_s);
  for (const float mm : answer.ball_mm) put.f32(mm);
  return put.written();
}

}  // namespace sinew::wire
