#pragma once
#include <atomic>
#include <condition_variable>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "hal/os.hpp"
#include "hal/stream.hpp"
#include "sim_hil/caller.hpp"
#include "sim_hil/server/plant_link.hpp"

namespace sinew::sim_hil {

/// The entrance of a plant: lets one runtime for each of its robots in at a time and answers side lines beside them,
/// from the first moment to the last. A side line may stop all actuators (stopped()) and compare its clock with ours.
///     auto plant_listener = PlantListener::open(os, std::move(listener), description, {});
///     auto caller = plant_listener->wait_runtime(60s);             // then PlantLink::accept(std::move(*caller), ...)
/// Thread:  owner; stopped() any. It has a thread that accepts and one for each connection that it serves.
class PlantListener {
 public:
  static constexpr std::size_t kMaxLines = 24;  // side lines, and callers that have not said Hello yet

  /// `robots`: the names that the runtimes of a plant with several robots say in their Hello, each let in for its own;
  /// none: one robot, whatever its name. `os` has the clock that plant time follows. `thread` is for all threads of the
  /// listener: its priority is above the physics', so that neither a stop nor a look at the clock waits. Errors:  those
  /// of starting a thread.
  static hal::Result<std::unique_ptr<PlantListener>> open(hal::Os& os, std::unique_ptr<hal::Listener> listener,
                                                          PlantDescription plant, const hal::ThreadOptions& thread,
                                                          const std::vector<std::string>& robots = {});
  ~PlantListener();
  PlantListener(const PlantListener&) = delete;
  PlantListener& operator=(const PlantListener&) = delete;

  const std::string& endpoint() const { return listener_->endpoint(); }
  /// The runtime of this robot (its place in `robots`) that called, or the next one that calls. From then on others are
  /// turned away, until let_go().
  /// Errors:  timeout.
  hal::Result<Caller> wait_runtime(hal::Duration patience, std::size_t robot = 0);
  /// The runtime that came in is gone: another one may come.
  void let_go(std::size_t robot = 0);
  /// A peer pulled the stop line: from now on no command of this robot may act. A side line with the name of a robot is
  /// that robot's, any other is everybody's.
  bool stopped(std::size_t robot = 0) const noexcept {
    return stopped_.load(std::memory_order_acquire) || places_[robot].stopped.load(std::memory_order_acquire);
  }
  /// Callers turned away, and side lines served so far.
  std::uint32_t turned_away() const { return turned_away_.load(std::memory_order_relaxed); }
  std::uint32_t side_lines() const { return side_lines_.load(std::memory_order_relaxed); }

 private:
  struct Line {
    Caller caller;  // its stream leaves with a runtime, under the mutex
    std::atomic<bool> over{false};
    std::unique_ptr<hal::Thread> thread;
  };

  struct Place {
    std::string robot;  // empty: of any name
    std::optional<Caller> waiting{};
    bool taken = false;  // a runtime is inside
    std::atomic<bool> stopped{false};
  };

  PlantListener(hal::Os& os, std::unique_ptr<hal::Listener> listener, PlantDescription plant,
                const hal::ThreadOptions& thread, const std::vector<std::string>& robots);
  Place* find_place(const std::string& robot);
  void accept_loop();
  void admit(std::unique_ptr<hal::Stream> stream);
  void serve(Caller& caller);
  void keep_runtime(Caller& caller);
  void refuse(hal::Stream& stream, std::string_view reason);

  hal::Os& os_;
  std::unique_ptr<hal::Listener> listener_;
  PlantDescription plant_;
  hal::ThreadOptions thread_options_;
  std::mutex mutex_;
  std::condition_variable came_;
  std::deque<Place> places_;
  std::vector<std::unique_ptr<Line>> lines_;
  std::atomic<bool> closing_{false}, stopped_{false};
  std::atomic<std::uint32_t> turned_away_{0}, side_lines_{0};
  std::unique_ptr<hal::Thread> acceptor_;
};

}  // namespace sinew::sim_hil
