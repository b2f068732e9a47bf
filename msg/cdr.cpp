#include "msg/cdr.hpp"

#include <algorithm>
#include <array>
#include <cstring>

#include "msg/bulk.hpp"
#include "msg/text.hpp"

namespace sinew::msg {
namespace {

// CDR aligns each number to its own size, counted from behind the header. So does a struct in memory where 64-bit
// numbers are aligned to 8, and check_layout() allows no padding: the encoding of a message is its bytes.
static_assert(alignof(double) == 8 && alignof(std::int64_t) == 8, "this ABI needs a codec that walks the fields");

constexpr std::array<std::uint8_t, 4> kHeader{0x00, 0x01, 0x00, 0x00};

constexpr std::size_t aligned(std::size_t at) { return (at + 3) / 4 * 4; }  // for the length of the bulk

/// Name of the innermost field that holds this byte of the struct.
std::string_view field_at(const TypeInfo& type, std::size_t offset) {
  for (const FieldInfo& f : type.fields) {
    const std::size_t size = f.kind == Kind::nested ? f.nested->size : size_of(f.kind);
    if (offset >= f.offset + size * f.count) continue;
    return f.kind == Kind::nested ? field_at(*f.nested, (offset - f.offset) % size) : f.name;
  }
  return type.bulk_name;
}

/// The bulk and its length, from `at` of `in` on.
CdrDecoded decode_bulk(const TypeInfo& type, std::span<const std::uint8_t> in, std::size_t at, void* message,
                       std::uint32_t capacity) {
  const std::size_t length_at = kHeader.size() + aligned(type.size), bulk_at = length_at + 4;
  if (in.size() < bulk_at) return {"input ends inside the message", type.bulk_name, in.size()};
  for (; at < length_at; ++at)
    if (in[at] != 0) return {"alignment gap is not zero", type.bulk_name, at};
  std::uint32_t length;
  std::memcpy(&length, in.data() + length_at, sizeof length);
  if (length > capacity) return {"bulk does not fit the slot", type.bulk_name, length_at};
  if (length > in.size() - bulk_at) return {"input ends inside the message", type.bulk_name, in.size()};
  type.set_bulk_capacity(message, capacity);
  if (type.bulk_used(message) != length)
    return {"length of the bulk contradicts the fields", type.bulk_name, length_at};
  if (in.size() - bulk_at > length) return {"bytes left over behind the message", {}, bulk_at + length};
  if (length > 0) std::memcpy(static_cast<std::uint8_t*>(message) + type.size, in.data() + bulk_at, length);
  return {};
}

CdrDecoded decode(const TypeInfo& type, std::span<const std::uint8_t> in, void* message, std::uint32_t capacity) {
  if (in.size() < kHeader.size() || !std::equal(kHeader.begin(), kHeader.end(), in.begin()))
    return {"not little-endian XCDR1 (00 01 00 00)", {}, 0};
  const std::size_t behind = kHeader.size() + type.size;
  if (in.size() < behind)
    return {"input ends inside the message", field_at(type, in.size() - kHeader.size()), in.size()};
  std::memcpy(message, in.data() + kHeader.size(), type.size);
  if (type.has_bulk()) return decode_bulk(type, in, behind, message, capacity);
  if (in.size() > behind) return {"bytes left over behind the message", {}, behind};
  return {};
}

}  // namespace

std::size_t cdr_size(const TypeInfo& type, const void* message) {
  if (!type.has_bulk()) return kHeader.size() + type.size;
  return kHeader.size() + aligned(type.size) + 4 + type.bulk_used(message);
}

std::size_t cdr_encode(const TypeInfo& type, const void* message, std::span<std::uint8_t> out) {
  const auto bulk = bulk_of(type, message);
  const std::size_t size = cdr_size(type, message);
  if (out.size() < size) return 0;
  std::copy(kHeader.begin(), kHeader.end(), out.begin());
  std::memcpy(out.data() + kHeader.size(), message, type.size);
  if (!type.has_bulk()) return size;
  const std::size_t behind = kHeader.size() + type.size, length_at = kHeader.size() + aligned(type.size);
  std::fill(out.begin() + std::ptrdiff_t(behind), out.begin() + std::ptrdiff_t(length_at), std::uint8_t{0});
  const auto length = static_cast<std::uint32_t>(bulk.size());
  std::memcpy(out.data() + length_at, &length, sizeof length);
  if (length > 0) std::memcpy(out.data() + length_at + 4, bulk.data(), length);
  return size;
}

CdrDecoded cdr_decode(const TypeInfo& type, std::span<const std::uint8_t> in, void* message,
                      std::uint32_t bulk_capacity) {
  const CdrDecoded result = decode(type, in, message, bulk_capacity);
  if (!result) {
    type.reset(message);
    if (type.has_bulk()) type.set_bulk_capacity(message, bulk_capacity);
  }
  return result;
}

}  // namespace sinew::msg
