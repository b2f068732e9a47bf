#pragma once
#include "math/hash.hpp"
#include "math/random.hpp"
#include "rt/exec/fp_mode.hpp"
#include "rt/graph.hpp"
#include "rt/trap.hpp"

namespace sinew::rt {

/// Calls the code of one module's step with its random numbers, inside the trap, and restores the floating-point mode.
/// A run and a replayed record share this code. It does not touch the ports.
/// Thread:  owner for construction, then executor.   RT: yes, after construction.
/// Owner:   the graph outlives it, and is not moved.
class StepCode {
 public:
  struct When {
    Time now;
    Duration dt{};
    bool timed_out = false;
    std::uint32_t number = 0;  // Step::number
  };
  StepCode(const Graph& graph, std::uint32_t module)
      : graph_(graph), module_(graph.modules()[module]), stream_(stream_of(module_.spec.name)) {}

  StepStatus run(const When& when, ZoneLog* zones) noexcept {
    math::Random random(graph_.spec().seed, stream_, when.number);
    const Step step{when.now, when.dt, when.timed_out, when.number, random, zones};
    const trap::Scope scope(module_.spec.name.c_str(),
                            module_.declaration.is_best_effort ? &best_effort_calls_ : nullptr);
    const StepStatus status = module_.module->step(step);
    changed_fp_mode_ = !FpMode::is_set();
    if (changed_fp_mode_) FpMode::set();  // or all steps after this one would give other bits
    return status;
  }
  bool changed_fp_mode() const { return changed_fp_mode_; }  // the last step did
  std::uint32_t best_effort_calls() const { return best_effort_calls_; }

 private:
  static std::uint32_t stream_of(std::string_view module) {
    const std::uint64_t h = math::fnv1a64(module);
    return static_cast<std::uint32_t>(h ^ h >> 32);
  }

  const Graph& graph_;
  const GraphModule& module_;
  const std::uint32_t stream_;
  std::uint32_t best_effort_calls_ = 0;
  bool changed_fp_mode_ = false;
};

}  // namespace sinew::rt
