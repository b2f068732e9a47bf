#include "soccer/play/player_tree.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <sstream>

#include "math/random.hpp"

namespace sinew::test {
std::string source_dir();
}

namespace sinew::soccer::player_test {
namespace {

using msg::GamePhase;

constexpr double kStep_s = 0.05, kQuarter = 0.5 * math::kPi;
constexpr double kKickBy_m = 0.04;  // a ball that lies farther from where a kick wants it is missed

/// A field on which robots go where they want, and a kick that is well placed moves the ball at once.
struct Game {
  PlayOptions options;
  Field field;
  behaviour::Tree<PlayBoard> tree;
  behaviour::Progress progress;
  msg::BehaviourState state;
  PlayBoard board;
  FieldAt robot{-1, 0.5, 0};
  FieldPoint ball{0, 0};
  double now_s = 0;
  int kicks = 0, missed = 0;
  bool sees = true;

  Game() {
    options.kicks.kinds = {{{msg::BallMotion::kick_forward, false, {0.15, 0.05}, 0, 1.3, 3},
                            {msg::BallMotion::kick_outward, false, {0, 0.2}, kQuarter, 1.2, 3},
                            {msg::BallMotion::kick_forward, true, {0.2, 0.05}, 0, 0.9, 0.5},
                            {msg::BallMotion::kick_outward, true, {0, 0.2}, kQuarter, 0.4, 0.5}}};
    add_player(tree);
    const auto problems = tree.resolve();
    EXPECT_TRUE(problems.empty()) << problems.front();
    board.on_feet = board.may_move = board.found = true;
  }
  std::string doing() const {
    std::string out;
    for (std::uint32_t i = 0; i < state.depth; ++i)
      out += (i ? "/" : "") + std::string(msg::text(state.active[i].option)) + ":" +
             std::string(msg::text(state.active[i].state));
    return out;
  }
  void step() {
    PlayBoard& b = board;
    b.options = &options, b.field = &field, b.now_s = now_s, b.self = robot;
    b.ball = robot.in(ball.x_m, ball.y_m);
    b.ball_age_s = sees ? 0 : math::kInf;
    b.ball_at = ball, b.ball_known = sees;
    b.kick_done |= b.kicks;  // of the step before
    b.kicks = false, b.walk = {};
    const auto ns = static_cast<std::int64_t>(now_s * 1e9);
    tree.step(progress, b, msg::Time{ns}, {}, state);
    robot = robot.then({kStep_s * b.walk.forward_mps, kStep_s * b.walk.left_mps, kStep_s * b.walk.turn_radps});
    if (b.kicks) b.kick_done = false;
    if (b.kicks && b.ask.motion != msg::BallMotion::stop) kick();
    now_s += kStep_s;
  }
  void kick() {
    const KickKind& kind = options.kicks.kinds[board.chosen.kind];
    const double side = board.ask.foot == msg::Foot::left ? 1 : -1;
    const FieldPoint off = board.ball - FieldPoint{kind.ball.x_m, side * kind.ball.y_m};
    ++kicks;
    if (length_m(off) > kKickBy_m) {
      ++missed;
      return;
    }
    const FieldAt way{ball.x_m, ball.y_m, robot.heading_rad + side * kind.direction_rad};
    ball = way.out(kind.rolls_m, 0);
  }
  bool scored() const {
    return ball.x_m > 0.5 * field.size().length_m && math::fabs(ball.y_m) < 0.5 * field.size().goal_width_m;
  }
};

TEST(Player, BringsTheBallIntoTheGoalFromAnywhereWithoutAMissedKick) {
  math::Random random(1);
  for (int game_number = 0; game_number < 20; ++game_number) {
    Game game;
    game.robot = {random.uniform(-4, 4), random.uniform(-2.5, 2.5), random.uniform(-3, 3)};
    game.ball = {random.uniform(-3.5, 3.5), random.uniform(-2.5, 2.5)};
    while (!game.scored() && game.now_s < 180) game.step();
    EXPECT_TRUE(game.scored()) << "game " << game_number << ", ball at " << game.ball.x_m << ' ' << game.ball.y_m
                               << ", " << game.doing();
    EXPECT_EQ(game.missed, 0) << "of " << game.kicks;
  }
}

TEST(Player, ThePageDrawsItsStates) {
  behaviour::Tree<PlayBoard> tree;
  add_player(tree);
  ASSERT_TRUE(tree.resolve().empty());
  const std::string path = test::source_dir() + "/docs/soccer-play.md", begin = "```mermaid\n", end = "```\n";
  std::ostringstream read;
  read << std::ifstream(path).rdbuf();
  std::string is = read.str();
  const std::size_t from = is.find(begin), to = from == is.npos ? from : is.find(end, from + begin.size());
  ASSERT_NE(to, is.npos) << path << " has no drawing";
  std::string should = is.substr(0, from) + begin + tree.plan().mermaid() + is.substr(to);
  if (std::getenv("SINEW_WRITE_DOCS")) std::ofstream(path) << should, is = should;
  EXPECT_EQ(is, should) << "docs/soccer-play.md differs from the states; SINEW_WRITE_DOCS=1 writes it";
}

TEST(Player, SearchesABallThatItDoesNotSee) {
  Game game;
  game.sees = false;
  double turned_rad = 0;
  for (int i = 0; i < 600; ++i) game.step(), turned_rad += kStep_s * math::fabs(game.board.walk.turn_radps);
  EXPECT_GT(turned_rad, 2 * math::kPi);
  EXPECT_EQ(game.kicks, 0);
  game.sees = true;
  for (int i = 0; i < 3; ++i) game.step();
  EXPECT_NE(game.doing().find("striker:approach"), std::string::npos) << game.doing();
}

TEST(Player, GoesToItsPlaceInReadyAndStandsInSet) {
  Game game;
  game.board.phase = GamePhase::ready;
  game.board.player = 2;
  for (int i = 0; i < 600; ++i) game.step();
  // Nobody has said whose kick-off it is: outside of the circle, where nobody may find fault with it.
  EXPECT_LT(distance_m(game.robot, ready_place(2, false, game.field)), 0.05);
  EXPECT_GT(math::hypot(game.robot.x_m, game.robot.y_m), game.field.size().circle_radius_m + 0.1);
  game.board.kick_of = msg::GameKick::own;
  for (int i = 0; i < 600; ++i) game.step();
  EXPECT_LT(distance_m(game.robot, ready_place(2, true, game.field)), 0.05);
  game.board.phase = GamePhase::set;
  const FieldAt there = game.robot;
  for (int i = 0; i < 20; ++i) game.step();
  EXPECT_EQ(distance_m(game.robot, there), 0);
}

TEST(Player, LeavesTheBallToTheOthersForTheirKickOffUntilItMoves) {
  Game game;
  game.board.phase = GamePhase::set;
  game.step();
  game.board.phase = GamePhase::playing;
  game.board.kick_of = msg::GameKick::other;
  for (int i = 0; i < 200; ++i) game.step();
  EXPECT_NE(game.doing().find("play:wait"), std::string::npos) << game.doing();
  game.ball = {0.5, 0.3};
  for (int i = 0; i < 3; ++i) game.step();
  EXPECT_NE(game.doing().find("striker"), std::string::npos) << game.doing();
}

TEST(Player, StandsWhilePenalisedLyingOrNotAllowedToMove) {
  for (bool PlayBoard::*what : {&PlayBoard::penalised, &PlayBoard::on_feet, &PlayBoard::may_move}) {
    Game game;
    game.board.*what = what == &PlayBoard::penalised;
    for (int i = 0; i < 100; ++i) game.step();
    EXPECT_EQ(game.doing(), "game:halt");
    game.board.*what = !(game.board.*what);
    for (int i = 0; i < 100; ++i) game.step();
    EXPECT_NE(game.doing().find("striker"), std::string::npos) << game.doing();
  }
}

TEST(Player, AGoalieStandsBetweenBallAndGoalStopsWhatComesAndClearsWhatIsNear) {
  Game game;
  game.board.role = msg::SoccerRole::goalie;
  game.ball = {-1, 1.5};
  for (int i = 0; i < 800; ++i) game.step();
  const FieldPoint goal{-0.5 * game.field.size().length_m, 0};
  const FieldPoint self = FieldPoint{game.robot.x_m, game.robot.y_m} - goal;
  EXPECT_NEAR(bearing_rad(self), bearing_rad(game.ball - goal), 0.1);
  EXPECT_LT(length_m(self), 0.6);
  game.board.ball_mps = -0.6 * (1 / length_m(game.board.ball)) * game.board.ball;
  game.ball = game.robot.out(1, 0.2);
  game.step();
  game.step();
  EXPECT_EQ(game.board.ask.motion, msg::BallMotion::stop);
  EXPECT_EQ(game.board.ask.foot, msg::Foot::left);
  game.board.ball_mps = {0, 0};
  game.ball = {goal.x_m + 1, 0.2};
  for (int i = 0; i < 10; ++i) game.step();
  EXPECT_NE(game.doing().find("goalie:clear"), std::string::npos) << game.doing();
}

TEST(Player, ASupporterWaitsBehindTheBallAndTheStrikerGoesToIt) {
  Game game;
  game.board.role = msg::SoccerRole::supporter;
  game.ball = {1, 0.5};
  for (int i = 0; i < 800; ++i) game.step();
  EXPECT_LT(game.robot.x_m, game.ball.x_m - 1);
  EXPECT_EQ(game.kicks, 0);
}

}  // namespace
}  // namespace sinew::soccer::player_test
