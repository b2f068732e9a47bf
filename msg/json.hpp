#pragma once
// Messages as JSON for people and the command line. tap/message_reader.hpp reads them.
// RT:      configure only (strings allocate).
#include <cstddef>
#include <cstdint>
#include <string>

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

}  // namespace sinew::msg
