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

/// What a parameter accepts, in words: "a number from 0 to 2 rad"; narrowed: "a number from 0 to 100, or -1: control
/// 'gain' of device 'camera'".
std::string allowed_values(const Declaration::Param& param, const std::optional<ParamRange>& narrowed = {});

/// True when the parameter accepts this value; an integer is a number too. Narrowed: both ranges must allow it.
bool accepts(const Declaration::Param& param, const ParamValue& value, const std::optional<ParamRange>& narrowed = {});

/// The part of the device's range that lies within the declared one. Without any such number: only `besides`.
ParamRange within(const Declaration::Param& param, ParamRange range);

/// Writes a value that the parameter accepts. RT: yes, but for strings.
void assign(const Declaration::Param& param, const ParamValue& value);

/// The current value. Thread: the executor of the module, or any while the module stands still.
ParamValue current(const Declaration::Param& param);

const Declaration::Param* find_param(const Declaration& declaration, std::string_view name);

}  // namespace sinew::rt
