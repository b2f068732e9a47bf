#pragma once
#include <string>

namespace sinew::app {

/// Where somebody wrote a line.
struct LinePlace {
  std::string file;
  int line = 0;  // 0: of the file as a whole
};

}  // namespace sinew::app
