#include "apps/view/reference_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>

#include "apps/view/graph_text.hpp"
#include "msg/all.hpp"
#include "msg/text.hpp"

namespace sinew::app {
namespace {

using Json = nlohmann::ordered_json;
using Port = rt::Declaration::Port;
using Param = rt::Declaration::Param;

constexpr const char* kModulesHead = R"(# Modules

This page is written by the test `apps_reference_pages_test` from what the modules declare: `SINEW_WRITE_DOCS=1 apps_reference_pages_test` writes
it anew, and the test fails when it differs. `sinew module info TYPE` prints one of them, also of your own program's modules.
[robot-file.md](../robot-file.md) says how a module stands in a robot file, [messages.md](messages.md) what the messages hold.
)";
constexpr const char* kMessagesHead = R"(# Messages

This page is written by the test `apps_reference_pages_test` from the descriptions of the messages: `SINEW_WRITE_DOCS=1 apps_reference_pages_test`
writes it anew, and the test fails when it differs. `sinew topic info TYPE` prints one of them, also of your own program's messages.
Frames, axes and angles follow REP-103; times are nanoseconds on the robot's clock.
)";

std::string message_name(const Port& port) { return port.type ? std::string(port.type->name) : "any message"; }

const char* kind_name(const Port& port) {
  switch (port.kind) {
    case rt::Declaration::PortKind::latest:
      return "in";
    case rt::Declaration::PortKind::queue:
      return "in, queue";
    case rt::Declaration::PortKind::output:
      return "out";
    case rt::Declaration::PortKind::raw:
      return "device";
  }
  return "";
}

/// What is special about a port: "queue of 8, drops the oldest; may stay unbound".
std::string port_remarks(const Port& port) {
  std::vector<std::string> remarks;
  if (port.kind == rt::Declaration::PortKind::queue)
    remarks.push_back(fmt::format("holds {}, drops the {}", port.depth,
                                  port.overflow == rt::Overflow::drop_oldest ? "oldest" : "newest"));
  if (port.max_age.count() != INT64_MAX) remarks.push_back("fresh for " + human(port.max_age));
  if (port.optional) remarks.push_back("may stay unbound");
  if (port.previous) remarks.push_back("of the previous cycle");
  if (port.channels > 0) remarks.push_back(fmt::format("{} channels", port.channels));
  return fmt::format("{}", fmt::join(remarks, "; "));
}

const char* param_type(const Param& param) {
  constexpr std::array<const char*, 4> kNames{"bool", "integer", "number", "text"};
  return kNames[param.default_value.index()];
}

std::string number_text(double value) { return fmt::format("{:g}", value); }

std::string value_text(const rt::ParamValue& value) {
  if (const auto* b = std::get_if<bool>(&value)) return *b ? "true" : "false";
  if (const auto* i = std::get_if<std::int64_t>(&value)) return std::to_string(*i);
  if (const auto* d = std::get_if<double>(&value)) return number_text(*d);
  return "\"" + std::get<std::string>(value) + "\"";
}

bool has_min(const Param& p) { return p.min > -std::numeric_limits<double>::max(); }
bool has_max(const Param& p) { return p.max < std::numeric_limits<double>::max(); }

/// "0 to 10", "from 0 up", "any".
std::string allowed_text(const Param& p) {
  if (p.default_value.index() == 0) return "true, false";
  if (p.default_value.index() == 3) return "any text";
  if (has_min(p) && has_max(p)) return number_text(p.min) + " to " + number_text(p.max);
  if (has_min(p)) return "from " + number_text(p.min) + " up";
  return has_max(p) ? "up to " + number_text(p.max) : "any";
}

/// A row of a table without the space behind its last word.
std::string table_row(std::string text) {
  while (text.ends_with(' ')) text.pop_back();
  return text + "\n";
}

std::string state_text(const rt::Declaration& d) {
  if (d.states.empty()) return "none declared";
  return fmt::format("{} part{}, saved in recordings", d.states.size(), d.states.size() == 1 ? "" : "s");
}

// ---- messages

std::string element_type(const msg::FieldInfo& f) {
  constexpr std::array<const char*, 10> kNames{"int8",   "uint8", "int16",  "uint16",  "int32",
                                               "uint32", "int64", "uint64", "float32", "float64"};
  const std::string name =
      f.kind == msg::Kind::nested ? std::string(f.nested->name) : kNames[static_cast<std::size_t>(f.kind)];
  return f.is_array ? fmt::format("{}[{}]", name, f.count) : name;
}

// ---- pages

std::string cell(std::string_view text) {
  std::string out;
  for (const char c : text) out += c == '|' ? std::string("\\|") : std::string(1, c);
  return out;
}

std::string code(std::string_view text) { return text.empty() ? std::string() : fmt::format("`{}`", text); }

std::string message_link(const Port& port) {
  if (!port.type) return "any message";
  std::string anchor(port.type->name);
  std::transform(anchor.begin(), anchor.end(), anchor.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  return fmt::format("[{}](messages.md#{})", port.type->name, anchor);
}

void add_nested(const msg::TypeInfo& type, std::vector<const msg::TypeInfo*>& all) {
  if (std::find(all.begin(), all.end(), &type) != all.end()) return;
  all.push_back(&type);
  for (const msg::FieldInfo& f : type.fields)
    if (f.nested) add_nested(*f.nested, all);
}

}  // namespace

std::optional<rt::Declaration> declaration_of(const rt::ModuleTypes& types, const std::string& name) {
  const auto module = types.make(name);
  if (!module) return std::nullopt;
  rt::Declaration declaration;
  module->declare(declaration);
  // The module ends here: what it declared may be read, what it points to not.
  for (auto& port : declaration.ports) port.input = nullptr, port.output = nullptr;
  for (auto& state : declaration.states) state.member = nullptr;
  return declaration;
}

