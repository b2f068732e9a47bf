#include "wire/game_controller.hpp"

#include <gtest/gtest.h>

#include <array>
#include <limits>
#include <string>
#include <vector>

#include "bytes.hpp"

namespace sinew::wire::game_controller_test {
namespace {

using msg::GameKick;
using msg::GamePenalty;
using msg::GamePhase;
using test::Bytes;

Bytes written(const GamePacket& p) {
  Bytes out(kGameMostBytes);
  out.resize(write_game_packet(p, out));
  return out;
}
Bytes written(const GameAnswer& a) {
  Bytes out(kGameMostAnswerBytes);
  out.resize(write_game_answer(a, out));
  return out;
}
std::string why_not(const Bytes& bytes) {
  GamePacket out;
  const char* why = read_game_packet(bytes, out);
  return why ? why : "";
}
std::string why_no_answer(const Bytes& bytes) {
  GameAnswer out;
  const char* why = read_game_answer(bytes, out);
  return why ? why : "";
}

/// Team 12 in blue defends the left goal, team 34 is in red; its player 3 is penalised.
GamePacket game(GameLayout layout) {
  GamePacket p;
  p.layout = layout;
  p.number = 200, p.players_per_team = 4, p.competition = 1;
  p.state = GamePhase::playing;
  p.first_half = false;
  p.kicking_team = 34;
  p.seconds_left = -5, p.secondary_seconds = 7;
  p.team[0].number = 12, p.team[0].colour = kGameBlue, p.team[0].goalkeeper = 1, p.team[0].score = 2;
  p.team[1].number = 34, p.team[1].colour = kGameRed, p.team[1].goalkeeper = 2, p.team[1].score = 1;
  p.team[1].penalty_shot = 3, p.team[1].single_shots = 0x0105;
  p.team[1].player[2].penalty = game_penalty_number(layout, GamePenalty::pushing);
  p.team[1].player[2].seconds_left = 21;
  p.team[1].player[2].warnings = 1, p.team[1].player[2].yellow_cards = 2;
  if (layout == GameLayout::humanoid)
    p.team[1].player[2].red_cards = 1;
  else
    p.team[1].message_budget = 0x1234, p.team[1].goalkeeper_colour = 7;
  return p;
}

msg::RefereeState said(const GamePacket& p, std::uint8_t team, std::uint8_t player) {
  msg::RefereeState out;
  EXPECT_TRUE(said_by_packet(p, team, player, out));
  return out;
}

constexpr std::array kLayouts{GameLayout::humanoid, GameLayout::humanoid_soccer};

TEST(GameController, PacketsOfBothVersionsComeBackAsTheyWere) {
  for (const GameLayout layout : kLayouts) {
    const Bytes bytes = written(game(layout));
    ASSERT_EQ(bytes.size(), game_packet_bytes(layout));
    GamePacket out;
    ASSERT_EQ(read_game_packet(bytes, out), nullptr);
    EXPECT_EQ(out, game(layout));
  }
}

// The places of the fields are those of the headers that wire/game_controller.hpp names.
TEST(GameController, FieldsOfVersion12AreWhereTheLeagueHasThem) {
  GamePacket p = game(GameLayout::humanoid);
  p.set_play = GameSetPlay::corner_kick, p.set_play_step = 1;
  const Bytes b = written(p);
  EXPECT_EQ(Bytes(b.begin(), b.begin() + 24),
            (Bytes{'R', 'G', 'm', 'e', 12, 0, 200, 4, 1, 3, 0, 34, 7, 34, 1, 0, 0, 0, 0xFF, 0xFF, 0xFB, 0xFF, 7, 0}));
  const std::size_t team = 24 + 332;
  EXPECT_EQ(Bytes(&b[team], &b[team + 7]), (Bytes{34, 1, 1, 3, 0x05, 0x01, 0}));
  const std::size_t players = team + 7 + 253 + 6;
  EXPECT_EQ(Bytes(&b[players + 6], &b[players + 18]), (Bytes{0, 0, 0, 0, 0, 1, 31, 21, 1, 2, 1, 0}));
  EXPECT_EQ(b.size(), players + 11u * 6u);
}

TEST(GameController, FieldsOfVersion19AreWhereTheLeagueHasThem) {
  GamePacket p = game(GameLayout::humanoid_soccer);
  p.stopped = true, p.part = GamePart::extra_time, p.set_play = GameSetPlay::throw_in;
  const Bytes b = written(p);
  EXPECT_EQ(Bytes(b.begin(), b.begin() + 18),
            (Bytes{'R', 'G', 'm', 'e', 19, 200, 4, 1, 1, 2, 3, 4, 0, 34, 0xFB, 0xFF, 7, 0}));
  const std::size_t team = 18 + 90;
  EXPECT_EQ(Bytes(&b[team], &b[team + 10]), (Bytes{34, 1, 7, 2, 1, 3, 0x05, 0x01, 0x34, 0x12}));
  EXPECT_EQ(Bytes(&b[team + 10 + 8], &b[team + 10 + 12]), (Bytes{9, 21, 1, 2}));
  EXPECT_EQ(b.size(), team + 10 + 20u * 4u);
}

TEST(GameController, APlayerHearsTheGameOfItsOwnTeam) {
  for (const GameLayout layout : kLayouts) {
    const msg::RefereeState blue = said(game(layout), 12, 3), red = said(game(layout), 34, 3);
    EXPECT_EQ(blue.phase, GamePhase::playing);
    EXPECT_EQ(blue.left_s, -5);
    EXPECT_EQ(blue.half, 2u);
    EXPECT_EQ(blue.own_goals, 2u);
    EXPECT_EQ(blue.other_goals, 1u);
    EXPECT_EQ(blue.penalty, GamePenalty::none);
    EXPECT_EQ(blue.penalty_left_s, 0);
    EXPECT_EQ(blue.kick, GameKick::other);
    EXPECT_EQ(blue.team, 0u);
    EXPECT_EQ(blue.attacks_right, 1u);
    EXPECT_EQ(red.own_goals, 1u);
    EXPECT_EQ(red.penalty, GamePenalty::pushing);
    EXPECT_EQ(red.penalty_left_s, 21);
    EXPECT_EQ(red.kick, GameKick::own);
    EXPECT_EQ(red.team, 1u);
    EXPECT_EQ(red.attacks_right, 0u);
  }
}

TEST(GameController, NobodyElseHearsAnything) {
  msg::RefereeState out;
  for (const GameLayout layout : kLayouts) {
    EXPECT_FALSE(said_by_packet(game(layout), 13, 1, out));
    EXPECT_FALSE(said_by_packet(game(layout), 12, 0, out));
    EXPECT_TRUE(said_by_packet(game(layout), 12, most_players(layout), out));
    EXPECT_FALSE(said_by_packet(game(layout), 12, most_players(layout) + 1, out));
  }
}

TEST(GameController, TheBallIsFreeWhenTheTimeOfTheKickOffIsOver) {
  GamePacket p = game(GameLayout::humanoid_soccer);
  EXPECT_EQ(said(p, 12, 1).kick, GameKick::other);
  p.secondary_seconds = 0;
  EXPECT_EQ(said(p, 12, 1).kick, GameKick::any);
  p.set_play = GameSetPlay::goal_kick;
  EXPECT_EQ(said(p, 12, 1).kick, GameKick::other);
  p.kicking_team = kNoTeam;
  EXPECT_EQ(said(p, 12, 1).kick, GameKick::any);
  p.set_play = GameSetPlay::none, p.state = GamePhase::ready, p.kicking_team = 12;
  EXPECT_EQ(said(p, 12, 1).kick, GameKick::own) << "who kicks off is known before";
}

TEST(GameController, WherePlayIsStoppedRobotsStand) {
  GamePacket p = game(GameLayout::humanoid_soccer);
  p.stopped = true;
  EXPECT_EQ(said(p, 12, 1).phase, GamePhase::set);
  p.state = GamePhase::ready;
  EXPECT_EQ(said(p, 12, 1).phase, GamePhase::ready) << "only a game that is on can be stopped";
  GamePacket old = game(GameLayout::humanoid);
  old.set_play = GameSetPlay::throw_in;
  for (const std::uint8_t step : std::array<std::uint8_t, 2>{0, 2}) {
    old.set_play_step = step;
    EXPECT_EQ(said(old, 12, 1).phase, GamePhase::set);
    EXPECT_EQ(said(old, 34, 1).phase, GamePhase::set);
  }
  old.set_play_step = 1;
  EXPECT_EQ(said(old, 12, 1).phase, GamePhase::playing) << "takes its place away from the ball";
  EXPECT_EQ(said(old, 12, 1).kick, GameKick::other);
  EXPECT_EQ(said(old, 34, 1).phase, GamePhase::set) << "must not kick before the ball is free";
}

TEST(GameController, PenaltiesHaveTheNumbersOfTheirVersion) {
  const auto of12 = [](int n) { return game_penalty(GameLayout::humanoid, static_cast<std::uint8_t>(n)); };
  const auto of19 = [](int n) { return game_penalty(GameLayout::humanoid_soccer, static_cast<std::uint8_t>(n)); };
  EXPECT_EQ(of12(0), GamePenalty::none);
  EXPECT_EQ(of12(14), GamePenalty::substitute);
  EXPECT_EQ(of12(15), GamePenalty::by_hand);
  EXPECT_EQ(of12(30), GamePenalty::ball_holding);
  EXPECT_EQ(of12(34), GamePenalty::incapable);
  EXPECT_EQ(of12(35), GamePenalty::service);
  EXPECT_EQ(of12(255), GamePenalty::other);
  EXPECT_EQ(of19(0), GamePenalty::none);
  EXPECT_EQ(of19(3), GamePenalty::game_stuck);
  EXPECT_EQ(of19(5), GamePenalty::picked_up);
  EXPECT_EQ(of19(10), GamePenalty::sent_off);
  EXPECT_EQ(of19(12), GamePenalty::other);
  for (const GameLayout layout : kLayouts)
    for (std::uint32_t i = 0; i <= static_cast<std::uint32_t>(GamePenalty::other); ++i) {
      const auto penalty = static_cast<GamePenalty>(i);
      const GamePenalty again = game_penalty(layout, game_penalty_number(layout, penalty));
      EXPECT_EQ(again == GamePenalty::none, penalty == GamePenalty::none) << i;
    }
}

TEST(GameController, OtherShirtsThanBlueAndRedAreTwoTeams) {
  GamePacket p = game(GameLayout::humanoid_soccer);
  p.team[0].colour = 4, p.team[1].colour = kGameBlue;
  EXPECT_EQ(said(p, 12, 1).team, 1u);
  EXPECT_EQ(said(p, 34, 1).team, 0u);
  p.team[1].colour = kGameRed;
  EXPECT_EQ(said(p, 12, 1).team, 0u);
  EXPECT_EQ(said(p, 34, 1).team, 1u);
}

TEST(GameController, WhatIsNoPacketIsNamed) {
  const Bytes good = written(game(GameLayout::humanoid_soccer)), old = written(game(GameLayout::humanoid));
  const auto changed = [](Bytes b, std::size_t at, std::uint8_t value) { return b[at] = value, b; };
  EXPECT_EQ(why_not({}), "no packet of a game controller");
  EXPECT_EQ(why_not(changed(good, 3, 'X')), "no packet of a game controller");
  EXPECT_EQ(why_not(test::bytes_of("RGme")), "cut off");
  EXPECT_EQ(why_not(changed(good, 4, 18)), "a version other than 12 and 19");
  EXPECT_EQ(why_not(changed(old, 5, 1)), "a version other than 12 and 19");
  EXPECT_EQ(why_not(Bytes(good.begin(), good.end() - 1)), "a size that its version does not have");
  EXPECT_EQ(why_not(test::joined({old, {0}})), "a size that its version does not have");
  EXPECT_EQ(why_not(changed(good, 9, 4)), "an unknown part of the game");
  EXPECT_EQ(why_not(changed(good, 10, 5)), "an unknown state of the game");
  EXPECT_EQ(why_not(changed(good, 11, 7)), "an unknown set play");
  EXPECT_EQ(why_not(changed(good, 21, 21)), "a goalkeeper whose number no player has");
  EXPECT_EQ(why_not(changed(old, 9, 5)), "an unknown state of the game");
  EXPECT_EQ(why_not(changed(old, 12, 10)), "an unknown secondary state");
  EXPECT_EQ(why_not(changed(changed(old, 12, 4), 14, 3)), "an unknown step of a set play");
}

TEST(GameController, WhatAVersionCannotSayIsNotWritten) {
  GamePacket p = game(GameLayout::humanoid);
  p.set_play_step = 1;
  EXPECT_TRUE(written(p).empty());
  p.set_play = GameSetPlay::throw_in;
  EXPECT_FALSE(written(p).empty());
  p.part = GamePart::extra_time;
  EXPECT_TRUE(written(p).empty());
  p = game(GameLayout::humanoid_soccer);
  p.state = static_cast<GamePhase>(5);
  EXPECT_TRUE(written(p).empty());
  Bytes small(game_packet_bytes(GameLayout::humanoid_soccer) - 1);
  EXPECT_EQ(write_game_packet(game(GameLayout::humanoid_soccer), small), 0u);
}

TEST(GameController, AnswersAreThoseOfThePacketsVersion) {
  GameAnswer a;
  a.layout = GameLayout::humanoid, a.team = 12, a.player = 3, a.word = GameAnswer::Word::unpenalised_by_hand;
  EXPECT_EQ(written(a), (Bytes{'R', 'G', 'r', 't', 2, 12, 3, 1}));
  a.word = GameAnswer::Word::is_goalkeeper;
  EXPECT_EQ(written(a).back(), 3);
  a.layout = GameLayout::humanoid_soccer, a.word = GameAnswer::Word::alive;
  a.fallen = true, a.position_mm = {1, -2}, a.ball_mm = {0.5f, 0};
  const Bytes bytes = written(a);
  EXPECT_EQ(bytes, (Bytes{'R', 'G', 'r', 't', 4, 3, 12,   1,    0, 0, 0x80, 0x3F, 0, 0, 0, 0xC0,
                          0,   0,   0,   0,   0, 0, 0x80, 0xBF, 0, 0, 0,    0x3F, 0, 0, 0, 0}));
  GameAnswer again;
  ASSERT_EQ(read_game_answer(bytes, again), nullptr);
  EXPECT_EQ(again, a);
}

TEST(GameController, WhatIsNoAnswerIsNamed) {
  GameAnswer a;
  a.team = 12, a.player = 3;
  const Bytes good = written(a);
  const auto changed = [](Bytes b, std::size_t at, std::uint8_t value) { return b[at] = value, b; };
  EXPECT_EQ(why_no_answer(test::bytes_of("RGme")), "no answer to a game controller");
  EXPECT_EQ(why_no_answer(changed(good, 4, 3)), "a version other than 2 and 4");
  EXPECT_EQ(why_no_answer(Bytes(good.begin(), good.end() - 1)), "a size that its version does not have");
  EXPECT_EQ(why_no_answer(changed(good, 5, 21)), "a number that no player has");
  EXPECT_EQ(why_no_answer(changed(good, 7, 2)), "neither fallen nor not");
  EXPECT_EQ(why_no_answer(changed(changed(good, 11, 0x7F), 10, 0xC0)), "a place that is no finite number");
  EXPECT_EQ(why_no_answer({'R', 'G', 'r', 't', 2, 12, 3, 5}), "an unknown word");
  a.player = 0;
  EXPECT_TRUE(written(a).empty());
  a.player = 3, a.heading_rad = std::numeric_limits<float>::infinity();
  EXPECT_TRUE(written(a).empty());
}

}  // namespace
}  // namespace sinew::wire::game_controller_test
