#pragma once
#include "rt/step.hpp"

namespace sinew::rt {

/// A named part of a step, for the time line: from its construction to the end of its scope.
///
///   const rt::Zone zone(step, "blobs");
///
/// While no reader asks for zones, a zone costs two tests. In virtual time, where a step's code takes no time, it has
/// no width. Thread:  executor, inside the step.   RT: yes. Owner:   `name` is a string literal.
class Zone {
 public:
  Zone(const Step& step, const char* name) noexcept : log_(step.zones), name_(name) {
    if (log_) [[unlikely]]
      start_ = now(*log_);
  }
  ~Zone() {
    if (log_) [[unlikely]]
      note(*log_, name_, start_);
  }
  Zone(const Zone&) = delete;
  Zone& operator=(const Zone&) = delete;

 private:
  // Static: so the zone stays in registers.
  static Time now(ZoneLog& log) noexcept;
  static void note(ZoneLog& log, const char* name, Time start) noexcept;

  ZoneLog* const log_;
  const char* const name_;
  Time start_;
};

}  // namespace sinew::rt