std::string module_text(const std::string& name, const rt::Declaration& d) {
  std::string out = name + (d.is_best_effort ? ": for threads without real-time priority\n" : "\n");
  out += fmt::format("state     {}\n", state_text(d));
  if (!d.ports.empty()) out += "ports\n";
  for (const Port& p : d.ports) {
    const std::string remarks = port_remarks(p);
    out += fmt::format("  {:<20} {:<10} {}{}\n", p.name, kind_name(p), message_name(p),
                       remarks.empty() ? "" : "; " + remarks);
  }
  if (!d.params.empty())
    out += fmt::format("parameters\n  {:<22} {:<8} {:<8} {:<12} {:<16} {}\n", "name", "type", "unit", "default",
                       "allowed", "meaning");
  for (const Param& p : d.params)
    out += table_row(fmt::format("  {:<22} {:<8} {:<8} {:<12} {:<16} {}", p.name, param_type(p), p.unit,
                                 value_text(p.default_value), allowed_text(p), p.doc));
  return out;
}

Json module_json(const std::string& name, const rt::Declaration& d) {
  Json json{{"type", name}, {"best_effort", d.is_best_effort}, {"states", d.states.size()}};
  json["ports"] = Json::array();
  for (const Port& p : d.ports) {
    Json port{{"name", p.name}, {"kind", kind_name(p)}, {"message", p.type ? Json(p.type->name) : Json()}};
    port["optional"] = p.optional;
    if (p.kind == rt::Declaration::PortKind::queue) port["depth"] = p.depth;
    if (p.max_age.count() != INT64_MAX) port["max_age_ns"] = p.max_age.count();
    json["ports"].push_back(std::move(port));
  }
  json["params"] = Json::array();
  for (const Param& p : d.params) {
    Json param{{"name", p.name}, {"type", param_type(p)}, {"unit", p.unit}};
    param["default"] = std::visit([](const auto& v) { return Json(v); }, p.default_value);
    if (has_min(p)) param["min"] = p.min;
    if (has_max(p)) param["max"] = p.max;
    param["doc"] = p.doc;
    json["params"].push_back(std::move(param));
  }
  return json;
}

std::string message_text(const msg::TypeInfo& type) {
  std::string out = fmt::format("{}: {}\n", type.name, type.doc);
  for (const msg::FieldInfo& f : type.fields)
    out += table_row(fmt::format("  {:<22} {:<12} {:<8} {}", f.name, element_type(f), f.unit, msg::remark_of(f)));
  if (type.has_bulk())
    out += fmt::format("  {:<22} {:<12} {:<8} bytes behind the fields\n", type.bulk_name, "uint8[]", "");
  return out;
}

Json message_json(const msg::TypeInfo& type) {
  Json json{{"type", type.name}, {"doc", type.doc}, {"bytes", type.size}, {"fields", Json::array()}};
  for (const msg::FieldInfo& f : type.fields)
    json["fields"].push_back({{"name", f.name},
                              {"type", f.kind == msg::Kind::nested ? std::string(f.nested->name) : element_type(f)},
                              {"unit", f.unit},
                              {"doc", msg::remark_of(f)}});
  return json;
}

std::vector<const msg::TypeInfo*> message_types(const rt::ModuleTypes& types) {
  std::vector<const msg::TypeInfo*> all;
  for (const msg::TypeInfo* type : msg::all_types()) add_nested(*type, all);
  for (const std::string& name : types.names())
    if (const auto declaration = declaration_of(types, name))
      for (const Port& p : declaration->ports)
        if (p.type) add_nested(*p.type, all);
  std::sort(all.begin(), all.end(), [](const auto* a, const auto* b) { return a->name < b->name; });
  return all;
}

std::string modules_page(const rt::ModuleTypes& types) {
  std::string page = kModulesHead;
  for (const std::string& name : types.names()) {
    const auto d = declaration_of(types, name);
    page += fmt::format("\n## `{}`\n\n{}Saved state: {}.\n", name,
                        d->is_best_effort ? "For threads without real-time priority. " : "", state_text(*d));
    if (!d->ports.empty()) page += "\n| port | | message | |\n|---|---|---|---|\n";
    for (const Port& p : d->ports)
      page += fmt::format("| {} | {} | {} | {} |\n", code(p.name), kind_name(p), message_link(p), port_remarks(p));
    if (!d->params.empty())
      page += "\n| parameter | type | unit | default | allowed | meaning |\n|---|---|---|---|---|---|\n";
    for (const Param& p : d->params)
      page += fmt::format("| {} | {} | {} | {} | {} | {} |\n", code(p.name), param_type(p), p.unit,
                          code(value_text(p.default_value)), allowed_text(p), cell(p.doc));
  }
  return page;
}

std::string messages_page(const rt::ModuleTypes& types) {
  std::string page = kMessagesHead;
  for (const msg::TypeInfo* type : message_types(types)) {
    page += fmt::format("\n## {}\n\n{}\n\n| field | type | unit | |\n|---|---|---|---|\n", type->name, type->doc);
    for (const msg::FieldInfo& f : type->fields)
      page += fmt::format("| {} | {} | {} | {} |\n", code(f.name), element_type(f), f.unit, cell(msg::remark_of(f)));
    if (type->has_bulk()) page += fmt::format("| {} | uint8[] | | bytes behind the fields |\n", code(type->bulk_name));
  }
  return page;
}

}  // namespace sinew::app
