#pragma once
#include "rt/module_types.hpp"

namespace sinew::app {

/// Every module type that the `sinew` program knows. Your own program lists its own types.
rt::ModuleTypes all_modules();

}  // namespace sinew::app
