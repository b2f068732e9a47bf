#include "apps/command/command.hpp"

#include <cstdio>

namespace sinew::app {

std::string version() { return SINEW_VERSION; }

int fail(const std::string& why, int code) {
  std::fprintf(stderr, "sinew: %s\n", why.c_str());
  return code;
}

}  // namespace sinew::app
