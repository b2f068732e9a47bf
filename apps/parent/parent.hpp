#pragma once
// The process that watches a runtime in real time, for faults that end the runtime itself: it stops the actuators,
// feeds or starves the hardware watchdog, and saves the last seconds from the memory that it still holds.
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
  /// Waits at most 2 s for its answer, and not beyond hal::stop_requested().
  /// Errors:  those of the line: the parent is gone.
  hal::Status supervise(const hal::SharedMemory& topics);
  /// Hands over the flight ring, a record::RingMemory. Before supervise(). Errors: as supervise().
  hal::Status keep_ring(const hal::SharedMemory& ring);
  /// Announces an orderly end: the guardian may fall silent.
  void ending();
  /// The parent has died.
  bool is_gone() noexcept;

 private:
  hal::Status hand_over(std::byte what, const hal::SharedMemory& memory);
  std::unique_ptr<hal::Stream> stream_;
};

/// What is wrong with a way to stop, as text for the user; another thread may find it out later.
struct StopWarning {
  std::string text{};             // empty: nothing is wrong
  std::atomic<bool> known{true};  // release after `text`, acquire before it is read
};

/// How the parent reaches some of the robot's actuators.
struct StopWay {
  std::string name{};                     // of the devices that it stops, for texts
  std::unique_ptr<hal::StopLine> line{};  // opened before the start
  /// Opens a line in the parent: after the start when there is none yet, and again after a line has failed. Null: no
  /// line; open() itself reports why.
  std::function<std::unique_ptr<hal::StopLine>()> open = [] { return nullptr; };
  /// Why nothing is left to stop; empty: something may be. Before a stop, on the thread that watches.
  std::function<std::string()> needless = [] { return std::string(); };
  /// The problem that open() found. Printed only after the runtime has begun: a runtime that does not begin prints
  /// reasons of its own.
  std::shared_ptr<StopWarning> warning = std::make_shared<StopWarning>();
};

/// What the parent knows of the robot before it starts.
struct Supervised {
  std::string robot;          // name, for the saved folder
  std::string runs = "runs";  // folder for the flight ring of a runtime without a folder
  std::vector<StopWay> stops{};
  std::function<int(ParentLine&)> body;     // the runtime, in a process of its own; its exit code
  std::function<void()> in_parent = [] {};  // right after the start: releases what belongs to the runtime
  std::function<void()> look = [] {};       // now and then, on the thread that watches: must not wait
};

/// Runs the body in a child and watches it until it ends. A fault is: the process is gone without having announced its
/// end, or the guardian is silent for `hang`. Then, in this order: stops the actuators, feeds the watchdog no more,
/// kills a hanging runtime, stops the actuators whose StopLine does not latch, saves the last seconds and the flight
/// ring. SIGINT and SIGTERM are handed on to the runtime, which then has 1.8 s until it announces its end, and from
/// then on 20 s for its recording; the second of them kills it, stops the actuators and saves nothing. Returns the
/// body's exit code; 1 after a fault; 2 without child or watchdog. Call it while this process has one thread. The
/// thread that watches prints nothing: a blocked terminal delays neither a stop nor the watchdog.
int run_with_parent(const ParentOptions& options, Supervised supervised);

}  // namespace sinew::app
