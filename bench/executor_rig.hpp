#pragma once
// A robot of one thread for measuring the real-time executor: modules without ports, no device.
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>

#include "hal/board.hpp"
#include "rt/exec/real_time_executor.hpp"
#include "rt/graph.hpp"

namespace sinew::bench {

class Empty final : public rt::Module {
 public:
  void declare(rt::Declaration&) override {}
  rt::StepStatus step(const rt::Step&) noexcept override { return rt::StepStatus::ok; }
};

/// A checked and configured graph of one periodic thread with `modules` empty modules. Ends the program if that fails.
inline std::unique_ptr<rt::Graph> one_thread(const rt::ThreadSpec& thread, int modules = 1) {
  rt::GraphSpec spec;
  spec.robot = "bench";
  spec.threads.push_back(thread);
  rt::ModuleTypes types;
  types.add<Empty>("bench::Empty");
  for (int i = 0; i < modules; ++i) {
    rt::ModuleSpec m;
    m.name = "empty" + std::to_string(i);
    m.type = "bench::Empty";
    spec.threads[0].order.push_back({m.name, 0});
    spec.modules.push_back(m);
  }
  auto graph = std::make_unique<rt::Graph>(std::move(spec), types);
  for (const auto& p : graph->check({})) std::fprintf(stderr, "%s\n", rt::to_string(p, "bench").c_str());
  hal::EmptyBoard board;
  if (!graph->check({}).empty() || !graph->configure(board)) std::exit(2);
  return graph;
}

}  // namespace sinew::bench
