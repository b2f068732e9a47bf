// What saving a module's state costs the executor's thread, beside a plain copy of as many bytes.
//   saved_state_bench [robots/quad/quad.toml]
#include <algorithm>
#include <cstdio>
#include <cstring>
#include <vector>

#include "apps/module_list.hpp"
#include "apps/robot_file/robot_file.hpp"
#include "hal/platform.hpp"
#include "hal/silent_board.hpp"
#include "rt/graph.hpp"
#include "rt/saved_state.hpp"

namespace {

using namespace sinew;

constexpr int kBatch = 100, kBatches = 101;

template <class Work>
double best_ns(const Work& work) {
  double best = 1e18;
  for (int b = 0; b < kBatches; ++b) {
    const hal::Time before = hal::system_os().now();
    for (int i = 0; i < kBatch; ++i) work();
    best = std::min(best, static_cast<double>((hal::system_os().now() - before).count()) / kBatch);
  }
  return best;
}

}  // namespace

int main(int argc, char** argv) {
  const auto loaded = app::load_robot(argc > 1 ? argv[1] : "robots/quad/quad.toml");
  if (!loaded.problems.empty()) return 1;
  rt::Graph graph(loaded.robot.graph, app::all_modules());
  hal::SilentBoard board;
  if (!graph.configure(board)) return 1;
  std::printf("%-12s %8s %9s %9s\n", "module", "bytes", "save ns", "copy ns");
  for (const rt::GraphModule& m : graph.modules()) {
    const rt::SavedState state(m.declaration);
    std::vector<std::byte> room(state.bytes()), other(state.bytes());
    const double save = best_ns([&] { state.save(room); });
    const double copy = best_ns([&] {
      std::copy(room.begin(), room.end(), other.begin());
      asm volatile("" ::"r"(other.data()) : "memory");
    });
    std::printf("%-12s %8zu %9.0f %9.0f\n", m.spec.name.c_str(), room.size(), save, copy);
  }
}
