// Finds a lost interface, or a controller that is off its bus, again.
#include <algorithm>

#include "hal/linux/can/socket_can.hpp"

namespace sinew::hal {
namespace {

using namespace std::chrono_literals;

constexpr Duration kFirstPause = 100ms, kLongPause = 1s;

}  // namespace

std::string SocketCanBus::trouble() const {
  const std::lock_guard lock(mutex_);
  return trouble_;
}

void SocketCanBus::lose() noexcept {
  counters_.set_state(CanState::stopped);
  if (lost_.exchange(true, std::memory_order_acq_rel)) return;
  keeper_word_.fetch_add(1, std::memory_order_release);
  os_.wake(keeper_word_);
}

void SocketCanBus::keep() {
  Duration pause = kLongPause;
  bool waited = false;
  while (!stop_.load(std::memory_order_acquire)) {
    const std::uint32_t seen = keeper_word_.load(std::memory_order_acquire);
    const bool waits = look();
    pause = !waits ? kLongPause : waited ? std::min<Duration>(2 * pause, kLongPause) : kFirstPause;
    waited = waits;
    // While the interface is lost, further wake-ups bring nothing new: the pauses stay.
    const Time until = os_.now() + pause;
    os_.wait(keeper_word_, seen, until);
    while ((lost_.load(std::memory_order_acquire) || counters_.state() == CanState::bus_off) && os_.now() < until &&
           !stop_.load(std::memory_order_acquire)) {
      const std::uint32_t now_seen = keeper_word_.load(std::memory_order_acquire);
      os_.wait(keeper_word_, now_seen, until);
    }
  }
}

bool SocketCanBus::look() {
  const std::uint64_t error_frames = counters_.error_frames();
  const auto link = read_can_link(spec_.address);
  const std::lock_guard lock(mutex_);
  std::string trouble;
  if (!link) {
    trouble =
        spec_.address + (link.error().code == Errc::not_found ? ": the interface is gone" : ": cannot be looked at");
    lost_.store(true, std::memory_order_release);
    counters_.set_state(CanState::stopped);
  } else {
    follow_controller(*link, error_frames, trouble);
    const bool moved = link->index != bound_.load(std::memory_order_relaxed);
    if (!link->up) {
      lost_.store(true, std::memory_order_release);
    } else if (moved || lost_.load(std::memory_order_acquire)) {
      // A socket whose interface was removed has lost its filters; a socket whose interface was only down has not.
      if ((!moved || bind_to(link->index)) && apply_filters()) {
        lost_.store(false, std::memory_order_release);
        if (link->kind != "can") counters_.set_state(CanState::active);
        line_.ring();
      }
    }
  }
  trouble_ = trouble;
  return lost_.load(std::memory_order_acquire) || counters_.state() == CanState::bus_off;
}

/// With mutex_ held, or before there is a keeper.
void SocketCanBus::follow_controller(const CanLink& link, std::uint64_t error_frames_before, std::string& trouble) {
  const std::string& name = spec_.address;
  if (!link.up) {
    counters_.set_state(CanState::stopped);
    trouble = name + ": the interface is down: 'ip link set " + name + " up" +
              (link.kind == "can" ? " type can bitrate " + std::to_string(spec_.bit_rate) : "") + "'";
    return;
  }
  if (link.kind != "can") return;
  counters_.set_errors(link.tx_errors, link.rx_errors);
  // An error frame that came meanwhile is newer than the kernel's answer.
  if (counters_.error_frames() == error_frames_before) counters_.set_state(link.state);
  if (link.state != CanState::bus_off || link.restart_ms != 0) return;
  if (const Status restarted = restart_can(link.index); !restarted && restarted.error().code == Errc::denied)
    trouble = name + ": is bus-off, its restart-ms is 0, and restarting it needs CAP_NET_ADMIN: 'ip link set " + name +
              " type can restart-ms 100'";
}

}  // namespace sinew::hal
