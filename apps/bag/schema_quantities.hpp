#pragma once
#include <cstdint>
#include <vector>

#include "record/ros2_schema.hpp"
#include "record/run/quantity.hpp"

namespace sinew::app {

/// The quantities of messages of any definition, as record::quantities() has them of this program's own types; their
/// offsets are in the CDR of a message, behind its header. Those behind the first text or list are left out: their
/// place differs from message to message. `size`: bytes that a message needs to have them all.
std::vector<record::Quantity> schema_quantities(const record::Ros2Schema& schema, std::uint32_t& size);

}  // namespace sinew::app
