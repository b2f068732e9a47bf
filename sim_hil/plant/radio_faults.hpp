#pragma once
#include <algorithm>
#include <deque>

#include "msg/radio.hpp"
#include "sim_hil/worlds/fault.hpp"

namespace sinew::plant {

/// Stands between the air and a robot's radio: what it hears, and what it says. A radio that is off, slow or silent for
/// a while is deaf and mute; everything else strikes what it hears. Thread:  owner.
class RadioFaults {
 public:
  explicit RadioFaults(FaultLog& log) : hears_(log, FaultDevice::radio), says_(log, FaultDevice::radio) {}

  /// A datagram that is sent at `commit`. False: nobody hears it.
  bool says(hal::Time commit) { return !says_.any() || !says_.next(commit).lost; }

  /// A datagram from the air; `send(datagram)` gets those that go out at once, with their stamp as arrival.
  template <class Send>
  hal::Status hears(const msg::Datagram& heard, Send&& send) {
    if (!hears_.any()) return send(heard);
    const FaultEffect effect = hears_.next(heard.stamp);
    msg::Datagram d = heard;
    if (effect.stuck && last_.size > 0) {
      d = last_;
      d.stamp = heard.stamp;
    } else {
      last_ = d;
    }
    if (effect.wrong && hears_.random().uniform() < *effect.wrong)
      d.data[hears_.random().below(d.size)] ^= static_cast<std::uint8_t>(1u << hears_.random().below(8));
    if (effect.garbage)
      for (std::uint32_t i = 0; i < d.size; ++i) d.data[i] = static_cast<std::uint8_t>(hears_.random().next_u32());
    if (effect.lost) return {};
    last_stamp_ = d.stamp = std::max(d.stamp + effect.delay, last_stamp_);
    for (int copies = effect.duplicated ? 2 : 1; copies > 0; --copies) {
      if (effect.delay.count() > 0 || !held_.empty())
        held_.push_back(d);
      else if (auto sent = send(d); !sent)
        return sent;
    }
    return {};
  }
  /// Sends the datagrams that have arrived by then. Once before each exchange.
  template <class Send>
  hal::Status release(hal::Time until, Send&& send) {
    for (; !held_.empty() && held_.front().stamp <= until; held_.pop_front())
      if (auto sent = send(held_.front()); !sent) return sent;
    return {};
  }

 private:
  DeviceFaults hears_, says_;
  std::deque<msg::Datagram> held_;
  msg::Datagram last_{};
  hal::Time last_stamp_{0};
};

}  // namespace sinew::plant
