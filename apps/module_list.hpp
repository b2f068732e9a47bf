#pragma once
#include "rt/module_types.hpp"

namespace sinew::app {

/// Every module type that the `sinew` program knows. A program of one's own lists its own.
rt::ModuleTypes all_modules();

}  // namespace sinew::app
