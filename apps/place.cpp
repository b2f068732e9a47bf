#include "apps/place.hpp"

namespace sinew::app {

std::string package_folder() { return SINEW_BUILD; }
std::string program_folder() { return SINEW_BUILD "/bin"; }

}  // namespace sinew::app
