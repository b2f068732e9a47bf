#include "behaviour/tree.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "rt/exec/discrete_executor.hpp"
#include "rt/exec/module_rig.hpp"

namespace sinew::behaviour {
namespace {

using namespace std::chrono_literals;
using msg::text;

struct Board {
  double ball_m = 5, walk_mps = 0;
  bool seen = false;
  int kicks = 0;
};

/// search -> approach (calls go_to(near_m)) -> kick -> search; a lost ball always leads back to search.
void build(Tree<Board>& tree) {
  auto& play = tree.option("play");
  play.always("search", "lost", [](const Board& b, Look& look) { return !look("seen", b.seen); });
  play.state("search")
      .act([](Board& b, const Here&) { b.walk_mps = 0; })
      .to("approach", "found", [](const Board& b, Look& look) { return look("seen", b.seen); });
  play.state("approach")
      .calls("go_to", [](const Board&, const Here&, Parameters& p) { p[0] = 0.2; })
      .to("kick", "arrived", [](const Board&, Look& look) { return look.done(); });
  play.state("kick")
      .act([](Board& b, const Here& here) { b.kicks += here.in_state_s == 0; })
      .to("search", "kicked", [](const Board&, Look& look) { return look.in_state_s() > 1; });
  auto& go = tree.option("go_to", {"near_m"});
  go.state("walk")
      .act([](Board& b, const Here&) { b.walk_mps = 0.3; })
      .to("there", "near", [](const Board& b, Look& look) { return look("ball_m", b.ball_m) < look.parameter(0); });
  go.state("there").act([](Board& b, const Here&) { b.walk_mps = 0; }).is_final();
}

class TreeTest : public testing::Test {
 protected:
  TreeTest() {
    build(tree_);
    EXPECT_EQ(tree_.resolve(), std::vector<std::string>{});
  }
  std::string run(Plan::Place force = {}) {
    now_.ns += 100'000'000;
    tree_.step(progress_, board_, now_, force, state_);
    std::string path;
    for (std::uint32_t i = 0; i < state_.depth; ++i)
      path +=
          (i ? " " : "") + std::string(text(state_.active[i].option)) + "/" + std::string(text(state_.active[i].state));
    return path;
  }
  Tree<Board> tree_;
  Progress progress_;
  Board board_;
  Time now_{0};
  msg::BehaviourState state_;
};

TEST_F(TreeTest, GoesFromStateToStateAndSaysWhy) {
  EXPECT_EQ(run(), "play/search");
  board_.seen = true;
  EXPECT_EQ(run(), "play/approach go_to/walk");
  EXPECT_EQ(board_.walk_mps, 0.3);
  EXPECT_EQ(text(state_.active[0].decision), "found");
  EXPECT_EQ(text(state_.active[1].decision), "");
  EXPECT_EQ(state_.active[1].parameter[0], 0.2);
  EXPECT_EQ(state_.changes, 1U);
  board_.ball_m = 0.1;
  EXPECT_EQ(run(), "play/approach go_to/there");
  EXPECT_EQ(state_.done, 2U);
  EXPECT_EQ(board_.walk_mps, 0);
  const auto end = state_.read.begin() + state_.reads;
  const auto ball = std::find_if(state_.read.begin(), end, [](const auto& r) { return text(r.name) == "ball_m"; });
  ASSERT_NE(ball, end);
  EXPECT_EQ(ball->value, 0.1);
  EXPECT_EQ(ball->depth, 1U);
  msg::BehaviourPlan plan;
  tree_.plan().describe("force", plan);
  EXPECT_EQ(text(plan.decision[ball->decision].name), text(state_.active[1].decision));
  EXPECT_EQ(ball->decision, state_.active[1].decision_place);
  EXPECT_EQ(run(), "play/kick");
  EXPECT_EQ(state_.active[0].entered, Time{100'000'000});
  EXPECT_EQ(state_.active[0].state_entered, now_);
  for (int i = 0; i < 10; ++i) EXPECT_EQ(run(), "play/kick");
  EXPECT_EQ(board_.kicks, 1);
  EXPECT_EQ(run(), "play/search");
  EXPECT_EQ(text(state_.active[0].decision), "kicked");
}

TEST_F(TreeTest, ADecisionOfAllStatesComesFirstAndEndsWhatIsBelow) {
  board_.seen = true;
  board_.ball_m = 0.1;
  run(), run();
  EXPECT_EQ(run(), "play/kick");
  board_.seen = false;
  EXPECT_EQ(run(), "play/search");
  EXPECT_EQ(text(state_.active[0].decision), "lost");
  board_.seen = true;
  board_.ball_m = 5;
  EXPECT_EQ(run(), "play/approach go_to/walk");
  EXPECT_EQ(state_.active[1].entered, now_);
}

TEST_F(TreeTest, TwoStatesThatRunTheSameOptionOneAfterTheOtherBeginItTwice) {
  Tree<Board> tree;
  const auto done = [](const Board&, Look& look) { return look.done(); };
  auto& root = tree.option("root");
  root.state("first").calls("walk").to("second", "there", done);
  root.state("second").calls("walk").to("end", "there", done);
  root.state("end").is_final();
  auto& walk = tree.option("walk");
  walk.state("go").to("there", "late", [](const Board&, Look& look) { return look.in_option_s() >= 1; });
  walk.state("there").is_final();
  ASSERT_EQ(tree.resolve(), std::vector<std::string>{});
  std::string path;
  for (int i = 0; i < 6; ++i) {
    now_.ns += 1'000'000'000;
    tree.step(progress_, board_, now_, {}, state_);
    for (std::uint32_t d = 0; d < state_.depth; ++d) path += std::string(text(state_.active[d].state)) + " ";
  }
  EXPECT_EQ(path, "first go first there second go second there end end ");
}

TEST_F(TreeTest, AForcedStateIsHeldAndLetGo) {
  const Plan::Place kick = tree_.plan().find("play/kick");
  EXPECT_EQ(run(kick), "play/kick");
  EXPECT_EQ(state_.forced, 1U);
  for (int i = 0; i < 20; ++i) EXPECT_EQ(run(kick), "play/kick");
  EXPECT_EQ(state_.changes, 0U);
  EXPECT_EQ(run(), "play/search");
  EXPECT_EQ(state_.forced, 0U);
  EXPECT_EQ(run(tree_.plan().find("go_to/there")), "play/search");  // not active: nothing to hold
  board_.seen = true;
  EXPECT_EQ(run(tree_.plan().find("go_to/there")), "play/approach go_to/there");
  EXPECT_EQ(tree_.plan().find("play/fly").option, kNone);
  EXPECT_EQ(tree_.plan().find("play").option, kNone);
  for (const std::int64_t none : {-1, 0, 6}) EXPECT_EQ(tree_.plan().numbered(none).option, kNone);
  EXPECT_EQ(tree_.plan().numbered(3).state, kick.state);
  EXPECT_EQ(tree_.plan().numbered(5).option, 1U);
  EXPECT_EQ(tree_.plan().numbered(5).state, 1U);
}

TEST_F(TreeTest, MoreReadsThanTheMessageHasRoomForAreCounted) {
  Tree<Board> tree;
  auto& root = tree.option("root");
  root.state("a").to("b", "never", [](const Board&, Look& look) {
    for (int i = 0; i < 30; ++i) look("value", 1.0 * i);
    return false;
  });
  root.state("b").is_final();
  ASSERT_TRUE(tree.resolve().empty());
  tree.step(progress_, board_, Time{1}, {}, state_);
  EXPECT_EQ(state_.reads, msg::kMaxDecisionReads);
  EXPECT_EQ(state_.reads_dropped, 30 - msg::kMaxDecisionReads);
}

TEST_F(TreeTest, IsDrawn) {
  const std::string dot = tree_.plan().graphviz(), mermaid = tree_.plan().mermaid();
  EXPECT_NE(dot.find("\"play/approach\" -> \"play/kick\" [label=\"arrived\"]"), std::string::npos) << dot;
  EXPECT_NE(dot.find("\"play/approach\" -> \"go_to/walk\" [style=dashed"), std::string::npos) << dot;
  EXPECT_NE(mermaid.find("play__approach --> play__kick : arrived"), std::string::npos) << mermaid;
  EXPECT_NE(dot.find("[label=\"5 there\", peripheries=2]"), std::string::npos) << dot;
  EXPECT_NE(mermaid.find("go_to__walk : 4 walk"), std::string::npos) << mermaid;
  EXPECT_NE(mermaid.find("go_to__there --> [*]"), std::string::npos) << mermaid;
}

TEST_F(TreeTest, ThePlanIsAMessageWithEveryNameInItsPlace) {
  msg::BehaviourPlan plan;
  tree_.plan().describe("force", plan);
  EXPECT_EQ(text(plan.force), "force");
  ASSERT_EQ(plan.options, 2U);
  ASSERT_EQ(plan.states, 5U);
  EXPECT_EQ(text(plan.option[1].name), "go_to");
  EXPECT_EQ(text(plan.option[1].parameter[0].name), "near_m");
  EXPECT_EQ(text(plan.option[1].parameter[1].name), "");
  for (std::uint32_t s = 0; s < plan.states; ++s) {  // the number by which it is held
    const Plan::Place place = tree_.plan().numbered(s + 1);
    EXPECT_EQ(plan.state[s].option, place.option);
    EXPECT_EQ(text(plan.state[s].name), tree_.plan().options[place.option].states[place.state].name);
  }
  EXPECT_EQ(plan.state[1].calls, 1U);  // approach runs go_to
  EXPECT_EQ(plan.state[2].calls, msg::kNoPlace);
  EXPECT_EQ(plan.state[4].is_final, 1U);
  // `lost` leads from every state of `play` to its first.
  EXPECT_EQ(text(plan.decision[0].name), "lost");
  EXPECT_EQ(plan.decision[0].from, msg::kNoPlace);
  EXPECT_EQ(plan.decision[0].to, 0U);
  const msg::PlanDecision& last = plan.decision[plan.decisions - 1];
  EXPECT_EQ(last.option, 1U);
  EXPECT_EQ(text(plan.state[last.from].name), "walk");
  EXPECT_EQ(text(plan.state[last.to].name), "there");
}

TEST_F(TreeTest, ThePlanIsToldAtTheFirstStepAndAgainEachFiveSeconds) {
  std::string told;
  for (int s = 0; s <= 11; ++s)
    if (progress_.tells_plan(Time{7'000'000'000 + s * 1'000'000'000LL})) told += std::to_string(s) + " ";
  EXPECT_EQ(told, "0 5 10 ");
}

bool never(const Board&, Look&) { return false; }

TEST(Plan, EachProblemIsASentence) {
  Tree<Board> tree;
  auto& root = tree.option("root");
  root.state("a").to("b", "go", never).to("nowhere", "lost", never).calls("loop");
  root.state("b");
  root.state("c").to("a", "back", never).calls("missing");
  root.state("Big Name").to("a", "back", never);
  tree.option("loop").state("x").calls("root").is_final();
  auto& alone = tree.option("alone");
  alone.state("x").to("y", "go", never);
  alone.state("y").to("x", "back", never).is_final();
  tree.option("empty");
  const std::vector<std::string> expected{
      "option 'root': state 'a': decision 'lost' leads to 'nowhere', which is no state of this option",
      "option 'root': state 'c': it calls 'missing', which is no option",
      "option 'root': state 'Big Name' is no name: 1 to 23 of a-z, 0-9 and _",
      "option 'empty': it has no state",
      "option 'root': state 'b': no decision leads out of it, and it is not final",
      "option 'root': state 'c': no decision leads to it",
      "option 'root': state 'Big Name': no decision leads to it",
      "option 'alone': state 'y': it is final, but a decision leads out of it",
      "option 'root': it calls itself, by itself or by others",
      "option 'alone': no state that can be active calls it",
      "option 'empty': no state that can be active calls it"};
  EXPECT_EQ(tree.resolve(), expected);
  Progress progress;
  Board board;
  msg::BehaviourState state;
  tree.step(progress, board, Time{1}, {}, state);
  EXPECT_EQ(state.depth, 0U);
}

TEST(Plan, AnOptionIsNotCalledDeeperThanTheMessageHasRoomFor) {
  const auto problems = [](std::size_t depth) {
    Tree<Board> tree;
    for (std::size_t i = 0; i < depth; ++i) {
      auto& state = tree.option("o" + std::to_string(i)).state("x").is_final();
      if (i + 1 < depth) state.calls("o" + std::to_string(i + 1));
    }
    return tree.resolve();
  };
  EXPECT_TRUE(problems(msg::kMaxBehaviourDepth).empty());
  EXPECT_FALSE(problems(msg::kMaxBehaviourDepth + 1).empty());
}

TEST(Plan, MoreThanItsMessageHasRoomForIsAProblem) {
  Tree<Board> tree;
  auto& root = tree.option("root");
  for (std::size_t i = 0; i <= msg::kMaxPlanStates; ++i) {
    auto& state = root.state("s" + std::to_string(i));
    const std::string next = "s" + std::to_string(i == msg::kMaxPlanStates ? 0 : i + 1);
    for (const char* name : {"a", "b"}) state.to(next, name, never);
  }
  EXPECT_EQ(tree.resolve(), (std::vector<std::string>{"the plan has 65 states, at most 64",
                                                      "the plan has 130 decisions, at most 128"}));
}

/// A module with a tree: parameters and the forced state change while it runs; no step allocates (the rig's trap).
class Player final : public rt::Module {
 public:
  void declare(rt::Declaration& d) override {
    d.out("behaviour", behaviour_);
    d.param("force", force_, {.min = 0, .max = 5, .doc = "number of the state that is held; 0: none"});
    d.state(progress_);
  }
  hal::Status configure(rt::Setup& setup) override {
    build(tree_);
    if (!explain(tree_.resolve(), setup)) return hal::Error{hal::Errc::bad_argument};
    return {};
  }
  void reset() override { progress_ = {}; }
  rt::StepStatus step(const rt::Step& step) noexcept override {
    tree_.step(progress_, board_, step.now, tree_.plan().numbered(force_), behaviour_.loan());
    return rt::StepStatus::ok;
  }

