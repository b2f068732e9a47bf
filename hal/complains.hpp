#pragma once
#include <string>

namespace sinew::hal {

/// Implemented beside Device or CanBus by what goes on while its hardware fails, and can say what is wrong with it.
class Complains {
 public:
  virtual ~Complains() = default;
  /// What is wrong now, in words for people, with the path and what can be done about it; empty: nothing.
  /// Thread:  any.   RT: no.
  virtual std::string problem() const = 0;
};

}  // namespace sinew::hal
