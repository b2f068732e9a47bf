#include "robots/kid/world/walk_score.hpp"

#include <algorithm>
#include <cstdio>

#include "sim_hil/worlds/json_object.hpp"

namespace sinew::plant {
namespace {

constexpr double kSampleS = 0.5;  // the sway of a step does not count as a way
constexpr double kLeastWay_m = 0.5, kLeastTurn_rad = 1;
constexpr double kGently_radps = 2;   // a body that topples turns at 5 and more when it is half down
constexpr double kUpright_rad = 0.5;  // it has risen when it is tilted less and nothing but its soles is down

}  // namespace

void WalkScore::look(const BodyTruth& truth, bool driven, double now_s) {
  begun_ = begun_ || driven;
  const bool up = truth.tilt_rad < kUpright_rad && !truth.body_down;
  if (!down_ && truth.fallen && begun_) {
    if (math::norm(truth.gyro_radps) < kGently_radps) {
      ++got_down_;
    } else {
      if (falls_ == 0) first_fall_s_ = now_s;
      ++falls_;
    }
    down_ = true;
    fell_s_ = now_s;
  } else if (down_ && up) {
    ++rises_;
    down_ = false;
    longest_down_s_ = std::max(longest_down_s_, now_s - fell_s_);
  }
  if (now_s - mark_s_ < kSampleS && mark_s_ >= 0) return;
  const math::Vec3 ahead = truth.torso.q.rotate({1, 0, 0});
  const double heading = math::atan2(ahead.y, ahead.x);
  if (mark_s_ >= 0 && begun_ && !down_) {
    const math::Vec3 way = truth.torso.p_m - mark_m_;
    const double way_m = math::hypot(way.x, way.y);
    walked_m_ += way_m;
    fastest_mps_ = std::max(fastest_mps_, way_m / (now_s - mark_s_));
    double turn = heading - mark_heading_rad_;
    if (turn > math::kPi) turn -= 2 * math::kPi;
    if (turn < -math::kPi) turn += 2 * math::kPi;
    turned_rad_ += math::fabs(turn);
  }
  mark_m_ = truth.torso.p_m;
  mark_heading_rad_ = heading;
  mark_s_ = now_s;
}

bool WalkScore::walked() const { return walked_m_ >= kLeastWay_m || turned_rad_ >= kLeastTurn_rad; }

std::string WalkScore::words(const BodyTruth& now, bool touched_ball) const {
  if (!begun_) return "its servos never had a command";
  const bool up = now.tilt_rad < kUpright_rad && !now.body_down;
  if (falls_ > 0 && !up) return "fell";
  if (falls_ > 0) return "fell and rose again";
  if (!up) return got_down_ > 0 ? "got down gently" : "is not on its feet";
  if (walked()) return "walked and is on its feet";
  return touched_ball ? "touched the ball and is on its feet" : "is on its feet, and walked nowhere";
}

Verdict WalkScore::verdict(const BodyTruth& now, bool touched_ball) const {
  Verdict v;
  v.outcome = words(now, touched_ball);
  v.begun = begun_;
  v.good = begun_ && (walked() || touched_ball) && falls_ == 0 && now.tilt_rad < kUpright_rad && !now.body_down;
  v.measures = {{"falls", "falls", "", static_cast<double>(falls_), 0.0},
                {"walked_m", "walked", "m", walked_m_},
                {"turned_deg", "turned", "deg", turned_rad_ * 180 / math::kPi},
                {"fastest_mps", "fastest half second", "m/s", fastest_mps_}};
  if (rises_ > 0) v.measures.push_back({"longest_down_s", "longest time on the ground", "s", longest_down_s_});
  return v;
}

std::string WalkScore::text(const BodyTruth& now, bool touched_ball) const {
  char figures[96];
  std::snprintf(figures, sizeof figures, ": %.2f m, %.0f degrees turned, %u falls", walked_m_,
                turned_rad_ * 180 / math::kPi, falls_);
  return words(now, touched_ball) + figures;
}

void WalkScore::add_to(JsonObject& j) const {
  j.integer("falls", falls_);
  j.integer("got_down", got_down_);
  j.integer("rises", rises_);
  if (falls_ > 0) j.number("first_fall_s", first_fall_s_);
  j.number("walked_m", walked_m_);
  j.number("turned_deg", turned_rad_ * 180 / math::kPi);
  j.number("fastest_mps", fastest_mps_);
  if (rises_ > 0) j.number("longest_down_s", longest_down_s_);
}

}  // namespace sinew::plant
