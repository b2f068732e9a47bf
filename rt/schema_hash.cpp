#include "rt/schema_hash.hpp"

#include <string>

#include "math/hash.hpp"

namespace sinew::rt {
namespace {

void append(const msg::TypeInfo& type, std::string& out) {
  out += std::string(type.name) + ' ' + std::to_string(type.size) + '{';
  for (const msg::FieldInfo& f : type.fields) {
    out += std::string(f.name) + ' ' + std::to_string(static_cast<int>(f.kind)) + (f.is_array ? '[' : ' ') +
           std::to_string(f.count) + '@' + std::to_string(f.offset) + ' ' + std::string(f.unit) + ';';
    if (f.nested) append(*f.nested, out);
  }
  out += '}' + std::string(type.bulk_name);
}

}  // namespace

std::uint64_t schema_hash(const msg::TypeInfo& type) {
  std::string text;
  append(type, text);
  const std::uint64_t hash = math::fnv1a64(text);
  return hash != 0 ? hash : 1;
}

}  // namespace sinew::rt
