#include "apps/bag/field_remark.hpp"

#include <algorithm>
#include <charconv>

namespace sinew::app {
namespace {

using Json = nlohmann::ordered_json;
using Names = std::vector<std::pair<std::uint64_t, std::string>>;

std::vector<std::string_view> split(std::string_view text, std::string_view by) {
  std::vector<std::string_view> parts;
  while (true) {
    const auto at = text.find(by);
    parts.push_back(text.substr(0, at));
    if (at == std::string_view::npos) return parts;
    text.remove_prefix(at + by.size());
  }
}

/// "0 standby, 1 armed"; nothing when a part is something else.
Names numbered(std::string_view text) {
  Names names;
  for (const std::string_view part : split(text, ", ")) {
    std::uint64_t value = 0;
    const auto read = std::from_chars(part.data(), part.data() + part.size(), value);
    const auto used = static_cast<std::size_t>(read.ptr - part.data());
    if (read.ec != std::errc() || used + 1 >= part.size() || part[used] != ' ') return {};
    names.emplace_back(value, part.substr(used + 1));
  }
  return names;
}

/// "wait arm climb", as old recordings have it: counted from 0.
Names counted(std::string_view text) {
  if (text.empty() || text.find_first_of(",:0123456789") != std::string_view::npos) return {};
  Names names;
  for (const std::string_view part : split(text, " ")) names.emplace_back(names.size(), part);
  return names;
}

Json named(const Json& value, const FieldRemark& remark) {
  if (value.is_number_integer()) return value_name(remark, value.get<std::uint64_t>());
  if (!value.is_array()) return value;
  Json all = Json::array();
  for (const Json& one : value) all.push_back(named(one, remark));
  return all;
}

/// Bytes up to the first zero as text; what is not printable ASCII becomes '?', so that a damaged message stays JSON.
std::string ascii_text(const Json& bytes) {
  std::string text;
  for (const Json& one : bytes) {
    const std::uint64_t byte = one.is_number_integer() ? one.get<std::uint64_t>() : 0;
    if (byte == 0) break;
    text += byte >= 0x20 && byte < 0x7F ? static_cast<char>(byte) : '?';
  }
  return text;
}

/// The object with names in the place of numbers (`beside` false) or in fields of their own.
Json object_named(const Json& object, const record::Ros2Schema& schema, const record::Ros2Schema::Type& type,
                  bool beside) {
  if (!object.is_object()) return object;
  Json out = Json::object();
  for (const auto& item : object.items()) {
    const std::string& key = item.key();
    const Json& value = item.value();
    const auto field =
        std::find_if(type.fields.begin(), type.fields.end(), [&](const auto& f) { return f.name == key; });
    if (field == type.fields.end()) {
      out[key] = value;
    } else if (field->kind == record::Ros2Field::Kind::nested) {
      Json inner = value.is_array() ? Json::array() : object_named(value, schema, schema.type(*field), beside);
      if (value.is_array())
        for (const Json& one : value) inner.push_back(object_named(one, schema, schema.type(*field), beside));
      out[key] = std::move(inner);
    } else {
      const FieldRemark remark = remark_of(*field);
      const bool is_text = remark.unit == "ascii" && value.is_array();
      Json name = value;
      if (is_text)
        name = ascii_text(value);
      else if (!remark.names.empty())
        name = named(value, remark);
      out[key] = beside ? value : name;
      if (beside && (is_text || !remark.names.empty())) out[key + "_name"] = name;
    }
  }
  return out;
}

}  // namespace

FieldRemark remark_of(const record::Ros2Field& field) {
  FieldRemark remark;
  std::string_view text = field.remark;
  if (const auto end = text.find(']'); text.starts_with('[') && end != std::string_view::npos) {
    remark.unit = text.substr(1, end - 1);
    text.remove_prefix(end + 1);
    while (text.starts_with(' ')) text.remove_prefix(1);
  }
  remark.doc = text;
  remark.bits = text.starts_with("bits: ");
  if (remark.unit != "enum" && !remark.bits) return remark;
  text = text.substr(0, text.find(';'));
  if (const auto behind = text.find(": "); behind != std::string_view::npos) text.remove_prefix(behind + 2);
  remark.names = numbered(text);
  if (remark.names.empty() && !remark.bits) remark.names = counted(text);
  return remark;
}

std::string value_name(const FieldRemark& remark, std::uint64_t value) {
  if (remark.names.empty()) return std::to_string(value);
  std::string text;
  for (const auto& [known, name] : remark.names) {
    if (!remark.bits && known == value) return name;
    if (!remark.bits || known == 0 || (value & known) != known) continue;
    text += (text.empty() ? "" : ", ") + name;
    value &= ~known;
  }
  if (!remark.bits) return std::to_string(value);
  if (value != 0) text += (text.empty() ? "" : ", ") + std::to_string(value);
  return text.empty() ? "none" : text;
}

void put_names(Json& message, const record::Ros2Schema& schema) {
  message = object_named(message, schema, schema.root(), false);
}

void add_names(Json& message, const record::Ros2Schema& schema) {
  message = object_named(message, schema, schema.root(), true);
}

}  // namespace sinew::app
