#pragma once
#include <atomic>

#include "hal/device.hpp"

namespace sinew::hal {

/// The party that a device wakes; it may be changed during a wake.
/// Thread:  ring(): one; change(): another.   RT: ring() yes; change() configure only.
class WakeSlot {
 public:
  // ring() says that it rings and then looks for the wake; change() takes the wake away and then looks whether ring()
  // runs. Sequential consistency makes one of the two see the other.
  void ring() noexcept {
    ringing_.store(true, std::memory_order_seq_cst);
    if (Wake* wake = wake_.load(std::memory_order_seq_cst)) wake->wake();
    ringing_.store(false, std::memory_order_release);
  }
  /// When this returns, ring() has left the old wake and will not call it again.
  void change(Wake* wake) noexcept {
    wake_.store(wake, std::memory_order_seq_cst);
    while (ringing_.load(std::memory_order_seq_cst)) {  // as long as one wake() takes
    }
  }

 private:
  std::atomic<Wake*> wake_{nullptr};
  std::atomic<bool> ringing_{false};
};

}  // namespace sinew::hal
