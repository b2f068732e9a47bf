#pragma once
// From 32 pixels' bits to runs, for the kernels that look at 32 pixels at once.
#include <bit>
#include <cstdint>

#include "vision/run_joiner.hpp"

namespace sinew::vision::detail {

/// The state of one colour between two blocks of a row.
struct MaskRow {
  std::uint32_t carry = 0;  // 1: the last pixel was inside
  std::uint32_t from = 0;   // where the open run began
};

/// Turns the changes within 32 pixels of row y, from column x on, into runs; bit 0 is the first pixel. Always inlined:
/// the caller may use instructions for counting bits that this file must not assume.
[[gnu::always_inline]] inline void add_mask(std::uint32_t mask, std::uint32_t y, std::uint32_t x, MaskRow& row,
                                            RunJoiner& joiner) {
  std::uint32_t edge = mask ^ ((mask << 1) | row.carry);
  row.carry = mask >> 31;
  if (joiner.full()) [[unlikely]] {  // bounded time for noise: only counts the runs that end here
    joiner.drop(static_cast<std::uint32_t>(std::popcount(edge & ~mask)));
    return;
  }
  while (edge != 0) {
    const auto bit = static_cast<std::uint32_t>(std::countr_zero(edge));
    edge &= edge - 1;
    if ((mask >> bit) & 1)
      row.from = x + bit;
    else
      joiner.add(y, row.from, x + bit);
  }
}

}  // namespace sinew::vision::detail
