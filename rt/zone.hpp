#pragma once
#include "rt/step.hpp"

namespace sinew::rt {

/// A named part of a step, for the time line: from its construction to the end of its scope.
///
///   const rt::Zone zone(step, "blobs");
///
/// While nobody asks for zones it costs two tests. In virtual time, where a step's code takes no time, it has no width.
/// Thread:  executor, inside the step.   RT: yes.
/// Owner:   `name` is a string literal.
class Zone {
 public:
  Zone(const Step& step, const char* name) noexcept : log_(step.zones), name_(name) {
    if (log_) [[unlikely]]
      begin();
  }
  ~Zone() {
    if (log_) [[unlikely]]
      end();
  }
  Zone(const Zone&) = delete;
  Zone& operator=(const Zone&) = delete;

 private:
  void begin() noexcept;
  void end() noexcept;

  ZoneLog* const log_;
  const char* const name_;
  Time start_;
};

}  // namespace sinew::rt
