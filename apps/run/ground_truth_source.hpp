#pragma once
#include <atomic>
#include <vector>

#include "dataset/dataset_files.hpp"
#include "msg/flight.hpp"
#include "rt/module.hpp"

namespace sinew::app {

/// Publishes the true state from the board's dataset, for the recording: attitude, position, velocity and biases of the
/// sensors; unknown values are NaN. Publishes nothing on a board without truth. Belongs into a thread of ordinary
/// priority; only the recorder should read it.
/// Frames:  those of the dataset: its world may look elsewhere than the robot's.
/// Thread:  executor; play(): any, once.   RT: yes.
/// Errors:  stale when there is nothing new.
class GroundTruthSource final : public rt::DriverModule {
 public:
  void declare(rt::Declaration& d) override { d.raw("state", state_, {.burst = 20}); }
  void collect(rt::Time now) noexcept override;
  rt::StepStatus step(const rt::Step&) noexcept override {
    return state_.empty() ? rt::StepStatus::stale : rt::StepStatus::ok;
  }

  /// All states, by rising stamps of the run's clock: each is published when its time has come.
  void play(std::vector<msg::NavState> states);

 private:
  rt::Raw<msg::NavState> state_;
  std::vector<msg::NavState> states_;
  std::size_t next_ = 0;
  std::atomic<bool> plays_{false};  // release after states_, acquire before its use
};

/// A sample as a message with this stamp.
msg::NavState true_state(const dataset::GroundTruthSample& sample, rt::Time stamp);

}  // namespace sinew::app
