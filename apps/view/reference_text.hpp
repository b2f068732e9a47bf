#pragma once
// Types of modules and messages, from what they declare: as text, as JSON, and as the pages in docs/reference.
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "msg/describe.hpp"
#include "rt/module_types.hpp"

namespace sinew::app {

/// One type of module: ports, parameters, saved state.
std::string module_text(const std::string& name, const rt::Declaration& declaration);
nlohmann::ordered_json module_json(const std::string& name, const rt::Declaration& declaration);

/// What a type of module declares; nothing for a name that no type has.
std::optional<rt::Declaration> declaration_of(const rt::ModuleTypes& types, const std::string& name);

/// One type of message: fields with type, unit and the names of values.
std::string message_text(const msg::TypeInfo& type);
nlohmann::ordered_json message_json(const msg::TypeInfo& type);

/// The messages of Sinew and those on the ports of these modules, by name.
std::vector<const msg::TypeInfo*> message_types(const rt::ModuleTypes& types);

/// docs/reference/modules.md and docs/reference/messages.md.
std::string modules_page(const rt::ModuleTypes& types);
std::string messages_page(const rt::ModuleTypes& types);

}  // namespace sinew::app
