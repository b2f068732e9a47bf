#include "msg/json.hpp"

#include <array>

#include "msg/bulk.hpp"
#include "msg/text.hpp"

namespace sinew::msg {
namespace {

void append_object(const TypeInfo& type, const std::byte* p, std::string& out);

void append_element(const FieldInfo& f, const std::byte* p, std::string& out) {
  if (f.kind == Kind::nested) {
    append_object(*f.nested, p, out);
    out += '}';
    return;
  }
  const std::size_t start = out.size();
  append_number(f.kind, p, out);
  if (const char last = out.back(); last == 'N' || last == 'y') {  // NaN, Infinity
    out.insert(start, 1, '"');
    out += '"';
  }
}

/// Without the closing brace.
void append_object(const TypeInfo& type, const std::byte* p, std::string& out) {
  out += '{';
  for (const FieldInfo& f : type.fields) {
    if (&f != type.fields.data()) out += ',';
    out += '"';
    out += f.name;
    out += "\":";
    if (f.is_array) out += '[';
    const std::uint32_t step = f.kind == Kind::nested ? f.nested->size : size_of(f.kind);
    for (std::uint32_t i = 0; i < f.count; ++i) {
      if (i > 0) out += ',';
      append_element(f, p + f.offset + i * step, out);
    }
    if (f.is_array) out += ']';
  }
}

void append_bulk(std::span<const std::uint8_t> bulk, std::string& out, const JsonOptions& options) {
  if (options.bulk != JsonOptions::Bulk::summary) {
    out += '"';
    options.bulk == JsonOptions::Bulk::hex ? append_hex(bulk, out) : append_base64(bulk, out);
    out += '"';
    return;
  }
  out += "{\"bytes\":" + std::to_string(bulk.size());
  if (options.bulk_hash != nullptr) {
    const std::uint64_t hash = options.bulk_hash(bulk.data(), bulk.size(), 0);
    std::array<std::uint8_t, 8> bytes;
    for (unsigned i = 0; i < 8; ++i) bytes[i] = static_cast<std::uint8_t>(hash >> (56 - 8 * i));
    out += ",\"hash\":\"";
    append_hex(bytes, out);
    out += '"';
  }
  out += '}';
}

}  // namespace

void to_json(const TypeInfo& type, const void* message, std::string& out, const JsonOptions& options) {
  append_object(type, static_cast<const std::byte*>(message), out);
  if (type.has_bulk()) {
    out += ",\"";
    out += type.bulk_name;
    out += "\":";
    append_bulk(bulk_of(type, message), out, options);
  }
  out += '}';
}

}  // namespace sinew::msg
