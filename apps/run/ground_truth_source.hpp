#pragma once
#include <atomic>
#include <vector>

#include "dataset/dataset_files.hpp"
#include "hal/sample_ring.hpp"
#include "msg/flight.hpp"
#include "rt/module.hpp"
#include "rt/module_types.hpp"
#include "sim_hil/protocol.hpp"

namespace sinew::rt {
class Graph;
struct GraphSpec;
}  // namespace sinew::rt

namespace sinew::app {

/// Publishes the true state from the board's simulator or dataset, for the recording and for reports, on a topic with
/// the module's name: attitude, position, velocity, and of a dataset the biases of the sensors; unknown values are NaN.
/// Publishes nothing on a board without truth. Belongs into a thread of ordinary priority; rt::GraphCheck refuses
/// modules that read it.
/// Frames:  those of the simulator or dataset: its world may look elsewhere than the robot's.
/// Thread:  executor; play(): any, once; push(): one other.   RT: yes.
/// Errors:  stale when there is nothing new.
class GroundTruthSource final : public rt::DriverModule {
 public:
  void declare(rt::Declaration& d) override { d.raw("", state_, {.burst = 20}); }
  void collect(rt::Time now) noexcept override;
  rt::StepStatus step(const rt::Step&) noexcept override {
    return state_.empty() ? rt::StepStatus::stale : rt::StepStatus::ok;
  }

  /// All states, by rising stamps of the run's clock: each is published when its time has come.
  void play(std::vector<msg::NavState> states);
  /// The next state, as they come. False: too many wait, and this one is lost.
  bool push(const msg::NavState& state) noexcept { return coming_.push(state); }

 private:
  bool publish(const msg::NavState& state) noexcept;
  static constexpr std::size_t kMostComing = 64;  // 640 ms of a simulator's truth
  rt::Raw<msg::NavState> state_;
  std::vector<msg::NavState> states_;
  std::size_t next_ = 0;
  std::atomic<bool> plays_{false};  // release after states_, acquire before its use
  hal::SampleRing<msg::NavState> coming_{kMostComing};
};

/// A sample as a message with this stamp.
msg::NavState true_state(const dataset::GroundTruthSample& sample, rt::Time stamp);
msg::NavState true_state(const sim_hil::Truth& truth, rt::Time stamp);

/// Adds the source, in a thread of its own at 100 Hz, behind all that a robot file has; nothing where it has a module,
/// thread or topic of that name. The other topics keep their bytes.
void add_ground_truth(rt::GraphSpec& robot);
/// Makes its type known where a program of somebody else does not have it.
void add_ground_truth_type(rt::ModuleTypes& types);
/// The first source of the graph; null: there is none.
GroundTruthSource* find_ground_truth(rt::Graph& graph);

}  // namespace sinew::app
