#pragma once
#include <atomic>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <vector>

#include "hal/os.hpp"
#include "rt/outside_bells.hpp"
#include "rt/segment.hpp"

namespace sinew::tap {

/// Wakes outsiders when topics have new messages, so that no real-time writer has to. While a client subscribes, a
/// thread of ordinary priority looks at the writers' commit numbers once a period. Where a number moved, the thread
/// writes it into that writer's word of a shared page and wakes the sleepers on it. Without subscribers it sleeps and
/// costs nothing. This process only writes the page and never reads it: nothing that happens to the page reaches the
/// robot. A client may ask that the committing thread wakes it, where the robot file allows that (rt::OutsideBells).
/// Thread:  any.
class TopicNotifier {
 public:
  /// `segment` and `bells` must outlive it. Errors: what making a thread says.
  static hal::Result<std::unique_ptr<TopicNotifier>> open(const rt::Segment& segment, rt::OutsideBells& bells,
                                                          hal::Os& os);
  ~TopicNotifier();  // wakes all sleepers and ends the thread
  TopicNotifier(const TopicNotifier&) = delete;
  TopicNotifier& operator=(const TopicNotifier&) = delete;

  struct Wish {
    std::vector<rt::WriterId> writers{};  // whose commit numbers are looked at once a period
    hal::Duration period{};
    std::vector<rt::WriterId> at_once{};  // that wake the client themselves
  };
  /// Replaces the client's earlier subscription; no writers at all: unsubscribes.
  void subscribe(std::uint64_t client, Wish wish);
  const hal::SharedMemory& page() const { return bells_.page(); }
  bool subscribes(std::uint64_t client) const;

 private:
  TopicNotifier(const rt::Segment& segment, rt::OutsideBells& bells, hal::Os& os)
      : segment_(segment), bells_(bells), os_(os) {}
  void run();
  hal::Duration look_at_all(std::vector<std::uint32_t>& seen);
  std::uint32_t number_of(rt::WriterId writer) const;
  std::uint32_t ring(rt::WriterId writer);

  const rt::Segment& segment_;
  rt::OutsideBells& bells_;
  hal::Os& os_;
  mutable std::mutex mutex_;  // guards wishes_
  std::map<std::uint64_t, Wish> wishes_;
  hal::WakeWord changed_{0};  // counts changes of wishes_, and the end of the thread
  std::atomic<bool> end_{false};
  std::unique_ptr<hal::Thread> thread_;
};

}  // namespace sinew::tap
