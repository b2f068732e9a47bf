#pragma once
#include <cstddef>
#include <span>
#include <string>

#include "record/ros2_schema.hpp"

namespace sinew::record {

/// Appends a message of any ros2msg schema as one JSON object, in the form of msg::to_json(): fields in order, numbers
/// that read back to the same bits, NaN as text, `uint8[]` as {"bytes": n, "hash": "..."}.
/// Errors:  false, and nothing appended: the bytes are not exactly one such message in CDR, little-endian.
bool to_json(const Ros2Schema& schema, std::span<const std::byte> cdr, std::string& out);

}  // namespace sinew::record
