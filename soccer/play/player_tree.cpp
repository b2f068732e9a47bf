#include "soccer/play/player_tree.hpp"

#include <algorithm>

namespace sinew::soccer {
namespace {

using behaviour::Here;
using behaviour::Look;
using behaviour::Parameters;
using msg::GamePhase;
using msg::SoccerRole;

constexpr double kBall_m = 0.07, kLooksDown_rad = 0.35, kSweep_rad = 1.2, kSweep_s = 3;
constexpr double kGlance_s = 0.9, kGlanceEach_s = 2.6;  // away from a ball that is not near
constexpr double kFollow_mps = 0.1, kFollow_s = 0.8;
constexpr double kNearBall_m = 0.6;
constexpr double kPost_m = 0.05, kNet_m = 0.3;  // a post, and how far behind it the net is kept off, too
constexpr double kBallRadius_m = 0.12;          // that is not to be touched on the way round it

double ball_m(const PlayBoard& b) { return length_m(b.ball); }
bool sees_ball(const PlayBoard& b) { return b.ball_age_s < b.options->ball_old_s && !b.ball_gone; }

void look_along(PlayBoard& b, double yaw_rad, double down_rad) {
  const math::SinCos yaw = math::sincos(yaw_rad), down = math::sincos(down_rad);
  b.gaze.aim = msg::GazeAim::direction;
  b.gaze.frame = msg::GazeFrame::robot;
  b.gaze.to = {down.cos * yaw.cos, down.cos * yaw.sin, -down.sin};
}

/// From side to side, near and far in turn.
void sweep(PlayBoard& b) {
  const double turn = math::fmod(b.now_s, 2 * kSweep_s) / kSweep_s;  // 0 to 2
  const double part = turn < 1 ? turn : 2 - turn;
  look_along(b, kSweep_rad * (2 * part - 1), turn < 1 ? 0.7 * kLooksDown_rad : 1.8 * kLooksDown_rad);
}

void look_at_ball(PlayBoard& b) {
  if (ball_m(b) > kNearBall_m && math::fmod(b.now_s, kGlanceEach_s) < kGlance_s) {
    sweep(b);  // where am I?
    return;
  }
  b.gaze.aim = msg::GazeAim::point;
  b.gaze.frame = msg::GazeFrame::robot;
  b.gaze.to = {b.ball.x_m, b.ball.y_m, kBall_m};
}

void look(PlayBoard& b) { sees_ball(b) ? look_at_ball(b) : sweep(b); }

void stand(PlayBoard& b) { b.walk = {}; }

void go_to(PlayBoard& b, const FieldAt& place, bool round_ball) {
  std::array<Round, 13 + 8> rounds;
  std::size_t n = 0;
  for (; n < b.others_n; ++n) rounds[n] = b.others[n];
  if (b.found)
    for (const FieldPoint& post : b.field->posts())
      for (const double behind_m : {0.0, kNet_m})
        rounds[n++] = {b.self.in(post.x_m + math::copysign(behind_m, post.x_m), post.y_m), kPost_m};
  if (round_ball && sees_ball(b)) rounds[n++] = {b.ball, kBallRadius_m - b.options->walk.margin_m + 0.1};
  b.walk = walk_to(b.self.way_to(place), std::span(rounds).first(n), b.options->walk);
}

FieldAt behind(const FieldAt& place, double m) {
  const FieldPoint at = place.out(-m, 0);
  return {at.x_m, at.y_m, place.heading_rad};
}

/// The kick for the ball as it lies now, and its place in the frame "robot".
void choose(PlayBoard& b) {
  std::array<Round, 12> others;
  for (std::size_t i = 0; i < b.others_n; ++i)
    others[i] = {b.self.out(b.others[i].at.x_m, b.others[i].at.y_m), b.others[i].radius_m};
  const double aim = aim_rad(b.ball_at, *b.field, std::span(others).first(b.others_n));
  b.chosen = choose_kick(b.self, b.ball_at, aim, std::span(others).first(b.others_n), &b.chosen, b.options->kicks);
}

void ask_for_kick(PlayBoard& b) {
  const KickKind& kind = b.options->kicks.kinds[b.chosen.kind];
  b.ask.motion = kind.motion;
  b.ask.foot = b.chosen.foot;
  b.ask.in_walk = kind.in_walk ? 1 : 0;
  b.kicks = true;
}

bool at_place(const PlayBoard& b, Look& look, const FieldAt& place, double within_m) {
  const FieldAt off = b.self.way_to(place);
  return look("place_m", math::hypot(off.x_m, off.y_m)) < within_m &&
         look("place_rad", math::fabs(off.heading_rad)) < b.options->near_place_rad;
}

bool others_kick(const PlayBoard& b, Look& look) {
  const double moved_m = look("ball_moved_m", b.ball_known ? length_m(b.ball_at - b.ball_before) : 0);
  return look("kick_of", static_cast<double>(b.kick_of)) == static_cast<double>(msg::GameKick::other) && moved_m < 0.15;
}

bool in(const PlayBoard& b, Look& look, GamePhase phase) {
  return look("phase", static_cast<double>(b.phase)) == static_cast<double>(phase);
}

/// The motion at the ball that was asked for in this state is over, one way or the other.
bool request_is_over(const PlayBoard& b, Look& look) {
  return look.in_state_s() > 0.2 && (look("kick_done", b.kick_done) || look("kick_failed", b.kick_failed));
}

double ball_from_own_goal_m(const PlayBoard& b, Look& look) {
  return look("ball_from_goal_m", length_m(b.ball_at - FieldPoint{-0.5 * b.field->size().length_m, 0}));
}

bool turned_round(const PlayBoard& b, Look& look) {
  return look.in_state_s() * b.options->search_turn_radps > 2 * math::kPi;
}

void add_game(behaviour::Tree<PlayBoard>& tree) {
  auto& game = tree.option("game");
  game.always("halt", "not_on_feet_or_out", [](const PlayBoard& b, Look& look) {
    return look("penalised", b.penalised) || !look("on_feet", b.on_feet) || !look("may_move", b.may_move) ||
           b.phase == GamePhase::initial || b.phase == GamePhase::finished;
  });
  static constexpr auto is_ready = [](const PlayBoard& b, Look& look) { return in(b, look, GamePhase::ready); };
  static constexpr auto is_set = [](const PlayBoard& b, Look& look) { return in(b, look, GamePhase::set); };
  static constexpr auto is_playing = [](const PlayBoard& b, Look& look) { return in(b, look, GamePhase::playing); };
  // The way out of `halt` is taken only when what leads into it does not hold.
  static constexpr auto fit = [](const PlayBoard& b) { return !b.penalised && b.on_feet && b.may_move; };
  game.state("halt")
      .act([](PlayBoard& b, const Here&) { stand(b), look(b); })
      .to("ready", "ready", [](const PlayBoard& b, Look& look) { return fit(b) && is_ready(b, look); })
      .to("set", "set", [](const PlayBoard& b, Look& look) { return fit(b) && is_set(b, look); })
      .to("playing", "playing", [](const PlayBoard& b, Look& look) { return fit(b) && is_playing(b, look); });
  game.state("ready")
      .act([](PlayBoard& b, const Here&) {
        look(b);
        if (b.found)
          go_to(b, ready_place(b.player, b.kick_of == msg::GameKick::own, *b.field), true);  // else out of the circle
        else
          b.walk = {0, 0, b.options->search_turn_radps};
      })
      .to("set", "set", is_set)
      .to("playing", "playing", is_playing);
  game.state("set")
      .act([](PlayBoard& b, const Here&) {
        stand(b), look(b);
        b.ball_before = b.ball_at;
      })
      .to("ready", "ready", is_ready)
      .to("playing", "playing", is_playing);
  game.state("playing").calls("play").to("ready", "ready", is_ready).to("set", "set", is_set);
}

void add_play(behaviour::Tree<PlayBoard>& tree) {
  auto& play = tree.option("play");
  static constexpr auto is = [](const PlayBoard& b, Look& look, SoccerRole role) {
    return look("role", static_cast<double>(b.role)) == static_cast<double>(role);
  };
  play.always("wait", "others_kick",
              [](const PlayBoard& b, Look& look) { return others_kick(b, look) && b.role != SoccerRole::goalie; });
  play.state("choose")
      .act([](PlayBoard& b, const Here&) { stand(b), look(b); })
      .to("striker", "striker", [](const PlayBoard& b, Look& look) { return is(b, look, SoccerRole::striker); })
      .to("supporter", "supporter", [](const PlayBoard& b, Look& look) { return is(b, look, SoccerRole::supporter); })
      .to("goalie", "goalie", [](const PlayBoard& b, Look& look) { return is(b, look, SoccerRole::goalie); });
  play.state("wait")
      .act([](PlayBoard& b, const Here&) {
        look(b);
        stand(b);
        if (sees_ball(b) && ball_m(b) < b.options->clear_m)  // away from it
          b.walk = {b.ball.x_m > 0 ? -b.options->walk.back_mps : b.options->walk.forward_mps, 0, 0};
      })
      .to("choose", "free", [](const PlayBoard& b, Look& look) { return !others_kick(b, look); });
  play.state("striker").calls("striker").to(
      "choose", "role", [](const PlayBoard& b, Look& look) { return !is(b, look, SoccerRole::striker); });
  play.state("supporter").calls("supporter").to("choose", "role", [](const PlayBoard& b, Look& look) {
    return !is(b, look, SoccerRole::supporter);
  });
  play.state("goalie").calls("goalie").to(
      "choose", "role", [](const PlayBoard& b, Look& look) { return !is(b, look, SoccerRole::goalie); });
}

void add_striker(behaviour::Tree<PlayBoard>& tree) {
  auto& striker = tree.option("striker");
  static constexpr auto no_ball = [](const PlayBoard& b, Look& look) {
    return look("ball_age_s", std::min(b.ball_age_s, 999.0)) > b.options->ball_old_s || look("ball_gone", b.ball_gone);
  };
  static constexpr auto lost = [](const PlayBoard& b, Look& look) {
    return no_ball(b, look) || !look("found", b.found);
  };
  striker.state("search").calls("search").to("approach", "sees_ball",
                                             [](const PlayBoard& b, Look& look) { return !lost(b, look); });
  striker.state("approach")
      .act([](PlayBoard& b, const Here&) {
        look_at_ball(b);
        choose(b);
        go_to(b, behind(b.chosen.from, b.options->behind_m), true);
      })
      .to("search", "lost_ball", lost)
      .to("align", "behind_ball", [](const PlayBoard& b, Look& look) {
        const FieldAt off = b.self.way_to(behind(b.chosen.from, b.options->behind_m));
        return look("place_m", math::hypot(off.x_m, off.y_m)) < 0.1 &&
               look("place_rad", math::fabs(off.heading_rad)) < 0.3;
      });
  striker.state("align")
      .act([](PlayBoard& b, const Here&) {
        look_at_ball(b);
        choose(b);
        go_to(b, b.chosen.from, false);
      })
      .to("search", "lost_ball", no_ball)
      .to("kick", "at_place",
          [](const PlayBoard& b, Look& look) { return at_place(b, look, b.chosen.from, b.options->near_place_m); })
      .to("approach", "ball_moved", [](const PlayBoard& b, Look& look) {
        const FieldAt off = b.self.way_to(b.chosen.from);
        return look("place_m", math::hypot(off.x_m, off.y_m)) > 0.3 ||
               look("place_rad", math::fabs(off.heading_rad)) > 0.8;
      });
  striker.state("kick")
      .act([](PlayBoard& b, const Here& here) {
        stand(b);
        look_at_ball(b);
        if (here.in_state_s == 0) ask_for_kick(b);
      })
      .to("follow", "done", request_is_over)
      .to("follow", "too_long", [](const PlayBoard&, Look& look) { return look.in_state_s() > 6; });
  // A body that has just kicked sways: it goes on gently before it turns or goes back.
  striker.state("follow")
      .act([](PlayBoard& b, const Here&) {
        b.walk = {kFollow_mps, 0, 0};
        look_at_ball(b);
      })
      .to("search", "calm", [](const PlayBoard&, Look& look) { return look.in_state_s() > kFollow_s; });

  auto& search = tree.option("search");
  search.state("look_around")
      .act([](PlayBoard& b, const Here&) { stand(b), sweep(b); })
      .to("go_there", "team_knows",
          [](const PlayBoard& b, Look& look) {
            return look("ball_known", b.ball_known) && b.ball_age_s > b.options->ball_old_s && b.found;
          })
      .to("turn", "nothing", [](const PlayBoard&, Look& look) { return look.in_state_s() > kSweep_s; });
  search.state("turn")
      .act([](PlayBoard& b, const Here&) {
        sweep(b);
        // To the side on which it was last; from the beginning to the left.
        const double side = b.ball_age_s < math::kInf && b.ball.y_m < 0 ? -1 : 1;
        b.walk = {0, 0, side * b.options->search_turn_radps};
      })
      .to("walk", "turned_round", [](const PlayBoard& b, Look& look) { return turned_round(b, look) && b.found; })
      .to("look_around", "not_found", [](const PlayBoard& b, Look& look) { return turned_round(b, look) && !b.found; });
  search.state("walk")
      .act([](PlayBoard& b, const Here&) {
        sweep(b);
        // To the middle of the half of the field in which it is not.
        const double quarter_m = 0.25 * b.field->size().length_m;
        const FieldPoint to{b.self.x_m > 0 ? -quarter_m : quarter_m, 0};
        go_to(b, {to.x_m, to.y_m, bearing_rad(to - FieldPoint{b.self.x_m, b.self.y_m})}, false);
      })
      .to("turn", "there", [](const PlayBoard&, Look& look) { return look.in_state_s() > 12; });
  search.state("go_there")
      .act([](PlayBoard& b, const Here&) {
        sweep(b);
        const FieldPoint way = b.ball_at - FieldPoint{b.self.x_m, b.self.y_m};
        go_to(b, {b.ball_at.x_m, b.ball_at.y_m, bearing_rad(way)}, false);
      })
      .to("turn", "nothing_there", [](const PlayBoard& b, Look& look) {
        const double m = look("to_ball_m", length_m(b.ball_at - FieldPoint{b.self.x_m, b.self.y_m}));
        return m < 0.5 || !look("ball_known", b.ball_known);
      });
}

void add_others(behaviour::Tree<PlayBoard>& tree) {
  auto& supporter = tree.option("supporter");
  static constexpr auto knows = [](const PlayBoard& b, Look& look) {
    return look("ball_known", b.ball_known) && look("found", b.found);
  };
  supporter.state("follow")
      .act([](PlayBoard& b, const Here&) {
        look(b);
        go_to(b, supporter_place(b.ball_at, *b.field, b.options->supporter_behind_m), true);
      })
      .to("search", "lost", [](const PlayBoard& b, Look& look) { return !knows(b, look); });
  supporter.state("search").calls("search").to("follow", "knows", knows);

  auto& goalie = tree.option("goalie");
  static constexpr auto comes = [](const PlayBoard& b, Look& look) {
    const double toward = -(b.ball.x_m * b.ball_mps.x_m + b.ball.y_m * b.ball_mps.y_m) / std::max(ball_m(b), 0.01);
    return sees_ball(b) && look("ball_comes_mps", toward) > b.options->stop_least_mps &&
           look("ball_m", ball_m(b)) < 1.5;
  };
  static constexpr auto near = [](const PlayBoard& b, Look& look) {
    return sees_ball(b) && b.found && ball_from_own_goal_m(b, look) < b.options->goalie_out_m;
  };
  goalie.state("guard")
      .act([](PlayBoard& b, const Here&) {
        look(b);
        if (!b.found)
          b.walk = {0, 0, b.options->search_turn_radps};
        else
          go_to(b, goalie_place(b.ball_known ? b.ball_at : FieldPoint{0, 0}, *b.field), false);
      })
      .to("stop", "ball_comes", comes)
      .to("clear", "ball_is_near", near);
  goalie.state("stop")
      .act([](PlayBoard& b, const Here& here) {
        stand(b);
        look_at_ball(b);
        if (here.in_state_s > 0) return;
        b.ask.motion = msg::BallMotion::stop;
        b.ask.foot = b.ball.y_m > 0 ? msg::Foot::left : msg::Foot::right;
        b.ask.in_walk = 0;
        b.kicks = true;
      })
      .to("guard", "done", request_is_over)
      .to("guard", "too_long", [](const PlayBoard&, Look& look) { return look.in_state_s() > 8; });
  goalie.state("clear").calls("striker").to("guard", "ball_is_away", [](const PlayBoard& b, Look& look) {
    return ball_from_own_goal_m(b, look) > b.options->goalie_out_m + 0.4 || !look("ball_known", b.ball_known);
  });
}

}  // namespace

FieldAt ready_place(std::uint32_t player, bool own_kick_off, const Field& field) {
  const FieldSize& s = field.size();
  switch (player) {
    case 1:  // in its goal
      return {-0.5 * s.length_m + 0.3, 0, 0};
    case 2:
      return {own_kick_off ? -0.45 : -s.circle_radius_m - 0.45, 0, 0};
    case 3:
      return {-0.25 * s.length_m, 0.2 * s.width_m, 0};
    default:
      return {-0.25 * s.length_m, -0.2 * s.width_m, 0};
  }
}

FieldAt goalie_place(const FieldPoint& ball, const Field& field) {
  const FieldSize& s = field.size();
  const FieldPoint goal{-0.5 * s.length_m, 0}, to = ball - goal;
  const double way = bearing_rad(to), out_m = std::min(0.45, 0.6 * length_m(to));
  const math::SinCos t = math::sincos(way);
  return {goal.x_m + std::max(0.2, out_m * t.cos),
          std::clamp(out_m * t.sin, -0.5 * s.goal_width_m + 0.3, 0.5 * s.goal_width_m - 0.3),
          std::clamp(way, -0.8, 0.8)};
}

FieldAt supporter_place(const FieldPoint& ball, const Field& field, double behind_m) {
  const FieldSize& s = field.size();
  // Towards the own goal, and aside to where the field is wider.
  const double side = ball.y_m > 0 ? -1 : 1;
  const FieldPoint at{std::clamp(ball.x_m - behind_m, -0.5 * s.length_m + 0.8, 0.5 * s.length_m - 1.5),
                      std::clamp(ball.y_m + 0.6 * side * behind_m, -0.5 * s.width_m + 0.4, 0.5 * s.width_m - 0.4)};
  return {at.x_m, at.y_m, bearing_rad(ball - at)};
}

void add_player(behaviour::Tree<PlayBoard>& tree) {
  add_game(tree);
  add_play(tree);
  add_striker(tree);
  add_others(tree);
}

}  // namespace sinew::soccer
