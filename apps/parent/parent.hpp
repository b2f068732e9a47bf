#pragma once
// The process that stands beside a runtime in real time, for the faults that end the runtime itself: it stops the
// actuators, feeds or starves the hardware watchdog, and saves the last seconds from the memory that it still holds.
#include <atomic>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "apps/robot_file/parent_options.hpp"
#include "hal/stop_line.hpp"
#include "hal/stream.hpp"

namespace sinew::app {

/// The runtime's end of the line to its parent.
/// Thread:  owner.
class ParentLine {
 public:
  explicit ParentLine(std::unique_ptr<hal::Stream> stream) : stream_(std::move(stream)) {}
  /// Hands the topics to the parent, which from now on expects the guardian to commit. Before the executor starts.
  /// Errors:  what the line says: there is no parent any more.
  hal::Status supervise(const hal::SharedMemory& topics);
  /// Hands over the flight ring, a record::RingMemory. Before supervise(). Errors: likewise.
  hal::Status keep_ring(const hal::SharedMemory& ring);
  /// The run ends in order: the guardian will fall silent.
  void ending();

 private:
  hal::Status hand_over(std::byte what, const hal::SharedMemory& memory);
  std::unique_ptr<hal::Stream> stream_;
};

/// What is wrong with a way to stop, in words for the user; it may become known later, from another thread.
struct StopWarning {
  std::string text{};             // empty: nothing is wrong
  std::atomic<bool> known{true};  // release after `text`, acquire before it is read
};

/// How the parent reaches some of the robot's actuators.
struct StopWay {
  std::string name{};                     // of what it leads to, for texts
  std::unique_ptr<hal::StopLine> line{};  // of before the start
  /// Opens it in the parent: right after the start when there is none yet, and another one after it has failed. Null:
  /// it cannot be had; who opens says so.
  std::function<std::unique_ptr<hal::StopLine>()> open = [] { return nullptr; };
  /// What open() found: printed once the runtime has begun, since of a runtime that does not begin its own reasons are
  /// enough.
  std::shared_ptr<StopWarning> warning = std::make_shared<StopWarning>();
};

/// What the parent knows of the robot before it starts.
struct Supervised {
  std::string robot;          // name, for the saved folder
  std::string runs = "runs";  // where a flight ring goes to whose runtime had no folder yet
  std::vector<StopWay> stops{};
  std::function<int(ParentLine&)> body;     // the runtime, in a process of its own; its exit code
  std::function<void()> in_parent = [] {};  // right after the start: lets go what is the runtime's
};

/// Runs the body in a child and watches it until it ends: process gone without having said that it ends, or the
/// guardian silent for `hang`. Then: actuators stopped, the watchdog left to bite, a hanging runtime killed, actuators
/// stopped whose StopLine does not latch, the last seconds and the flight ring saved, in this order. The exit code: the
/// body's own, or 1 after a fault; 2 when the child or the watchdog could not be had. While this process has one
/// thread. What watches prints nothing: a terminal that takes no text delays no stop and no feeding of the watchdog.
int run_with_parent(const ParentOptions& options, Supervised supervised);

}  // namespace sinew::app
