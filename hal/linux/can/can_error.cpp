#include "hal/linux/can/can_error.hpp"

#include <linux/can/error.h>

namespace sinew::hal {

void count_error_frame(const msg::CanFrame& frame, CanCounters& counters) noexcept {
  counters.error_frame();
#ifdef CAN_ERR_CNT
  constexpr std::uint32_t kCountersValid = CAN_ERR_CNT;
#else
  constexpr std::uint32_t kCountersValid = 0x200;
#endif
  if ((frame.id & kCountersValid) != 0) counters.set_errors(frame.data[6], frame.data[7]);
  if ((frame.id & CAN_ERR_CRTL) != 0) {
    const std::uint8_t what = frame.data[1];
    if ((what & CAN_ERR_CRTL_RX_OVERFLOW) != 0) counters.rx_lost();
    if ((what & CAN_ERR_CRTL_TX_OVERFLOW) != 0) counters.tx_lost();
    if ((what & (CAN_ERR_CRTL_RX_PASSIVE | CAN_ERR_CRTL_TX_PASSIVE)) != 0)
      counters.set_state(CanState::passive);
    else if ((what & (CAN_ERR_CRTL_RX_WARNING | CAN_ERR_CRTL_TX_WARNING)) != 0)
      counters.set_state(CanState::warning);
    else if ((what & CAN_ERR_CRTL_ACTIVE) != 0)
      counters.set_state(CanState::active);
  }
  if ((frame.id & CAN_ERR_RESTARTED) != 0) counters.set_state(CanState::active);
  if ((frame.id & CAN_ERR_BUSOFF) != 0) counters.set_state(CanState::bus_off);
}

}  // namespace sinew::hal
