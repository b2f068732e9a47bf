#pragma once
#include <atomic>
#include <mutex>
#include <string>

#include "hal/device.hpp"
#include "hal/sample_ring.hpp"
#include "hal/wake_slot.hpp"
#include "hal/wide.hpp"

namespace sinew::hal {

/// A device's complaint, for people; empty: nothing.
/// Thread:  any.   RT: no.
class TroubleText {
 public:
  void set(std::string text) {
    const std::lock_guard lock(mutex_);
    text_ = std::move(text);
  }
  std::string get() const {
    const std::lock_guard lock(mutex_);
    return text_;
  }

 private:
  mutable std::mutex mutex_;
  std::string text_;
};

/// The reading end of a sensor that a separate thread feeds: samples in a ring, a wake, and whether the device is
/// there. Without a reader the newest samples are lost and counted.
/// Thread:  put(), set_gone(): the feeding one; read(): the reading one; the others: any.   RT: yes.
template <class M>
class SensorQueue : public Sensor<M> {
 public:
  explicit SensorQueue(std::size_t capacity = 64) : ring_(capacity) {}

  Result<bool> read(M& out) noexcept override {
    if (ring_.size() > 0) {
      out = ring_.at(0);
      ring_.pop();
      return true;
    }
    if (gone_.load(std::memory_order_relaxed)) return Error{Errc::closed, "the device is gone"};
    return false;
  }
  Time ready_at() const noexcept override { return ring_.size() > 0 ? Time{} : kNever; }
  void set_wake(Wake* wake) noexcept override { wake_.change(wake); }

  /// Samples that found the ring full.
  std::uint64_t lost() const noexcept { return lost_.value(); }
  std::uint64_t delivered() const noexcept { return delivered_.value(); }
  bool gone() const noexcept { return gone_.load(std::memory_order_relaxed); }

 protected:
  void put(const M& sample) noexcept {
    if (ring_.push(sample))
      delivered_.add();
    else
      lost_.add();
    wake_.ring();
  }
  /// True: read() says closed once the ring is empty. False: no longer.
  void set_gone(bool gone) noexcept { gone_.store(gone, std::memory_order_relaxed); }

 private:
  SampleRing<M> ring_;
  WakeSlot wake_;
  Tally lost_, delivered_;
  std::atomic<bool> gone_{false};  // relaxed: the ring orders its own content
};

}  // namespace sinew::hal
