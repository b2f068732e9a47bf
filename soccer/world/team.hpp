#pragma once
#include "msg/gait.hpp"
#include "msg/referee.hpp"
#include "msg/team.hpp"
#include "rt/module.hpp"
#include "soccer/world/roles.hpp"
#include "soccer/world/team_map.hpp"

namespace sinew::soccer {

/// Tells the mates what the robot believes (`report`, to be said in [team]), and puts together what all know (`team`):
/// docs/soccer-world.md.
/// Frames:  out: "field".
/// Thread:  executor; 2 Hz and more.   RT: yes.
/// Errors:  stale while nothing is known of the own place for 2 s, or of the gait for 500 ms where the robot has legs:
///          nothing is reported then.
class Team final : public rt::Module {
 public:
  void declare(rt::Declaration& d) override;
  void reset() override { heard_ = {}, contradicted_ = {}, plays_ = msg::SoccerRole::none, first_step_ = {}; }
  rt::StepStatus step(const rt::Step& step) noexcept override;

 private:
  /// The ball of a report moved by `lie_m_` towards the other half, seen now and sure to a centimetre.
  void lie(rt::Time now, msg::SoccerReport& report) const;
  msg::SoccerRole role_now(const msg::SoccerReport& own, const msg::TeamModel& team, rt::Time now) const;

  static constexpr std::size_t kMates = 7;
  struct Heard {
    std::array<msg::SoccerReport, kMates> report;
  };

  rt::In<msg::FieldPose> field_;
  rt::In<msg::BallModel> ball_;
  rt::In<msg::GaitState> gait_;
  rt::In<msg::RefereeState> referee_;
  rt::In<msg::TeamState> state_;
  rt::InQueue<msg::FromMate<msg::SoccerReport>> mates_;
  rt::Out<msg::TeamModel> team_;
  rt::Out<msg::SoccerReport> report_;
  TeamMapOptions options_;
  RoleOptions roles_;
  double walk_mps_ = 0.2, turn_radps_ = 0.8;
  std::int64_t role_ = 0, goalie_from_ = 2;
  bool legs_ = true, shares_ball_ = false;
  double lie_m_ = 0, lie_from_s_ = 0, lie_for_s_ = 10;

  Heard heard_;                                    // state
  std::array<rt::Time, kMates> contradicted_{};    // state: when the own eyes last did
  msg::SoccerRole plays_ = msg::SoccerRole::none;  // state: its role
  rt::Time first_step_{};                          // state; 0: none yet
};

}  // namespace sinew::soccer
