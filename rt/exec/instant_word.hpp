#pragma once
#include <algorithm>
#include <cstdint>
#include <type_traits>

#include "hal/wide.hpp"
#include "msg/time.hpp"

namespace sinew::rt {

using msg::Time;

/// An instant in one word that many threads exchange. Machines that read 64 bits at once keep it whole. Others keep the
/// last nine minutes in steps of 256 ns, rounded down; the time now tells them apart from earlier ones.
/// RT: yes.
template <bool kWhole = hal::kReadsWideAtOnce>
struct InstantWord {
  using Word = std::conditional_t<kWhole, std::int64_t, std::uint32_t>;
  static constexpr Word kNone = kWhole ? static_cast<Word>(INT64_MIN) : 0;

  static constexpr Word of(Time t) noexcept {
    if constexpr (kWhole)
      return t.ns;
    else
      return std::max(static_cast<Word>(t.ns >> kShift), Word{1});
  }
  /// Calls `now()` only where it is needed.
  template <class Now>
  static constexpr Time time(Word word, Now now) noexcept {
    if constexpr (kWhole) {
      return Time{word};
    } else {
      const std::int64_t steps = now().ns >> kShift;
      const auto ago = static_cast<std::int32_t>(static_cast<std::uint32_t>(steps) - word);
      return Time{(steps - ago) * (std::int64_t{1} << kShift)};
    }
  }

 private:
  static constexpr int kShift = 8;
};

}  // namespace sinew::rt
