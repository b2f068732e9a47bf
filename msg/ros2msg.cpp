#include "msg/ros2msg.hpp"

#include <algorithm>
#include <array>
#include <vector>

#include "msg/text.hpp"

namespace sinew::msg {
namespace {

constexpr std::string_view kPackage = "sinew_msgs";

std::string element_name(const FieldInfo& f) {
  constexpr std::array<std::string_view, 10> kNames{"int8",   "uint8", "int16",  "uint16",  "int32",
                                                    "uint32", "int64", "uint64", "float32", "float64"};
  if (f.kind == Kind::nested) return std::string(kPackage) + "/" + std::string(f.nested->name);
  return std::string(kNames[static_cast<std::size_t>(f.kind)]);
}

std::string remark(const FieldInfo& f) {
  std::string text(f.unit.empty() ? "" : "[" + std::string(f.unit) + "]");
  const std::string said = remark_of(f);
  if (!text.empty() && !said.empty()) text += " ";
  text += said;
  return text.empty() ? text : "  # " + text;
}

void append_fields(const TypeInfo& type, std::string& out) {
  out += "# " + std::string(type.doc) + "\n";
  for (const FieldInfo& f : type.fields) {
    out += element_name(f);
    if (f.is_array) out += "[" + std::to_string(f.count) + "]";
    out += " " + std::string(f.name) + remark(f) + "\n";
  }
  if (type.has_bulk()) out += "uint8[] " + std::string(type.bulk_name) + "\n";
}

/// Nested types in the order in which they are first met.
void collect(const TypeInfo& type, std::vector<const TypeInfo*>& seen) {
  for (const FieldInfo& f : type.fields)
    if (f.kind == Kind::nested && std::find(seen.begin(), seen.end(), f.nested) == seen.end()) {
      seen.push_back(f.nested);
      collect(*f.nested, seen);
    }
}

}  // namespace

std::string ros2_name(const TypeInfo& type) { return std::string(kPackage) + "/msg/" + std::string(type.name); }

std::string ros2msg_schema(const TypeInfo& type) {
  std::string text;
  append_fields(type, text);
  std::vector<const TypeInfo*> nested;
  collect(type, nested);
  for (const TypeInfo* t : nested) {
    text += std::string(80, '=') + "\nMSG: " + std::string(kPackage) + "/" + std::string(t->name) + "\n";
    append_fields(*t, text);
  }
  return text;
}

}  // namespace sinew::msg
