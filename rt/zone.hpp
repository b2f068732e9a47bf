#pragma once
#include "rt/step.hpp"

namespace sinew::rt {

/// Where the zones of one module's steps are written, while a reader asks for them. RT: yes.
class ZoneLog {
 public:
  virtual Time now() noexcept = 0;
  virtual void note(const char* name, Time start) noexcept = 0;

 protected:
  ~ZoneLog() = default;
};

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
      start_ = log_->now();
  }
  ~Zone() {
    if (log_) [[unlikely]]
      log_->note(name_, start_);
  }
  Zone(const Zone&) = delete;
  Zone& operator=(const Zone&) = delete;

 private:
  ZoneLog* const log_;
  const char* const name_;
  Time start_;
};

}  // namespace sinew::rt
