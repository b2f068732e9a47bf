#pragma once
#include "rt/module_types.hpp"

namespace sinew::app {

/// The modules that robots are made of: those of drivers, vision, control and of each robot in robots/, by the names
/// that robot files use.
rt::ModuleTypes robot_modules();

}  // namespace sinew::app
