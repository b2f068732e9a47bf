#pragma once
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "msg/referee.hpp"
#include "sim_hil/pitch/pitch.hpp"
#include "sim_hil/pitch/referee.hpp"
#include "sim_hil/worlds/world.hpp"

namespace sinew::plant {

/// A game on the pitch: the referee looks at it, and the pitch does what he orders. Two halves, one after the other.
/// Thread:  owner.
class Game {
 public:
  /// A team for each robot.
  Game(const RefereeRules& rules, std::span<const std::uint8_t> teams);
  /// The rules that the world's options describe.
  static RefereeRules rules_of(const WorldInfo& info, const WorldValues& values);

  /// After each step of the pitch.
  void look(Pitch& pitch);
  /// The robots that were put somewhere else by the last look().
  std::span<const std::size_t> moved() const { return moved_; }

  /// What the referee says to a robot now; without a stamp.
  msg::RefereeState said_to(std::size_t robot) const;
  /// So many decisions there were.
  std::size_t decisions() const { return referee_.log().size(); }
  std::uint32_t penalties(std::size_t robot) const;
  /// Score, state and the last decisions.
  void add_to(JsonObject& report) const;

 private:
  Referee referee_;
  std::vector<std::uint8_t> teams_;
  std::vector<Referee::SeenRobot> seen_;
  std::vector<std::size_t> moved_;
  std::int64_t now_ns_ = 0;
};

}  // namespace sinew::plant
