#pragma once
// What a robot or simulator that speaks text (docs/text-robots.md) said about itself.
#include <limits>

#include "msg/describe.hpp"

namespace sinew::msg {

inline constexpr std::size_t kMaxTextValues = 32;

/// The newest value of each [[device.NAME.message]], in the order of the robot file, in the unit that its scale and
/// offset make.
struct TextValues {
  Time stamp;                                        // when the newest of them came in
  std::array<Time, kMaxTextValues> measured{};       // when each came in; 0: never
  std::array<double, kMaxTextValues> value = nan();  // NaN: never came
  std::uint32_t count = 0;                           // in use
  std::uint32_t fresh = 0, known = 0;                // bits: came with this message; came at all
  std::uint32_t lines = 0, torn = 0;   // since the start: whole lines or datagrams; those that were refused
  std::uint32_t sent = 0, unsent = 0;  // lines or datagrams to the robot; those for which there was no room
  std::uint32_t connections = 0;       // how often the link was made

 private:
  static constexpr std::array<double, kMaxTextValues> nan() {
    std::array<double, kMaxTextValues> all{};
    all.fill(std::numeric_limits<double>::quiet_NaN());
    return all;
  }
};

template <>
struct Description<TextValues> {
  using M = TextValues;
  static constexpr std::string_view name = "TextValues", doc = "What a robot that speaks text said about itself.";
  static constexpr auto fields =
      describe(field<&M::stamp>("ns", "when the newest came in"), field<&M::measured>("ns", "0: never"),
               field<&M::value>("", "in the order of the robot file; NaN: never came"),
               field<&M::count>("1", "values in use"), field<&M::fresh>("1", "bits: came with this message"),
               field<&M::known>("1", "bits: came at all"), field<&M::lines>("1", "whole ones that came in"),
               field<&M::torn>("1", "refused"), field<&M::sent>("1", "lines to the robot"),
               field<&M::unsent>("1", "no room for them"), field<&M::connections>("1", "how often the link was made"));
};

}  // namespace sinew::msg
