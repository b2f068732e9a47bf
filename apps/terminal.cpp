#include "apps/terminal.hpp"

#include <cstdio>

namespace sinew::app {

void Redrawn::draw(std::string_view text) {
  if (lines_ > 0) std::printf("\033[%dA", lines_);  // back to the first line
  lines_ = 0;
  for (const char c : text) {
    if (c == '\n') std::printf("\033[K"), ++lines_;  // what is left of the line before
    std::putchar(c);
  }
  std::printf("\033[J");  // lines that are no more
}

}  // namespace sinew::app
