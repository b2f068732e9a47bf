#include "apps/command/json.hpp"

namespace sinew::app {

std::string to_line(const Json& json) { return json.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n"; }

}  // namespace sinew::app
