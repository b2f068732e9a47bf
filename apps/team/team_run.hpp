#pragma once
#include <string>
#include <vector>

#include "apps/command/command.hpp"
#include "apps/command/json.hpp"
#include "apps/team/team_setup.hpp"

namespace sinew::app {

struct MemberEnd {
  std::string name;
  int code = kDone;  // of its process
  Json summary{};    // its JSON object, of a run with --json; else null
};

/// How a run of several robots ended.
struct TeamEnd {
  std::vector<MemberEnd> members{};  // empty: the run could not begin, as was said on standard error
  Json plant{};                      // the simulator's last report; null: none
  int code = kDone;                  // of the worst
};

/// Starts the simulator and a `sinew run` for each member, passes on what they print, and waits for all of them.
/// Thread:  owner; hal::stop_requested() ends it.
TeamEnd run_members(const TeamSetup& setup, const TeamRunOptions& options);

}  // namespace sinew::app
