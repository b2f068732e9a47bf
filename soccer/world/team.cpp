#include "soccer/world/team.hpp"

#include <algorithm>

namespace sinew::soccer {

using namespace std::chrono_literals;

void Team::declare(rt::Declaration& d) {
  d.in("field", field_, {.max_age = 2s});
  d.in("ball", ball_, {.max_age = 2s, .optional = true});
  d.in("gait", gait_, {.max_age = 500ms, .optional = true});
  d.in("referee", referee_, {.max_age = 3s, .optional = true});
  d.in("state", state_, {.max_age = 5s, .optional = true});
  d.in("mates", mates_, {.depth = 16, .optional = true});
  d.out("team", team_);
  d.out("report", report_);
  d.param("heard_s", options_.heard_s,
          {.unit = "s", .min = 0.2, .max = 60, .doc = "a mate that is silent for longer does not count"});
  d.param("ball_s", options_.ball_s,
          {.unit = "s", .min = 0.2, .max = 60, .doc = "older sightings of the ball tell nothing"});
  d.param("ball_mps", options_.ball_mps,
          {.unit = "m/s", .min = 0, .max = 5, .doc = "by which a ball may have been moved since it was seen"});
  d.param("deceleration_mps2", options_.deceleration_mps2,
          {.unit = "m/s^2", .min = 0.01, .max = 5, .doc = "of a rolling ball"});
  d.param("gate", options_.gate, {.min = 1, .max = 200, .doc = "squared difference beyond which two balls are two"});
  d.param("most_mirrored", options_.most_mirrored,
          {.min = 0, .max = 0.5, .doc = "who may so well be in the other half is not believed"});
  d.param("own_eyes_s", options_.own_eyes_s,
          {.unit = "s", .min = 0, .max = 10, .doc = "a ball seen so lately is not overruled by one mate alone"});
  d.param("doubt_s", options_.doubt_s,
          {.unit = "s", .min = 0, .max = 600, .doc = "so long a mate that the own eyes contradicted counts half"});
  d.param("walk_mps", walk_mps_, {.unit = "m/s", .min = 0.01, .max = 5, .doc = "for the time to the ball"});
  d.param("turn_radps", turn_radps_, {.unit = "rad/s", .min = 0.05, .max = 10, .doc = "the same"});
  d.param(
      "role", role_,
      {.min = 0, .max = 3, .doc = "that it always plays: 1 striker, 2 supporter, 3 goalie; 0: as the team needs it"});
  d.param(
      "keeps_s", roles_.keeps_s,
      {.unit = "s", .min = 0, .max = 20, .doc = "by so much sooner another one must be at the ball to be the striker"});
  d.param("feet_m", options_.feet_m,
          {.unit = "m", .min = 0.05, .max = 2, .doc = "a ball nearer than this before the robot is its own"});
  d.param("legs", legs_, {.doc = "it plays while its gait has it on its feet; without: while it knows its place"});
  d.param("goalie_from", goalie_from_,
          {.min = 1, .max = 9, .doc = "so many must play before one of them keeps the goal; 9: nobody does"});
  d.param("shares_ball", shares_ball_,
          {.doc = "the time to the ball is that to the team's ball where its own eyes have none"});
  d.param("lie_m", lie_m_,
          {.unit = "m",
           .min = -10,
           .max = 10,
           .doc = "for tests of its mates: it reports the ball so far from where it is, towards the other half, very "
                  "sure; 0: it tells the truth"});
  d.param("lie_from_s", lie_from_s_,
          {.unit = "s", .min = 0, .max = 1e6, .doc = "after its first step it begins to lie"});
  d.param("lie_for_s", lie_for_s_, {.unit = "s", .min = 0, .max = 1e6, .doc = "and so long it does"});
  d.state(heard_, contradicted_, plays_, first_step_);
}

void Team::lie(rt::Time now, msg::SoccerReport& report) const {
  const double since_s = msg::seconds(now - first_step_) - lie_from_s_;
  if (lie_m_ == 0 || since_s < 0 || since_s >= lie_for_s_) return;
  report.ball.x_m -= static_cast<float>(math::copysign(lie_m_, double{report.ball.x_m}));
  report.ball.xx_m2 = report.ball.yy_m2 = 1e-4F;
  report.ball.xy_m2 = 0;
  report.ball_confidence = 1;
  report.ball_seen = report.stamp;
}

msg::SoccerRole Team::role_now(const msg::SoccerReport& own, const msg::TeamModel& team, rt::Time now) const {
  if (own.plays == 0) return msg::SoccerRole::none;
  if (role_ != 0) return static_cast<msg::SoccerRole>(role_);
  const msg::TeamState* state = state_.get();
  std::array<Player, kMates + 1> players;
  const std::uint32_t number = state ? state->robot : 0;
  std::size_t n = 0;
  players[n++] = {number, own.to_ball_s, plays_, true};
  for (std::size_t i = 0; state && i < std::min<std::size_t>(kMates, state->mates); ++i) {
    const msg::SoccerReport& r = team.mate[i];
    const bool heard = r.stamp.ns > 0 && msg::seconds(now - r.stamp) < options_.heard_s;
    const bool believed = (team.distrusted >> i & 1) == 0;
    players[n++] = {state->mate[i].robot, believed ? double{r.to_ball_s} : math::kInf, r.role, heard && r.plays != 0};
  }
  RoleOptions roles = roles_;
  roles.goalie_from = static_cast<std::size_t>(goalie_from_);
  return choose_role(std::span(players).first(n), number, roles);
}

rt::StepStatus Team::step(const rt::Step& step) noexcept {
  if (first_step_.ns == 0) first_step_ = step.now;
  const msg::TeamState* state = state_.get();
  for (const msg::FromMate<msg::SoccerReport>& m : mates_) {
    // The mate's place in the order of the robot file.
    if (!state) continue;
    for (std::size_t i = 0; i < std::min<std::size_t>(kMates, state->mates); ++i)
      if (state->mate[i].robot == m.robot) heard_.report[i] = m.message;
  }
  const msg::FieldPose* field = field_.fresh(step.now);
  const msg::GaitState* gait = gait_.fresh(step.now);
  if (!field || (legs_ && !gait)) return rt::StepStatus::stale;
  const msg::BallModel* ball = ball_.fresh(step.now);
  const msg::RefereeState* said = referee_.fresh(step.now);

  msg::SoccerReport& report = report_.loan();
  report.stamp = field->stamp;
  fill_report(*field, ball, options_, report);
  report.plays = (!legs_ || msg::on_its_feet(gait->mode)) && !(said && said->penalty != msg::GamePenalty::none) ? 1 : 0;
  report.to_ball_s = static_cast<float>(math::kInf);
  const bool never_kicks = role_ != 0 && role_ != static_cast<std::int64_t>(msg::SoccerRole::striker);
  const auto takes_s = [&](double x_m, double y_m) {
    return static_cast<float>(math::hypot(x_m, y_m) / walk_mps_ + math::fabs(math::atan2(y_m, x_m)) / turn_radps_);
  };
  if (ball && report.ball_seen.ns > 0 && report.plays != 0 && !never_kicks)
    report.to_ball_s = takes_s(ball->x_m, ball->y_m);

  msg::TeamModel& team = team_.loan();
  team.stamp = step.now;
  team.mate = heard_.report;
  std::uint32_t doubted = 0;
  for (std::size_t i = 0; i < kMates; ++i)
    if (contradicted_[i].ns > 0 && msg::seconds(step.now - contradicted_[i]) < options_.doubt_s) doubted |= 1U << i;
  put_together(ball ? own_ball(*ball, *field, options_) : std::nullopt, step.now, options_, doubted, team);
  if ((team.ball_from >> kOwnBallBit & 1) != 0)
    for (std::size_t i = 0; i < kMates; ++i)
      if ((team.distrusted >> i & 1) != 0) contradicted_[i] = step.now;
  if (shares_ball_ && report.to_ball_s == static_cast<float>(math::kInf) && team.ball_seen.ns > 0 &&
      report.plays != 0 && !never_kicks) {
    const FieldPoint at = FieldAt{field->x_m, field->y_m, field->heading_rad}.in(team.ball_x_m, team.ball_y_m);
    report.to_ball_s = takes_s(at.x_m, at.y_m);
  }
  plays_ = role_now(report, team, step.now);
  lie(step.now, report);
  report.role = team.role = plays_;
  return rt::StepStatus::ok;
}

}  // namespace sinew::soccer
