#pragma once
// Messages from a pilot with a radio control.
#include "msg/describe.hpp"

namespace sinew::msg {

/// The switches of a pilot, as [[failsafe]] conditions and other modules read them.
struct PilotSwitches {
  Time stamp;
  double link_quality = 0;      // 0..1; NaN when unknown
  std::uint32_t lost = 1;       // 1: no pilot is heard; the switches below are 0 then, except `kill`
  std::uint32_t kill = 0;       // 1: stop at once; keeps its last value when the link is lost
  std::uint32_t take_over = 0;  // 1: the sticks fly
  std::uint32_t reserved = 0;
};

template <>
struct Description<PilotSwitches> {
  static constexpr std::string_view name = "PilotSwitches", doc = "The switches of a pilot.";
  static constexpr auto fields = describe(
      field<&PilotSwitches::stamp>("ns"), field<&PilotSwitches::link_quality>("1", "0..1; NaN when unknown"),
      field<&PilotSwitches::lost>("1", "1: nobody is heard"), field<&PilotSwitches::kill>("1", "1: stop at once"),
      field<&PilotSwitches::take_over>("1", "1: the sticks fly"), field<&PilotSwitches::reserved>("1"));
};

}  // namespace sinew::msg
