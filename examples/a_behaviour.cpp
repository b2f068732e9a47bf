// A behaviour as a hierarchical state machine: a robot walks to a ball and kicks it. docs/behaviour.md.
// With the argument --dot it prints the machine for Graphviz instead, with --mermaid for Mermaid.
#include <cstdio>
#include <cstring>

#include "behaviour/tree.hpp"
using namespace sinew;
using behaviour::Here;
using behaviour::Look;
using msg::text;

struct Board {  // what decisions read and actions write; in a module: from its inputs, and to its outputs
  double ball_m = 1, walk_mps = 0;
  bool kick = false;
};

int main(int argc, char** argv) {
  behaviour::Tree<Board> tree;
  auto& play = tree.option("play");
  play.state("approach")
      .calls("walk_to_ball", [](const Board&, const Here&, behaviour::Parameters& p) { p[0] = 0.2; })
      .to("kick", "at_ball", [](const Board&, Look& look) { return look.done(); });
  play.state("kick").is_final().act([](Board& b, const Here&) { b.kick = true; });
  auto& walk = tree.option("walk_to_ball", {"near_m"});
  walk.state("go")
      .act([](Board& b, const Here&) { b.walk_mps = 0.3; })
      .to("there", "near", [](const Board& b, Look& look) { return look("ball_m", b.ball_m) < look.parameter(0); });
  walk.state("there").is_final().act([](Board& b, const Here&) { b.walk_mps = 0; });

  for (const std::string& problem : tree.resolve()) std::printf("%s\n", problem.c_str());
  if (argc > 1) {
    const bool dot = std::strcmp(argv[1], "--dot") == 0;
    std::printf("%s", (dot ? tree.plan().graphviz() : tree.plan().mermaid()).c_str());
    return 0;
  }
  Board board;
  behaviour::Progress progress;
  msg::BehaviourState state;
  std::uint32_t changes = 0;
  for (msg::Time now{0}; !board.kick && now.ns < 10'000'000'000; now.ns += 10'000'000) {
    tree.step(progress, board, now, {}, state);
    board.ball_m -= 0.01 * board.walk_mps;
    if (state.changes == changes) continue;
    changes = state.changes;
    std::printf("%.2f s:", msg::seconds(now - msg::Time{0}));
    for (std::uint32_t i = 0; i < state.depth; ++i)
      std::printf(" %s is in %s", text(state.active[i].option).data(), text(state.active[i].state).data());
    std::printf("\n");
  }
  return board.kick && state.done == 1 ? 0 : 1;
}
