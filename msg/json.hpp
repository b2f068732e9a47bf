#pragma once
// Messages as JSON for people and the command line.
// RT:      configure only (strings allocate).
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "msg/describe.hpp"

namespace sinew::msg {

struct JsonOptions {
  /// How the bulk is shown: {"bytes": n, "hash": "..."}, or as text.
  enum class Bulk : std::uint8_t { summary, hex, base64 } bulk = Bulk::summary;
  /// For the summary, e.g. &math::hash64; null leaves the hash out.
  std::uint64_t (*bulk_hash)(const void*, std::size_t, std::uint64_t seed) = nullptr;
};

/// Appends one object with the fields in order. Numbers read back to the same bits; JSON has no NaN, so "NaN",
/// "Infinity" and "-Infinity" are strings (the bits of a NaN are lost). Time is its integer of nanoseconds.
void to_json(const TypeInfo& type, const void* message, std::string& out, const JsonOptions& options = {});

/// Why a text is not such a message.
struct JsonError {
  std::size_t at = 0;        // byte in the text
  std::string path;          // "gyro_radps.x"
  std::string what;          // what is wrong
  std::string allowed;       // what would be right
  std::string text() const;  // "at 17: gyro_radps.x: \"fast\": a number, \"NaN\", \"Infinity\" or \"-Infinity\""
};

/// Fills a message from one object as to_json() writes it, with the bulk as base64. Fields left out keep their
/// defaults; unknown or repeated fields, numbers out of range and arrays of another length are refused.
/// Owner:   `message` is a slot with room for `bulk_capacity` bytes behind the struct; it states that capacity
///          afterwards.
/// Errors:  the message is left at its defaults.
std::optional<JsonError> from_json(const TypeInfo& type, std::string_view json, void* message,
                                   std::uint32_t bulk_capacity = 0);

}  // namespace sinew::msg
