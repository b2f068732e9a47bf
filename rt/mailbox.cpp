#include "rt/mailbox.hpp"

namespace sinew::rt {

Mailbox::Mailbox(std::uint32_t capacity) : cells_(capacity), mask_(capacity - 1) {
  for (std::uint32_t i = 0; i < capacity; ++i) {
    cells_[i].turn.store(i, std::memory_order_relaxed);
    cells_[i].done.store(std::uint64_t{i - capacity} << 32, std::memory_order_relaxed);
  }
}

hal::Result<std::uint32_t> Mailbox::post(const Request& request) noexcept {
  std::uint32_t ticket = next_post_.load(std::memory_order_relaxed);
  for (;;) {
    Cell& cell = cells_[ticket & mask_];
    const auto lead = static_cast<std::int32_t>(cell.turn.load(std::memory_order_acquire) - ticket);
    if (lead < 0) return hal::Error{hal::Errc::busy, "mailbox full", mask_ + 1};
    if (lead > 0) {  // another poster has taken this one
      ticket = next_post_.load(std::memory_order_relaxed);
    } else if (next_post_.compare_exchange_weak(ticket, ticket + 1, std::memory_order_relaxed)) {
      cell.request = request;
      cell.turn.store(ticket + 1, std::memory_order_release);
      return ticket;
    }
  }
}

const Request* Mailbox::take() noexcept {
  Cell& cell = cells_[next_take_ & mask_];
  return cell.turn.load(std::memory_order_acquire) == next_take_ + 1 ? &cell.request : nullptr;
}

void Mailbox::done(const Effect& effect) noexcept {
  Cell& cell = cells_[next_take_ & mask_];
  const std::uint64_t upper = (next_take_ & ~1u) | (effect.refused ? 1u : 0u);
  cell.done.store(upper << 32 | effect.step, std::memory_order_relaxed);
  cell.turn.store(next_take_ + mask_ + 1, std::memory_order_release);
  ++next_take_;
}

std::optional<Effect> Mailbox::effect(std::uint32_t ticket) const noexcept {
  const std::uint64_t done = cells_[ticket & mask_].done.load(std::memory_order_relaxed);
  if (done >> 33 != ticket >> 1) return std::nullopt;
  return Effect{static_cast<std::uint32_t>(done), (done >> 32 & 1) != 0};
}

}  // namespace sinew::rt
