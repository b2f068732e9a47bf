// Every problem of a robot file in one run, as file:line: key: value: what is allowed.
#include <cstdio>

#include "apps/module_list.hpp"
#include "apps/robot_file/robot_file.hpp"
#include "rt/graph.hpp"

int main(int argc, char** argv) {
  using namespace sinew;
  if (argc != 2) return 2;
  const app::LoadedRobot loaded = app::load_robot(argv[1]);
  auto problems = loaded.problems;
  const rt::Graph graph(loaded.robot.graph, app::all_modules());
  for (auto& p : graph.check({.virtual_time = true})) problems.push_back(std::move(p));
  for (const auto& p : problems) std::printf("%s\n", rt::to_string(p, argv[1]).c_str());
  return problems.size() >= 4 ? 0 : 1;  // broken_robot.toml has at least these four
}
