#pragma once
#include <memory>

#include "hal/connectors.hpp"
#include "hal/linux/can/can_counters.hpp"
#include "hal/linux/fd_watch.hpp"
#include "wire/can_check.hpp"

namespace sinew::hal {

/// The common part of the CAN transports: their spec, the wake, the counters, and the checks before a frame may leave.
class CanPort : public CanBus {
 public:
  void set_wake(Wake* wake) noexcept final { line_.change_wake(wake); }
  CanStats stats() const noexcept final { return counters_.snapshot(); }
  std::uint32_t bit_rate() const noexcept final { return spec_.bit_rate; }

 protected:
  CanPort(const CanSpec& spec, Os& os, std::shared_ptr<FdWatch> watch)
      : spec_(spec),
        os_(os),
        watch_(std::move(watch)),
        counters_(spec.bit_rate > 0 ? static_cast<double>(spec.data_bit_rate) / spec.bit_rate : 1.0) {}

  /// The first checks of send(). Errors: bad_argument: no such frame on this bus; timeout: its deadline is over,
  /// counted. RT: yes.
  Status may_leave(const msg::CanFrame& frame, Time deadline) noexcept {
    if (!wire::is_can_frame(frame) || (frame.fd() && spec_.data_bit_rate == 0))
      return Error{Errc::bad_argument, "frame"};
    if (deadline != kNever && os_.now() >= deadline) return lost(Errc::timeout, "deadline");
    return {};
  }
  /// Counts a frame that does not go out, and gives the error.
  Error lost(Errc code, const char* where, std::int64_t detail = 0) noexcept {
    counters_.tx_lost();
    return {code, where, detail};
  }

  const CanSpec spec_;
  Os& os_;
  const std::shared_ptr<FdWatch> watch_;
  FdLine line_;
  CanCounters counters_;
};

}  // namespace sinew::hal
