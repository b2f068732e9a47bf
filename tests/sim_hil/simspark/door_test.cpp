// The door of SimSpark without sockets: an agent that is written from the protocol, and what it gets.
#include <array>

#include "rig.hpp"
#include "sim_hil/simspark/frame.hpp"

namespace sinew::simspark::door_test {
namespace {

using wire::SparkError;
using wire::SparkPercepts;
using wire::SparkSeen;

SparkPercepts percepts_of(const std::string& text) {
  SparkPercepts out;
  EXPECT_EQ(parse_spark_percepts(text, out), SparkError::none) << text;
  return out;
}
const SparkSeen* find(const SparkPercepts& p, std::string_view name) {
  for (std::size_t i = 0; i < p.sightings; ++i)
    if (p.seen[i].name == name) return &p.seen[i];
  return nullptr;
}

TEST(SimsparkDoor, AnAgentConnectsBeamsStandsAndFeelsItsBody) {
  Rig rig;
  Agent& a = rig.agent();
  a.say("(scene rsg/agent/nao/nao_hetero.rsg 0)");
  auto heard = a.hear();
  ASSERT_EQ(heard.size(), 1u);  // at once, of nobody
  EXPECT_EQ(percepts_of(heard[0]).joints, 0u);
  a.say("(init (unum 7)(teamname RED))");
  EXPECT_TRUE(a.hear().empty());
  a.say("(beam -2.0 1.0 90)(syn)");
  rig.cycle();
  heard = a.hear();
  ASSERT_EQ(heard.size(), 1u);
  const std::string first = heard[0];
  SparkPercepts p = percepts_of(first);
  EXPECT_EQ(p.number, 7u);
  EXPECT_EQ(p.side, "left");
  EXPECT_EQ(p.play_mode, "BeforeKickOff");
  EXPECT_EQ(p.joints, 22u);
  EXPECT_DOUBLE_EQ(p.now_s, 0.02);
  rig.cycle(50);
  heard = a.hear();
  ASSERT_EQ(heard.size(), 50u);
  p = percepts_of(heard.back());
  EXPECT_EQ(p.number, 0u) << "its number is said once";
  EXPECT_NEAR(p.acceleration_mps2[2], 9.81, 0.2);
  EXPECT_NEAR(p.gyro_dps[0], 0, 2);
  ASSERT_EQ(p.forces, 2u);
  EXPECT_EQ(p.force[0].name, "rf");
  double weight_n = 0, mass_kg = 0;
  for (std::size_t i = 0; i < p.forces; ++i) weight_n += p.force[i].force_n[2];
  for (const auto& link : rig.body.links) mass_kg += link.mass_kg;
  EXPECT_NEAR(weight_n, 9.81 * mass_kg, 3);
  EXPECT_NEAR(mass_kg, 4.607, 0.001);
  const auto& torso = rig.truth(a).torso;
  EXPECT_NEAR(torso.p_m.x, -2, 0.2);  // with the server's noise of beams, and what a fall from 0.5 cm does
  EXPECT_NEAR(torso.p_m.y, 1, 0.2);
  const auto ahead = torso.q.rotate({1, 0, 0});
  EXPECT_GT(ahead.y, 0.9);
  EXPECT_EQ(rig.counts.unknown, 0u);
}

TEST(SimsparkDoor, AMotorTurnsAtItsSpeedInSimSparksDirectionAndThenHolds) {
  Rig rig;
  Agent& a = rig.player("RED", 1);
  for (const SparkJointKind& kind : spark_joints()) {
    const bool bends_back = kind.perceptor == "rlj2" || kind.perceptor == "rlj1" || kind.perceptor == "llj1" ||
                            kind.perceptor == "rlj4" || kind.perceptor == "llj4" || kind.perceptor == "raj2" ||
                            kind.perceptor == "laj4";
    const double speed = bends_back ? -1.5 : 1.5;
    a.hear();
    rig.cycle();
    const double before = percepts_of(a.hear().back()).find_joint(kind.perceptor)->degrees;
    a.say("(" + std::string(kind.effector) + " " + std::to_string(speed) + ")(syn)");
    rig.cycle(10);
    a.say("(" + std::string(kind.effector) + " 0)(syn)");
    rig.cycle(5);
    const double after = percepts_of(a.hear().back()).find_joint(kind.perceptor)->degrees;
    EXPECT_NEAR(after - before, speed * 0.2 * kDegrees, 1.5) << kind.perceptor;
    rig.cycle(25);
    EXPECT_NEAR(percepts_of(a.hear().back()).find_joint(kind.perceptor)->degrees, after, 1) << kind.perceptor;
    a.say("(" + std::string(kind.effector) + " " + std::to_string(-speed) + ")(syn)");  // and back
    rig.cycle(10);
    a.say("(" + std::string(kind.effector) + " 0)(syn)");
    rig.cycle(5);
  }
}

TEST(SimsparkDoor, ItSeesBallGoalsFlagsLinesAndPlayersWhereTheyAreEveryThirdCycle) {
  Rig rig;
  Agent& a = rig.player("RED", 1);
  Agent& b = rig.player("BLUE", 4);
  a.say("(beam -3 0 0)");
  b.say("(beam -1 0.5 0)");  // of the right team: at x = 1, y = -0.5, looking at the left goal
  rig.cycle(60);
  std::size_t sees = 0;
  SparkPercepts p;
  for (const std::string& text : a.hear()) {
    const SparkPercepts now = percepts_of(text);
    if (!now.has_see) continue;
    ++sees;
  }
  EXPECT_EQ(sees, 20u);
  std::string text;
  for (; text.find("(See") == std::string::npos; text = a.hear().back()) rig.cycle();
  p = percepts_of(text);
  const auto eye = rig.truth(a).link[*rig.body.find_link("head_pitch")] * kinematics::Pose{{0, 0, 0.005}, {}};
  const auto expect_at = [&](std::string_view name, const math::Vec3& at_m) {
    const SparkSeen* seen = find(p, name);
    ASSERT_TRUE(seen) << name;
    const math::Vec3 where = eye.of(point_of(seen->at));
    EXPECT_LT(norm(where - at_m), 0.02 + 0.012 * seen->at.distance_m) << name;
  };
  expect_at("B", rig.arena->pitch().ball().p_m);
  expect_at("G1R", {15, 1.05, 0.8});
  expect_at("G2R", {15, -1.05, 0.8});
  expect_at("F1R", {15, 10, 0});
  expect_at("F2R", {15, -10, 0});
  EXPECT_FALSE(find(p, "G1L")) << "it is behind";
  std::size_t lines = 0, of_blue = 0;
  for (std::size_t i = 0; i < p.sightings; ++i) {
    const SparkSeen& s = p.seen[i];
    if (s.kind == SparkSeen::Kind::player && s.team == "BLUE" && s.number == 4) ++of_blue;
    if (s.kind != SparkSeen::Kind::line) continue;
    ++lines;
    for (const auto& end : {s.at, s.to}) EXPECT_LT(math::fabs(eye.of(point_of(end)).z), 0.03 + 0.012 * end.distance_m);
  }
  EXPECT_EQ(of_blue, 5u);
  EXPECT_GT(lines, 8u);
  EXPECT_LE(lines, spark_lines().size());
  const auto& other = rig.truth(b);
  EXPECT_NEAR(other.torso.p_m.x, 1, 0.2);
  EXPECT_NEAR(other.torso.p_m.y, -0.5, 0.2);
  EXPECT_LT(other.torso.q.rotate({1, 0, 0}).x, -0.9);
}

TEST(SimsparkDoor, SameBytesWithTheSameSeedAndOthersWithAnother) {
  const auto run = [](std::uint64_t seed) {
    Rig rig(2, seed);
    Agent& a = rig.player("RED", 1);
    std::string all;
    for (int i = 0; i < 100; ++i) {
      if (i == 0) a.say("(beam -1 0 0)");
      a.say("(lle3 " + std::to_string(i % 7 - 3) + ")(rae1 -1)(syn)");
      rig.cycle();
      for (const std::string& text : a.hear()) all += text;
    }
    return all;
  };
  const std::string one = run(1);
  EXPECT_EQ(one, run(1));
  EXPECT_NE(one, run(2));
}

TEST(SimsparkDoor, WordsAreHeardInTheNextCycleByAllWithTheirTeam) {
  Rig rig(3);
  Agent& a = rig.player("RED", 1);
  Agent& b = rig.player("RED", 2);
  Agent& c = rig.player("BLUE", 1);
  a.say("(say 12345678901234567890more)");
  rig.cycle();
  for (Agent* agent : {&a, &b, &c}) {
    const auto heard = agent->hear();
    const SparkPercepts p = percepts_of(heard.back());
    ASSERT_EQ(p.hears, 1u);
    EXPECT_EQ(p.heard[0].team, "RED");
    EXPECT_EQ(p.heard[0].text, "12345678901234567890");
    EXPECT_EQ(p.heard[0].self, agent == &a);
  }
  rig.cycle();
  const auto quiet = a.hear();
  EXPECT_EQ(percepts_of(quiet.back()).hears, 0u);
}

TEST(SimsparkDoor, BadInputClosesThatClientWithAReportAndCostsNobodyElse) {
  Rig rig(2);
  Agent& good = rig.player("RED", 1);
  good.hear();
  rig.cycle(5);
  EXPECT_EQ(good.hear().size(), 5u);
  struct Case {
    const char* text;
    const char* why;
  };
  for (const Case& c : {Case{"(lle1 1", "parenthesis"}, Case{"lle1 1", "text"}, Case{"(beam 1 2)", "missing"},
                        Case{"(beam a b c)", "number"}, Case{"(init (unum 3))", "missing"}}) {
    Agent& bad = rig.agent();
    bad.say("(scene rsg/agent/nao/nao.rsg)");
    bad.say(c.text);
    EXPECT_TRUE(bad.session().closed()) << c.text;
    EXPECT_NE(bad.session().why().find(c.why), std::string::npos) << bad.session().why();
    bad.say("(init (unum 2)(teamname EVIL))");
    EXPECT_FALSE(bad.session().player()) << "it is not heard any more";
  }
  Agent& long_one = rig.agent();
  long_one.send(std::string_view("\x7f\xff\xff\xff(syn)", 9));
  EXPECT_NE(long_one.session().why().find("65536"), std::string::npos);
  EXPECT_EQ(rig.counts.closed, 6u);
  EXPECT_EQ(rig.counts.news.size(), 7u);  // and one that plays
  rig.cycle(5);
  EXPECT_EQ(good.hear().size(), 5u);
}

TEST(SimsparkDoor, WhoIsTooMuchIsRefusedWithTheReason) {
  Rig rig(3);
  rig.player("RED", 1);
  rig.player("BLUE", 1);
  const auto refused = [&](const char* init) {
    Agent& a = rig.agent();
    a.say("(scene rsg/agent/nao/nao.rsg)");
    a.say(init);
    return a.session().why();
  };
  EXPECT_NE(refused("(init (unum 1)(teamname RED))").find("number 1 is taken"), std::string::npos);
  EXPECT_NE(refused("(init (unum 12)(teamname RED))").find("11 players"), std::string::npos);
  EXPECT_NE(refused("(init (unum 1)(teamname GREEN))").find("no third team beside RED and BLUE"), std::string::npos);
  Agent& second = rig.player("RED", 0);
  EXPECT_EQ(rig.arena->find(Team::left, 2), second.session().player());
  EXPECT_NE(refused("(init (unum 5)(teamname RED))").find("all 3 bodies are taken"), std::string::npos);
  Agent& early = rig.agent();
  early.say("(init (unum 3)(teamname RED))");
  EXPECT_NE(early.session().why().find("(init) before (scene)"), std::string::npos);
  second.leave();
  EXPECT_FALSE(rig.arena->find(Team::left, 2));
  rig.player("BLUE", 3);  // its body is free again
  EXPECT_EQ(rig.counts.refused, 5u);
}

TEST(SimsparkDoor, AClientThatDoesNotReadLosesItsOwnMessagesOnly) {
  Rig rig(2);
  Agent& lazy = rig.player("RED", 1);
  rig.cycle(600);
  EXPECT_GT(rig.counts.unsent, 0u);
  EXPECT_LE(lazy.session().waiting().size(), Connection::kMostWaiting);
}

TEST(SimsparkDoor, AMonitorKicksOffMovesTheBallAndGetsTheScore) {
  Rig rig(2);
  Agent& a = rig.player("RED", 1);
  Monitor& m = rig.monitor();
  const auto mode = [&] {
    rig.cycle();
    const auto heard = a.hear();
    return std::string(percepts_of(heard.back()).play_mode);
  };
  EXPECT_EQ(mode(), "BeforeKickOff");
  m.say("(kickOff Left)");
  EXPECT_EQ(mode(), "KickOff_Left");
  a.say("(beam -2 0 0)");
  EXPECT_EQ(rig.counts.not_now, 1u);
  m.say("(playMode PlayOn)(ball (pos 14 0.2 0.042)(vel 4 0 0))");
  for (int i = 0; i < 40 && mode() == "PlayOn"; ++i) {
  }
  EXPECT_EQ(mode(), "Goal_Left");
  EXPECT_EQ(rig.arena->game().score(Team::left), 1);
  for (int i = 0; i < 160 && mode() == "Goal_Left"; ++i) {
  }
  EXPECT_EQ(mode(), "KickOff_Right");
  EXPECT_LT(norm(rig.arena->pitch().ball().p_m), 0.1);
  const auto heard = m.hear();
  ASSERT_FALSE(heard.empty());
  EXPECT_NE(heard.front().find("(play_modes BeforeKickOff KickOff_Left"), std::string::npos);
  EXPECT_NE(heard.back().find("(score_left 1)(score_right 0)"), std::string::npos) << heard.back();
  m.say("(agent (unum 1)(team Left)(move 3 2 0.3 -90))");
  rig.cycle(5);
  EXPECT_NEAR(rig.truth(a).torso.p_m.x, 3, 0.1);
  EXPECT_GT(rig.truth(a).torso.q.rotate({1, 0, 0}).x, 0.95) << "-90 degrees look along x";
  m.say("(dance)(playMode Sleep)(killsim)");
  EXPECT_EQ(rig.counts.unknown, 2u);
  EXPECT_TRUE(m.session().kills());
}

TEST(SimsparkGame, BallsOverTheLinesAreGivenToTheOtherTeamAndHalvesEnd) {
  SparkGame game({.half_s = 10, .kick_off_after_s = 0.1});
  const math::Vec3 middle{0, 0, 0.042};
  for (int i = 0; i < 5; ++i) game.step(middle, {});
  EXPECT_EQ(game.mode(), PlayMode::kick_off_left);
  EXPECT_FALSE(game.may_beam());
  game.step({0.2, 0, 0.042}, Team::left);
  EXPECT_EQ(game.mode(), PlayMode::play_on);
  auto put = game.step({3, 10.1, 0.042}, Team::left);
  EXPECT_EQ(game.mode(), PlayMode::kick_in_right);
  ASSERT_TRUE(put);
  EXPECT_EQ(put->y, 10);
  game.set_mode(PlayMode::play_on, middle);
  put = game.step({15.1, 3, 0.042}, Team::right);
  EXPECT_EQ(game.mode(), PlayMode::corner_kick_left);
  ASSERT_TRUE(put);
  EXPECT_EQ(put->x, 15);
  game.set_mode(PlayMode::play_on, middle);
  put = game.step({15.1, 3, 0.042}, Team::left);
  EXPECT_EQ(game.mode(), PlayMode::goal_kick_right);
  game.set_mode(PlayMode::play_on, middle);
  game.step({-15.1, 0.3, 0.5}, Team::left);  // an own goal
  EXPECT_EQ(game.mode(), PlayMode::goal_right);
  EXPECT_EQ(game.score(Team::right), 1);
  while (game.half() == 1) game.step(middle, {});
  EXPECT_NEAR(game.time_s(), 10, 0.03);
  EXPECT_EQ(game.mode(), PlayMode::kick_off_right);
  for (int i = 0; i < 600; ++i) game.step(middle, {});
  EXPECT_EQ(game.mode(), PlayMode::game_over);
  EXPECT_NEAR(game.time_s(), 20, 0.03);
}

TEST(SimsparkJoints, BodiesOfTheClassOfNaoFitAndOthersAreRefusedByJoint) {
  std::string why;
  EXPECT_TRUE(SparkJointMap::of(spark_body(), why)) << why;
  EXPECT_TRUE(SparkJointMap::of(spark_body("kid/nao"), why)) << why;
  EXPECT_FALSE(SparkJointMap::of(spark_body("kid/op3"), why));
  EXPECT_NE(why.find("SimSpark's joint"), std::string::npos) << why;
  const auto map = SparkJointMap::of(spark_body(), why);
  ASSERT_TRUE(map);
  EXPECT_EQ(map->sign(1), -1) << "SimSpark's head looks up by a positive angle, ours down";
}

}  // namespace
}  // namespace sinew::simspark::door_test
