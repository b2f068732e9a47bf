#pragma once
#include <atomic>

#include "hal/device.hpp"

namespace sinew::hal {

/// Whom a device wakes, changed while it may be waking.
/// Thread:  ring(): one; change(): another.   RT: ring() yes; change() configure only.
class WakeSlot {
 public:
  // The two orders that must not both be missed: ring() says that it rings and then looks for whom; change() takes the
  // wake away and then looks whether somebody rings. Sequential consistency is what makes one of the two see the other.
  void ring() noexcept {
    ringing_.store(true, std::memory_order_seq_cst);
    if (Wake* wake = wake_.load(std::memory_order_seq_cst)) wake->wake();
    ringing_.store(false, std::memory_order_release);
  }
  /// When this returns, ring() is out of the old one and will not call it again.
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
