#pragma once
// Messages from a person at the other end of a link.
#include "msg/describe.hpp"

namespace sinew::msg {

/// The operator's heartbeat: while it keeps coming the link is there.
struct OperatorLink {
  Time stamp;                  // when it came in
  std::uint32_t sequence = 0;  // counted by the operator's station
  float quality = 0;           // of the link, 0 to 1, as the station sees it
};

template <>
struct Description<OperatorLink> {
  static constexpr std::string_view name = "OperatorLink", doc = "The operator's heartbeat.";
  static constexpr auto fields =
      describe(field<&OperatorLink::stamp>("ns", "when it came in"),
               field<&OperatorLink::sequence>("1", "counted by the operator's station"),
               field<&OperatorLink::quality>("1", "of the link, 0 to 1, as the station sees it"));
};

}  // namespace sinew::msg
