#pragma once
// What a definition of messages says of a field in its comment: "[m] world", "[enum] 0 standby, 1 armed; the worst".
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "record/ros2_schema.hpp"

namespace sinew::app {

struct FieldRemark {
  std::string unit{};                                          // "m", "enum", "bits"; empty: it says none
  std::vector<std::pair<std::uint64_t, std::string>> names{};  // of values or of bits; empty: numbers are all there is
  bool bits = false;
  std::string doc{};  // what stands behind the unit
};

/// Reads remarks as msg/ros2msg.hpp writes them, and those of recordings before the names had numbers ("[enum] wait arm
/// climb").
FieldRemark remark_of(const record::Ros2Field& field);

/// "armed"; of bits "lease, limit", or "none". A value or bit without a name stays a number: "7", "lease, 512".
std::string value_name(const FieldRemark& remark, std::uint64_t value);

/// Puts names in the place of the numbers of all fields that have them, and text in the place of bytes ("[ascii]").
void put_names(nlohmann::ordered_json& message, const record::Ros2Schema& schema);

/// Adds behind each such field F another one, F_name.
void add_names(nlohmann::ordered_json& message, const record::Ros2Schema& schema);

}  // namespace sinew::app
