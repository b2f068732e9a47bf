#pragma once
// All that a picture shows of a game: carpet, border, lines, marks, posts, robots, balls.
#include "soccer/field.hpp"
#include "soccer/sight/ball_net.hpp"
#include "soccer/sight/line_finder.hpp"
#include "soccer/sight/mark_finder.hpp"
#include "soccer/sight/uprights.hpp"

namespace sinew::soccer {

struct SightOptions {
  double ball_radius_m = 0.07;
  double ball_farthest_m = 7;
  double ball_confidence = 0.5;  // less sure ones are not reported
  double circle_radius_m = FieldSize{}.circle_radius_m;
  ViewErrors errors{};
  std::uint32_t most_width = 640, most_height = 480;
};

/// From one picture to the next only the carpet's look is kept.
/// Thread:  owner; all but the constructor is RT: yes.
class FieldSight {
 public:
  explicit FieldSight(const SightOptions& options = {});

  SightOptions& options() { return o_; }  // sizes of pictures: read by the constructor only
  /// Fills all of `out` but stamp, odometry and camera. False: a picture of another format or too large, a camera that
  /// is not upright or without a place over the ground; `out` then has nothing in it.
  bool look(const vision::ImageView& image, const GroundView& view, msg::SoccerSight& out);

  const CarpetLook& carpet() const { return carpet_; }
  void set_carpet(const CarpetLook& look) { carpet_ = look; }
  void set_net(const BallNet& net) { net_ = net; }

  // Of the last picture, for those who draw, train and test.
  const Picture& picture() const { return picture_; }
  const FieldBorder& border() const { return border_; }
  const LinePoints& line_points() const { return line_points_; }
  const LineFinder& lines() const { return lines_; }
  const BallCandidates& candidates() const { return candidates_; }
  const Uprights& uprights() const { return uprights_; }

 private:
  void put_balls(const GroundView& view, msg::SoccerSight& out);
  void put_things(const GroundView& view, msg::SoccerSight& out) const;
  void put_lines(const GroundView& view, msg::SoccerSight& out) const;

  SightOptions o_;
  BallNet net_;
  CarpetLook carpet_;
  FieldColours colours_;
  CarpetMeter meter_;
  Picture picture_;
  FieldBorder border_;
  LinePoints line_points_;
  LineFinder lines_;
  MarkFinder marks_;
  Uprights uprights_;
  BallCandidates candidates_;
};

}  // namespace sinew::soccer
