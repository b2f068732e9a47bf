#include "apps/command/terminal.hpp"

namespace sinew::app {

std::string Redrawn::over(std::string_view text, int rows) {
  std::string out = lines_ > 0 ? "\033[" + std::to_string(lines_) + "A" : std::string();  // back to the first line
  lines_ = 0;
  for (const char c : text) {
    if (lines_ + 1 >= rows) break;             // the last row is the cursor's
    if (c == '\n') out += "\033[K", ++lines_;  // clears the rest of the older line
    out += c;
  }
  return out + "\033[J";  // clears older lines below
}

}  // namespace sinew::app