 private:
  rt::Out<msg::BehaviourState> behaviour_;
  std::int64_t force_ = 0;
  Tree<Board> tree_;
  Progress progress_;
  Board board_;
};

TEST(Player, IsForcedByAParameterWhileItRuns) {
  Player player;
  rt::ModuleRig rig(player);
  const auto state = [&](std::int64_t ms) {
    EXPECT_EQ(rig.step(Time{ms * 1'000'000}, 100ms), rt::StepStatus::ok);
    return std::string(text(rig.get<msg::BehaviourState>("behaviour")->active[0].state));
  };
  EXPECT_EQ(state(100), "search");
  rig.set("force", std::int64_t{2});
  EXPECT_EQ(state(200), "approach");
  rig.set("force", std::int64_t{0});
  EXPECT_EQ(state(300), "search");
}

/// Reads the topic as another module does.
class Watch final : public rt::Module {
 public:
  explicit Watch(std::string& last) : last_(last) {}
  void declare(rt::Declaration& d) override { d.in("behaviour", in_); }
  rt::StepStatus step(const rt::Step&) noexcept override {
    if (const auto* state = in_.get()) last_ = text(state->active[0].state);  // fits into the string itself
    return rt::StepStatus::ok;
  }

 private:
  rt::In<msg::BehaviourState> in_;
  std::string& last_;
};

TEST(Player, IsForcedInAGraphByARequestAsTheRobotsSocketMakesIt) {
  std::string last;
  rt::ModuleTypes types;
  types.add<Player>("Player");
  types.add("Watch", [&] { return std::make_unique<Watch>(last); });
  const rt::ExecModel ten_us{rt::ExecModel::Kind::constant, 10us, {}, 1};
  rt::Graph graph(
      {.threads = {{.name = "loop", .priority = 10, .period = 10ms, .order = {{"play"}, {"watch"}}}},
       .modules = {{.name = "play", .type = "Player", .exec = ten_us},
                   {.name = "watch", .type = "Watch", .in = {{"behaviour", {"play.behaviour"}}}, .exec = ten_us}}},
      types);
  hal::EmptyBoard board;
  ASSERT_TRUE(graph.check({.virtual_time = true}).empty());
  ASSERT_TRUE(graph.configure(board));
  std::string why;
  EXPECT_FALSE(graph.set_param("play", "force", std::int64_t{6}, &why));  // the plan has five states
  ASSERT_TRUE(graph.set_param("play", "force", std::int64_t{3}, &why)) << why;
  hal::ManualClock clock;
  hal::FixedGrant grants(hal::Time{1'000'000'000});
  rt::DiscreteExecutor executor(graph, clock, grants, {.duration = 1s});
  ASSERT_TRUE(executor.run());
  EXPECT_EQ(last, "kick");
}

/// A module whose plan has a problem.
class Broken final : public rt::Module {
 public:
  void declare(rt::Declaration& d) override { d.out("behaviour", behaviour_); }
  hal::Status configure(rt::Setup& setup) override {
    tree_.option("play").state("stuck");
    if (!explain(tree_.resolve(), setup)) return hal::Error{hal::Errc::bad_argument};
    return {};
  }
  rt::StepStatus step(const rt::Step&) noexcept override { return rt::StepStatus::ok; }

 private:
  rt::Out<msg::BehaviourState> behaviour_;
  Tree<Board> tree_;
};

TEST(Player, DoesNotStartWithAPlanThatHasAProblem) {
  Broken broken;
  rt::ModuleRig rig(broken);
  EXPECT_FALSE(rig.configure());
  ASSERT_FALSE(rig.problems().empty());
  const std::string said = rt::to_string(rig.problems()[0], "robot.toml");
  EXPECT_NE(said.find("state 'stuck': no decision leads out of it"), std::string::npos) << said;
}

}  // namespace
}  // namespace sinew::behaviour
