#pragma once
// Cases in processes of their own, so that one that crashes or hangs is a finding and not the end of the search.
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "apps/search/case_flight.hpp"
#include "hal/linux/process.hpp"

namespace sinew::search {

struct Result {
  Outcome outcome;    // a process that died or hung is a violation, too
  std::string error;  // the case could not be flown: no plant, a wrong case
};

/// Starts this program again for each case, several at a time. While it lives, TMPDIR of this process is a folder of
/// its own. Thread:  owner, with no other thread that reads or writes the environment while it is made and ended.
class Pool {
 public:
  /// `command`: this program and the arguments that every case shares; "--case TEXT --json" are added.
  Pool(std::vector<std::string> command, unsigned jobs, hal::Duration patience);
  /// Removes what its flights had in the temporary folder, also those that were ended before they could do so.
  ~Pool();
  Pool(const Pool&) = delete;
  Pool& operator=(const Pool&) = delete;

  /// Calls `done(i, result)` for each case in their order until it answers false or all are done; those that are still
  /// under way are then ended. False: it did not go through to the end.
  bool run(const std::vector<Case>& cases, const std::function<bool(std::size_t, const Result&)>& done);
  std::size_t runs() const { return runs_; }

 private:
  struct Job;
  std::unique_ptr<Job> start(const Case& c);
  bool collect(Job& job);

  const std::vector<std::string> command_;
  const unsigned jobs_;
  const hal::Duration patience_;
  std::string folder_;                   // the temporary folder of its flights; empty: it could not be made
  std::optional<std::string> tmpdir_{};  // TMPDIR before
  std::size_t runs_ = 0;
};

}  // namespace sinew::search
