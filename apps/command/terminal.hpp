#pragma once
#include <string>
#include <string_view>

namespace sinew::app {

/// Text on a terminal that is drawn over itself.
/// Thread:  owner.
class Redrawn {
 public:
  /// What to print so that `text` stands where the last one stood; of text that is too long for `rows` the first lines.
  std::string over(std::string_view text, int rows);

 private:
  int lines_ = 0;
};

}  // namespace sinew::app
