#pragma once
#include <string_view>

namespace sinew::hal {

/// Whether JSON text from outside is nested deeper than this. To be asked before anything is built from it: a parser
/// that calls itself uses stack for each level. Text that is no JSON is answered, too. Thread:  any.
bool is_nested_deeper(std::string_view json, int levels);

}  // namespace sinew::hal
