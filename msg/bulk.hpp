#pragma once
#include <cstdint>
#include <span>

#include "msg/describe.hpp"

namespace sinew::msg {

/// The used bulk behind a message; empty for types without one. Not more than the capacity that the message states.
inline std::span<const std::uint8_t> bulk_of(const TypeInfo& type, const void* message) {
  if (!type.has_bulk()) return {};
  return {static_cast<const std::uint8_t*>(message) + type.size, type.bulk_used(message)};
}

}  // namespace sinew::msg
