#pragma once
// Parameters of one module: what was declared, checked and set.
#include <optional>
#include <string>
#include <string_view>

#include "rt/declaration.hpp"
#include "rt/mailbox.hpp"

namespace sinew::rt {

/// The value as a robot file would write it: true, 3, 0.5, "text".
std::string to_string(const ParamValue& value);
std::string format_number(double value);  // shortest text that reads back as the same number

/// What a parameter accepts, in words: "a number from 0 to 2 rad".
std::string allowed_values(const Declaration::Param& param);

/// True when the parameter accepts this value; an integer is a number too.
bool accepts(const Declaration::Param& param, const ParamValue& value);

/// Writes a value that the parameter accepts. RT: yes, but for strings.
void assign(const Declaration::Param& param, const ParamValue& value);

/// The current value. Thread: the executor of the module, or anybody while it stands still.
ParamValue current(const Declaration::Param& param);

const Declaration::Param* find_param(const Declaration& declaration, std::string_view name);

}  // namespace sinew::rt
