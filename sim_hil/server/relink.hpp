#pragma once
#include <atomic>
#include <memory>

#include "hal/os.hpp"
#include "sim_hil/server/plant_link.hpp"
#include "sim_hil/server/plant_listener.hpp"

namespace sinew::plant {

/// Waits for another runtime while the world goes on without one. A thread of its own greets it, so that physics does
/// not wait.
/// Thread:  owner.
class Relink {
 public:
  /// A new runtime of this robot needs this rate; `frames` is lent to its link (may be null).
  Relink(hal::Os& os, sim_hil::PlantListener& plant_listener, std::size_t robot, sim_hil::PlantDescription plant,
         hal::SharedMemory* frames, double rate)
      : os_(os),
        plant_listener_(plant_listener),
        robot_(robot),
        plant_(std::move(plant)),
        frames_(frames),
        rate_(rate) {}
  ~Relink() { thread_.reset(); }
  Relink(const Relink&) = delete;
  Relink& operator=(const Relink&) = delete;

  /// The last runtime is gone: waits for another. Errors: those of starting a thread.
  hal::Status look(hal::Duration patience);
  bool looking() const { return thread_ != nullptr; }
  /// A runtime that has said Start, ready for start_clock(); null: none yet. RT: yes, except joining the thread.
  std::unique_ptr<sim_hil::PlantLink> take();
  /// No runtime came in time.
  bool in_vain() const { return state_.load(std::memory_order_acquire) == State::in_vain; }

 private:
  enum class State : std::uint8_t { looking, found, in_vain };
  void run(hal::Time give_up);
  bool greet(sim_hil::Caller caller);

  hal::Os& os_;
  sim_hil::PlantListener& plant_listener_;
  std::size_t robot_;
  sim_hil::PlantDescription plant_;
  hal::SharedMemory* frames_;
  double rate_;
  std::unique_ptr<sim_hil::PlantLink> link_;  // the thread's until it says `found`
  std::atomic<State> state_{State::looking};
  std::unique_ptr<hal::Thread> thread_;
};

}  // namespace sinew::plant
