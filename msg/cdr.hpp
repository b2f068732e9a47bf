#pragma once
// Messages as XCDR1, little-endian, behind the encapsulation header 00 01 00 00: what recordings hold and DDS carries.
// Source:  OMG DDS-XTypes 1.3, 7.4.1 (numbers aligned to their size, counted from behind the header); DDSI-RTPS 2.3,
//          10.2.
// Thread:  any.   RT: yes; nothing here allocates.
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "msg/describe.hpp"

namespace sinew::msg {

/// Bytes that cdr_encode() writes for this message.
std::size_t cdr_size(const TypeInfo& type, const void* message);

/// Writes the message into `out`; returns the bytes written, or 0 and nothing when `out` is too small. Equal messages
/// give equal bytes; the cost is that of copying them.
std::size_t cdr_encode(const TypeInfo& type, const void* message, std::span<std::uint8_t> out);

/// Outcome of decoding. `error` is null on success, else a literal; `field` is where it happened.
struct [[nodiscard]] CdrDecoded {
  const char* error = nullptr;
  std::string_view field;
  std::size_t at = 0;  // byte in the input
  explicit operator bool() const { return error == nullptr; }
};

/// Fills a message of this type from all of `in`. The input may be anything: every length is checked; short input and
/// trailing bytes are refused.
/// Owner:   `message` is a slot with room for `bulk_capacity` bytes behind the struct; it states that capacity
///          afterwards.
/// Errors:  the message is left at its defaults.
CdrDecoded cdr_decode(const TypeInfo& type, std::span<const std::uint8_t> in, void* message,
                      std::uint32_t bulk_capacity = 0);

}  // namespace sinew::msg
