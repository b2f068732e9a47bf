#pragma once
#include <string>
#include <string_view>

namespace sinew::app {

/// Text on a terminal; each text replaces the last one.
/// Thread:  owner.
class Redrawn {
 public:
  /// Output that puts `text` in the place of the last one; a text too long for `rows` is cut to its first lines.
  std::string over(std::string_view text, int rows);

 private:
  int lines_ = 0;
};

}  // namespace sinew::app
