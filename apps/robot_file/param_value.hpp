#pragma once
#include <string>

#include "rt/declaration.hpp"

namespace sinew::app {

/// A value as it is typed on a command line: true, 3, 0.5; everything else is a text.
rt::ParamValue param_value(const std::string& text);

}  // namespace sinew::app
