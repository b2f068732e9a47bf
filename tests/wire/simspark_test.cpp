#include "wire/text/simspark.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace sinew::wire::simspark_test {
namespace {

// As a server of version 0.7.3 sends them.
constexpr std::string_view kPercepts =
    "(time (now 4.02))(GS (unum 1) (team left) (sl 0) (sr 2) (t 1.50) (pm BeforeKickOff))"
    "(GYR (n torso) (rt 0.24 -0.05 0.02))(ACC (n torso) (a -0.01 0.05 9.80))(HJ (n hj1) (ax 0.00))(HJ (n rlj3) (ax "
    "-37.25))"
    "(FRP (n lf) (c -0.14 0.08 -0.05) (f -0.14 0.61 20.40))"
    "(See (F1L (pol 19.11 108.55 -1.58)) (B (pol 9.25 -0.10 -2.80)) (P (team RED) (id 2) (head (pol 8.21 -60.27 1.42))"
    " (rfoot (pol 8.14 -61.25 -3.20))) (L (pol 15.98 -58.32 -2.00) (pol 5.83 60.05 -5.37)))"
    "(hear RED 3.98 45.20 hallo)(hear BLUE 4.02 self du)(TopCameraIMG (s 2 1) (d AAECAwQF))";

SparkPercepts& parsed(std::string_view text) {
  static SparkPercepts percepts;
  EXPECT_EQ(parse_spark_percepts(text, percepts), SparkError::none) << text;
  return percepts;
}
SparkError error_of(std::string_view text) {
  static SparkPercepts percepts;
  return parse_spark_percepts(text, percepts);
}

TEST(SimSpark, PerceptsAreReadAsTheServerSendsThem) {
  const SparkPercepts& p = parsed(kPercepts);
  EXPECT_EQ(p.now_s, 4.02);
  EXPECT_TRUE(p.has_game && p.has_gyro && p.has_acceleration && p.has_see);
  EXPECT_EQ(p.number, 1u);
  EXPECT_EQ(p.side, "left");
  EXPECT_EQ(p.left_goals, 0u);
  EXPECT_EQ(p.right_goals, 2u);
  EXPECT_EQ(p.game_s, 1.5);
  EXPECT_EQ(p.play_mode, "BeforeKickOff");
  EXPECT_EQ(p.gyro_dps, (std::array{0.24, -0.05, 0.02}));
  EXPECT_EQ(p.acceleration_mps2, (std::array{-0.01, 0.05, 9.8}));
  ASSERT_EQ(p.joints, 2u);
  EXPECT_EQ(p.find_joint("rlj3")->degrees, -37.25);
  EXPECT_EQ(p.find_joint("llj3"), nullptr);
  ASSERT_EQ(p.forces, 1u);
  EXPECT_EQ(p.force[0].name, "lf");
  EXPECT_EQ(p.force[0].center_m, (std::array{-0.14, 0.08, -0.05}));
  EXPECT_EQ(p.force[0].force_n, (std::array{-0.14, 0.61, 20.4}));
  ASSERT_EQ(p.sightings, 5u);
  EXPECT_EQ(p.seen[0].kind, SparkSeen::Kind::landmark);
  EXPECT_EQ(p.seen[0].name, "F1L");
  EXPECT_EQ(p.seen[1].kind, SparkSeen::Kind::ball);
  EXPECT_EQ(p.seen[1].at.azimuth_deg, -0.1);
  EXPECT_EQ(p.seen[3].kind, SparkSeen::Kind::player);
  EXPECT_EQ(p.seen[3].team, "RED");
  EXPECT_EQ(p.seen[3].number, 2u);
  EXPECT_EQ(p.seen[3].name, "rfoot");
  EXPECT_EQ(p.seen[4].kind, SparkSeen::Kind::line);
  EXPECT_EQ(p.seen[4].at.distance_m, 15.98);
  EXPECT_EQ(p.seen[4].to.elevation_deg, -5.37);
  ASSERT_EQ(p.hears, 2u);
  EXPECT_EQ(p.heard[0].team, "RED");
  EXPECT_EQ(p.heard[0].direction_deg, 45.2);
  EXPECT_EQ(p.heard[0].text, "hallo");
  EXPECT_TRUE(p.heard[1].self);
  ASSERT_EQ(p.images, 1u);
  EXPECT_EQ(p.image[0].name, "TopCameraIMG");
  EXPECT_EQ(p.image[0].width, 2u);
  EXPECT_EQ(p.image[0].base64, "AAECAwQF");
  EXPECT_EQ(p.unknown, 0u);
}

TEST(SimSpark, WhatIsWrittenIsThatText) {
  std::array<char, 4096> buffer;
  SparkWriter out(buffer);
  const auto frame = out.percepts(parsed(kPercepts)).frame();
  ASSERT_GT(frame.size(), 4u);
  EXPECT_EQ(std::string_view(frame.data() + 4, frame.size() - 4), kPercepts);
}

// The examples of rcsssmj's user guide.
TEST(SimSpark, TheMujocoServersPerceptsAreReadAndWritten) {
  constexpr std::string_view kText =
      "(time (now 1.20))(GS (sl 2) (sr 1) (t 231.52) (pm PlayOn) (tl teamBlue) (tr teamRed))"
      "(pos (n torso_pos) (pos -0.122 24.575 0.762))(quat (n torso_quat) (q 1.000 0.000 0.000 0.000))"
      "(GYR (n torso) (rt -6.97 -3.31 25.16))(ACC (n torso) (a 0.13 0.41 -9.75))"
      "(HJ (n hj1) (ax 1.43) (vx 0.03))(HJ (n hj2) (ax 16.92) (vx 1.44))"
      "(See (G2R (pol 17.55 -3.33 4.31)) (P (team teamRed) (id 1) (head (pol 16.98 -0.21 3.19))))";
  const SparkPercepts& p = parsed(kText);
  EXPECT_EQ(p.left_team, "teamBlue");
  EXPECT_EQ(p.right_team, "teamRed");
  ASSERT_EQ(p.places, 2u);
  EXPECT_FALSE(p.place[0].is_turn);
  EXPECT_EQ(p.place[0].position_m, (std::array{-0.122, 24.575, 0.762}));
  EXPECT_TRUE(p.place[1].is_turn);
  EXPECT_EQ(p.place[1].name, "torso_quat");
  EXPECT_EQ(p.find_joint("hj2")->degrees_per_s, 1.44);
  EXPECT_TRUE(p.find_joint("hj2")->has_speed);
  EXPECT_EQ(p.unknown, 0u);
  std::array<char, 2048> buffer;
  const auto frame = SparkWriter(buffer).percepts(p).frame();
  EXPECT_EQ(std::string_view(frame.data() + 4, frame.size() - 4), kText);
  EXPECT_EQ(error_of("(pos (n torso_pos) (pos 1 2))"), SparkError::missing);
  EXPECT_EQ(error_of("(quat (n torso_quat) (pos 1 2 3))"), SparkError::missing);
  EXPECT_EQ(error_of("(pos (pos 1 2 3))"), SparkError::missing);
}

TEST(SimSpark, TheMujocoServersAgentsAreReadAsTheyWrite) {
  std::array<char, 512> buffer;
  SparkWriter out(buffer);
  out.init("T1", "teamBlue", 2).motor("he1", {12.42, 0, 0.9, 0, 0}).beam(-29.5, 16, -35);
  const auto frame = out.frame();
  SparkEffectors in({frame.data() + 4, frame.size() - 4});
  SparkEffector e;
  using Kind = SparkEffector::Kind;
  ASSERT_TRUE(in.next(e));
  EXPECT_EQ(e.kind, Kind::init);
  EXPECT_EQ(e.model, "T1");
  EXPECT_EQ(e.name, "teamBlue");
  EXPECT_EQ(e.number, 2u);
  ASSERT_TRUE(in.next(e));
  EXPECT_EQ(e.kind, Kind::motor);
  EXPECT_EQ(e.name, "he1");
  EXPECT_EQ(e.motor, (std::array{12.42, 0.0, 0.9, 0.0, 0.0}));
  ASSERT_TRUE(in.next(e));
  EXPECT_EQ(e.value, (std::array{-29.5, 16.0, -35.0}));
  EXPECT_FALSE(in.next(e));
  SparkEffectors bad("(he1 1 2)");
  EXPECT_FALSE(bad.next(e));
  EXPECT_EQ(bad.error(), SparkError::missing);
}

TEST(SimSpark, OrdersOfMonitorsAreRead) {
  SparkOrders in(
      "(kickOff Left)(playMode PlayOn)(ball (pos 1 2 0.1)(vel 3 0 0))(agent (unum 4)(team Right)(move 1 2 0.3 -90))"
      "(time 12.5)(score (left 2)(right 1))(dropBall)(kill (unum 1)(team Left))(reqfullstate)(killsim)(dance 1)");
  SparkOrder o;
  using Kind = SparkOrder::Kind;
  std::vector<Kind> kinds;
  while (in.next(o)) {
    kinds.push_back(o.kind);
    if (o.kind == Kind::ball) {
      EXPECT_EQ(o.position, (std::array{1.0, 2.0, 0.1}));
      EXPECT_EQ(o.velocity, (std::array{3.0, 0.0, 0.0}));
      EXPECT_TRUE(o.has_position && o.has_velocity);
    }
    if (o.kind == Kind::player) {
      EXPECT_EQ(o.name, "Right");
      EXPECT_EQ(o.number, 4u);
      EXPECT_EQ(o.degrees, -90);
    }
    if (o.kind == Kind::score) {
      EXPECT_EQ(o.value, (std::array{2.0, 1.0}));
    }
  }
  EXPECT_EQ(in.error(), SparkError::none);
  EXPECT_EQ(kinds,
            (std::vector{Kind::kick_off, Kind::play_mode, Kind::ball, Kind::player, Kind::time, Kind::score,
                         Kind::drop_ball, Kind::kill_player, Kind::request_state, Kind::kill_server, Kind::other}));
  for (const char* bad : {"(ball)", "(agent (unum 1))", "(kickOff)", "(time)", "(ball (pos 1 2))"}) {
    SparkOrders wrong(bad);
    EXPECT_FALSE(wrong.next(o)) << bad;
    EXPECT_EQ(wrong.error(), SparkError::missing) << bad;
  }
}

TEST(SimSpark, ABlindAgentsSeeHasABlankBehindItsName) {
  SparkPercepts nothing;
  nothing.has_see = true;
  std::array<char, 64> buffer;
  const auto frame = SparkWriter(buffer).percepts(nothing).frame();
  EXPECT_EQ(std::string_view(frame.data() + 4, frame.size() - 4), "(time (now 0.00))(See )");
  EXPECT_TRUE(parsed({frame.data() + 4, frame.size() - 4}).has_see);
}

TEST(SimSpark, OldServersHearWithoutATeamAndWhatIsUnknownIsCounted) {
  const SparkPercepts& p = parsed("(hear 1.0 -30 x)(BAT 1)(TCH (n a) (val 0))(See (mypos 1 2 3))");
  ASSERT_EQ(p.hears, 1u);
  EXPECT_EQ(p.heard[0].team, "");
  EXPECT_EQ(p.heard[0].direction_deg, -30);
  EXPECT_EQ(p.unknown, 3u);
  EXPECT_TRUE(p.has_see);
}

TEST(SimSpark, ErrorsAreNamedAndLeaveWhatWasBefore) {
  EXPECT_EQ(error_of("(time (now 1)"), SparkError::parenthesis);
  EXPECT_EQ(error_of("(time (now 1))) "), SparkError::parenthesis);
  EXPECT_EQ(error_of("time"), SparkError::text);
  EXPECT_EQ(error_of("(time (now \x01))"), SparkError::text);
  EXPECT_EQ(error_of("(time (now one))"), SparkError::number);
  EXPECT_EQ(error_of("(GYR (n torso) (rt 1 2))"), SparkError::missing);
  EXPECT_EQ(error_of("(GYR (n torso))"), SparkError::missing);
  EXPECT_EQ(error_of("(HJ (n a))"), SparkError::missing);
  EXPECT_EQ(error_of("(See (L (pol 1 2 3)))"), SparkError::missing);
  EXPECT_EQ(error_of("(hear 1)"), SparkError::missing);
  EXPECT_EQ(error_of(std::string(64, '(')), SparkError::depth);
  std::string joints;
  for (int i = 0; i < 33; ++i) joints += "(HJ (n a) (ax 1))";
  SparkPercepts p;
  EXPECT_EQ(parse_spark_percepts(joints, p), SparkError::too_many);
  EXPECT_EQ(p.joints, 32u);
}

TEST(SimSpark, EffectorsAreReadAsAgentsWriteThem) {
  std::array<char, 512> buffer;
  SparkWriter out(buffer);
  out.scene("rsg/agent/nao/nao.rsg").init(3, "SINEW").beam(-1.5, 0.25, 90).effector("lle3", -1.25).say("abc").sync();
  const auto frame = out.frame();
  const std::string_view text(frame.data() + 4, frame.size() - 4);
  EXPECT_EQ(
      text,
      "(scene rsg/agent/nao/nao.rsg)(init (unum 3)(teamname SINEW))(beam -1.50 0.25 90.00)(lle3 -1.250000)(say abc)"
      "(syn)");
  SparkEffectors in(text);
  SparkEffector e;
  using Kind = SparkEffector::Kind;
  ASSERT_TRUE(in.next(e));
  EXPECT_EQ(e.kind, Kind::scene);
  EXPECT_EQ(e.name, "rsg/agent/nao/nao.rsg");
  ASSERT_TRUE(in.next(e));
  EXPECT_EQ(e.kind, Kind::init);
  EXPECT_EQ(e.name, "SINEW");
  EXPECT_EQ(e.number, 3u);
  ASSERT_TRUE(in.next(e));
  EXPECT_EQ(e.kind, Kind::beam);
  EXPECT_EQ(e.value, (std::array{-1.5, 0.25, 90.0}));
  ASSERT_TRUE(in.next(e));
  EXPECT_EQ(e.kind, Kind::joint);
  EXPECT_EQ(e.name, "lle3");
  EXPECT_EQ(e.value[0], -1.25);
  ASSERT_TRUE(in.next(e));
  EXPECT_EQ(e.kind, Kind::say);
  ASSERT_TRUE(in.next(e));
  EXPECT_EQ(e.kind, Kind::sync);
  EXPECT_FALSE(in.next(e));
  EXPECT_EQ(in.error(), SparkError::none);
}

TEST(SimSpark, AnAgentMayWriteOtherwise) {
  SparkEffectors in(
      "(init (teamname X)(unum 0))\r\n ( he1   0.5 )(pass)(scene rsg/agent/nao/nao_hetero.rsg 4)(dance (a b)) (he2 "
      "x)(rae1");
  SparkEffector e;
  using Kind = SparkEffector::Kind;
  std::vector<Kind> kinds;
  while (in.next(e)) {
    kinds.push_back(e.kind);
    EXPECT_EQ(e.type, e.kind == Kind::scene ? 4u : 0u);
  }
  EXPECT_EQ(kinds, (std::vector{Kind::init, Kind::joint, Kind::pass, Kind::scene, Kind::other, Kind::other}));
  EXPECT_EQ(in.error(), SparkError::parenthesis);
}

TEST(SimSpark, FramesAreCutWhereverThePiecesEndAndLongOnesAreSkipped) {
  std::array<char, 8> buffer;
  SparkFrames frames(buffer);
  using namespace std::string_view_literals;
  std::vector<std::string> texts;
  for (const char c : "\0\0\0\5(syn)\0\0\0\0\0\0\0\x9too long!\0\0\0\3(a)\0\0"sv)
    if (frames.push(c)) texts.emplace_back(frames.text());
  EXPECT_EQ(texts, (std::vector<std::string>{"(syn)", "", "(a)"}));
  EXPECT_EQ(frames.dropped(), 1u);
  frames.reset();
  for (const char c : "\0\0\0\2ok"sv)
    if (frames.push(c)) texts.emplace_back(frames.text());
  EXPECT_EQ(texts.back(), "ok");
  EXPECT_EQ(frames.dropped(), 1u);
}

TEST(SimSpark, WhatDoesNotFitIsNotSent) {
  std::array<char, 12> buffer;
  EXPECT_TRUE(SparkWriter(buffer).effector("he1", 1).frame().empty());
  EXPECT_EQ(SparkWriter(buffer).sync().frame().size(), 9u);
  std::array<char, 3> none;
  EXPECT_TRUE(SparkWriter(none).frame().empty());
}

}  // namespace
}  // namespace sinew::wire::simspark_test
