#pragma once
#include <string_view>

namespace sinew::app {

/// Text on a terminal that is drawn over itself.
/// Thread:  owner.
class Redrawn {
 public:
  void draw(std::string_view text);

 private:
  int lines_ = 0;
};

}  // namespace sinew::app
