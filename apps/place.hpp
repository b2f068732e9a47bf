#pragma once
#include <string>

namespace sinew::app {

/// Where the build of this library keeps what other programs than `sinew` need of it, too.
std::string package_folder();  // with SinewConfig.cmake
std::string program_folder();  // with sinew and sinew-sim

}  // namespace sinew::app
