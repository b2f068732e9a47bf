#include "msg/cdr.hpp"

#include <algorithm>
#include <array>
#include <cstring>

#include "msg/bulk.hpp"
#include "msg/text.hpp"

namespace sinew::msg {
namespace {

constexpr std::array<std::uint8_t, 4> kHeader{0x00, 0x01, 0x00, 0x00};
constexpr std::size_t kLengthSize = 4;

constexpr std::size_t gap_to(std::size_t at, std::size_t alignment) {
  return (alignment - at % alignment) % alignment;  // `at` counts from behind the header
}

/// Walks the numbers of a type in order. Sink::numbers(field, offset in the struct, size of one, count) returns false
/// to stop.
template <class Sink>
bool walk(const TypeInfo& type, std::uint32_t base, Sink& sink) {
  for (const FieldInfo& f : type.fields) {
    if (f.kind != Kind::nested) {
      if (!sink.numbers(f, base + f.offset, size_of(f.kind), f.count)) return false;
      continue;
    }
    for (std::uint32_t i = 0; i < f.count; ++i)
      if (!walk(*f.nested, base + f.offset + i * f.nested->size, sink)) return false;
  }
  return true;
}

struct Measure {
  std::size_t at = 0;
  bool numbers(const FieldInfo&, std::uint32_t, std::uint32_t size, std::uint32_t count) {
    at += gap_to(at, size) + std::size_t{size} * count;
    return true;
  }
};

struct Writer {
  std::span<std::uint8_t> out;  // behind the header
  const std::uint8_t* message;
  std::size_t at = 0;

  bool put(const void* from, std::size_t alignment, std::size_t bytes) {
    const std::size_t gap = gap_to(at, alignment);
    if (out.size() - at < gap + bytes) return false;
    std::memset(out.data() + at, 0, gap);
    if (bytes > 0) std::memcpy(out.data() + at + gap, from, bytes);
    at += gap + bytes;
    return true;
  }
  bool numbers(const FieldInfo&, std::uint32_t offset, std::uint32_t size, std::uint32_t count) {
    return put(message + offset, size, std::size_t{size} * count);
  }
};

struct Reader {
  std::span<const std::uint8_t> in;  // behind the header
  std::uint8_t* message;
  std::size_t at = 0;
  CdrDecoded result{};

  bool fail(const char* error, std::string_view field) {
    result = {error, field, at + kHeader.size()};
    return false;
  }
  bool get(void* to, std::size_t alignment, std::size_t bytes, std::string_view field) {
    const std::size_t gap = gap_to(at, alignment);
    if (in.size() - at < gap + bytes) return fail("input ends inside the message", field);
    for (std::size_t i = 0; i < gap; ++i)
      if (in[at + i] != 0) return fail("alignment gap is not zero", field);
    if (bytes > 0) std::memcpy(to, in.data() + at + gap, bytes);
    at += gap + bytes;
    return true;
  }
  bool numbers(const FieldInfo& f, std::uint32_t offset, std::uint32_t size, std::uint32_t count) {
    return get(message + offset, size, std::size_t{size} * count, f.name);
  }
  bool bulk(const TypeInfo& type, std::uint32_t capacity) {
    std::uint32_t length = 0;
    if (!get(&length, kLengthSize, kLengthSize, type.bulk_name)) return false;
    if (length > capacity) return fail("bulk does not fit the slot", type.bulk_name);
    if (length > in.size() - at) return fail("input ends inside the message", type.bulk_name);
    type.set_bulk_capacity(message, capacity);
    if (type.bulk_used(message) != length) return fail("length of the bulk contradicts the fields", type.bulk_name);
    return get(message + type.size, 1, length, type.bulk_name);
  }
};

}  // namespace

std::size_t cdr_size(const TypeInfo& type, const void* message) {
  Measure m;
  walk(type, 0, m);
  if (type.has_bulk()) m.at += gap_to(m.at, kLengthSize) + kLengthSize + bulk_of(type, message).size();
  return kHeader.size() + m.at;
}

std::size_t cdr_encode(const TypeInfo& type, const void* message, std::span<std::uint8_t> out) {
  if (out.size() < kHeader.size()) return 0;
  std::copy(kHeader.begin(), kHeader.end(), out.begin());
  Writer w{out.subspan(kHeader.size()), static_cast<const std::uint8_t*>(message)};
  if (!walk(type, 0, w)) return 0;
  if (type.has_bulk()) {
    const auto bulk = bulk_of(type, message);
    const auto length = static_cast<std::uint32_t>(bulk.size());
    if (!w.put(&length, kLengthSize, kLengthSize) || !w.put(bulk.data(), 1, bulk.size())) return 0;
  }
  return kHeader.size() + w.at;
}

CdrDecoded cdr_decode(const TypeInfo& type, std::span<const std::uint8_t> in, void* message,
                      std::uint32_t bulk_capacity) {
  const auto give_up = [&](CdrDecoded why) {
    type.reset(message);
    if (type.has_bulk()) type.set_bulk_capacity(message, bulk_capacity);
    return why;
  };
  if (in.size() < kHeader.size() || !std::equal(kHeader.begin(), kHeader.end(), in.begin()))
    return give_up({"not little-endian XCDR1 (00 01 00 00)", {}, 0});
  Reader r{in.subspan(kHeader.size()), static_cast<std::uint8_t*>(message)};
  if (!walk(type, 0, r)) return give_up(r.result);
  if (type.has_bulk() && !r.bulk(type, bulk_capacity)) return give_up(r.result);
  if (r.at != r.in.size()) return give_up({"bytes left over behind the message", {}, kHeader.size() + r.at});
  return {};
}

}  // namespace sinew::msg
