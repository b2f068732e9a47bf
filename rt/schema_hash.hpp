#pragma once
#include <cstdint>

#include "msg/describe.hpp"

namespace sinew::rt {

/// Hash over everything in a description that decides what the bytes mean: names, kinds, shapes, offsets, units, nested
/// types and the bulk; the doc texts are left out. Two programs whose hashes agree read the same message. Never 0.
/// RT: configure only.
std::uint64_t schema_hash(const msg::TypeInfo& type);

}  // namespace sinew::rt
