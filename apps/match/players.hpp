#pragma once
// The players of a match: a robot file for each, made from the file of its team.
#include <string>
#include <vector>

#include "apps/match/match_options.hpp"
#include "apps/robot_file/robot_file.hpp"
#include "rt/graph.hpp"

namespace sinew::app {

struct Player {
  std::string name;     // "blue1": its robot's name in the world
  unsigned team = 0;    // of MatchOptions::teams
  unsigned colour = 0;  // 0: blue, defends -x in the first half; 1: red
  unsigned number = 1;  // in its team
};

/// Blue first.
std::vector<Player> players_of(const MatchOptions& options);

/// Threads of a robot whose steps a match records: all but those that are released every 10 ms or more often, and those
/// that a topic of such a thread releases.
std::vector<std::string> slow_threads(const rt::GraphSpec& graph);

/// Modules with a parameter `player`: they want to know the player's number in its team.
std::vector<std::string> numbered_modules(const rt::Graph& graph);

/// Modules with a parameter `lie_m`: they tell the mates where the ball is.
std::vector<std::string> reporting_modules(const rt::Graph& graph);

/// A fault that is no device's: what a player tells its mates. "report:wrong(3)@60+10" as settings of the module
/// `module`: "team.lie_m=3" and so on; m, -10 to 10, 3 where none is given.
/// Errors:  nothing is returned; `why` says what is wrong and what is allowed.
std::vector<std::string> lie_settings(const std::string& fault, const std::string& module, std::string& why);
/// It begins with "report:".
bool is_lie(std::string_view fault);

/// The robot file of a player. `base`: the path of its team's, `loaded`: what is in that, `numbered`:
/// numbered_modules().
std::string player_text(const MatchOptions& options, const Player& player, const std::string& base,
                        const RobotFile& loaded, const std::vector<std::string>& numbered);

/// Why no match can be played with this robot; empty: one can.
std::string why_no_player(const RobotFile& robot);

}  // namespace sinew::app
