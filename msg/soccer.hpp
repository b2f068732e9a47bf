#pragma once
// What a robot sees of a game of soccer, what it believes of it, and what it tells its mates.
// Frames:  "robot": on the ground below the torso at the message's stamp; x to where the torso is turned, y to its
// left.
//          "field": the middle of the field is 0; x towards the other team's goal, y to its left. It turns by half a
//          turn when the teams change ends, so the own goal is always at negative x.
#include "msg/geometry.hpp"

namespace sinew::msg {

/// A point on the ground, and how sure it is.
struct GroundPoint {
  float x_m = 0, y_m = 0;
  float xx_m2 = 0, xy_m2 = 0, yy_m2 = 0;  // covariance
};

enum class FieldMark : std::uint32_t {
  corner_l = 0,      // two lines end at each other
  corner_t = 1,      // a line ends at another one
  corner_x = 2,      // two lines cross
  penalty_mark = 3,  // the spot before a goal
  circle = 4         // the centre circle; the point is its centre
};

inline constexpr ValueName kFieldMarkNames[] = {{"corner_l", FieldMark::corner_l},
                                                {"corner_t", FieldMark::corner_t},
                                                {"corner_x", FieldMark::corner_x},
                                                {"penalty_mark", FieldMark::penalty_mark},
                                                {"circle", FieldMark::circle}};

struct SeenMark {
  GroundPoint at;
  /// corner_l: to the middle between its two lines. corner_t: along the line that ends, away from the corner. corner_x:
  /// along one of its lines, known up to quarter turns. circle: along the halfway line, known up to half a turn.
  /// NaN: not seen, and for a penalty mark.
  float heading_rad = 0;
  float heading_sigma_rad = 0;
  FieldMark kind = FieldMark::corner_l;
};

/// A piece of the middle of a straight line. Its ends are where it leaves the picture or stops being seen; only across
/// the line are they measurements of the field.
struct SeenLine {
  GroundPoint from, to;
};

struct SeenBall {
  GroundPoint at;  // where it touches the ground
  float u_px = 0, v_px = 0, radius_px = 0;
  float confidence = 0;  // 0..1: the share of such sightings that are balls
};

enum class JerseyColour : std::uint32_t { unknown = 0, blue = 1, red = 2 };

inline constexpr ValueName kJerseyColourNames[] = {
    {"unknown", JerseyColour::unknown}, {"blue", JerseyColour::blue}, {"red", JerseyColour::red}};

struct SeenRobot {
  GroundPoint at;        // middle of its feet
  float confidence = 0;  // 0..1
  JerseyColour colour = JerseyColour::unknown;
};

/// All that one picture shows of the game. A message comes for every picture whose camera's pose is known.
/// Points are in the frame "robot"; the odometry's numbers say where that frame was, so that sightings of two instants
/// can be put together.
struct SoccerSight {
  Time stamp;                                        // middle of the exposure
  double x_m = 0, y_m = 0, heading_rad = 0;          // the frame "robot" in the odometry's (GaitState), at `stamp`
  std::uint32_t camera = 0;                          // 0, 1: in the order of the body's file
  std::uint32_t lines = 0, marks = 0, posts = 0;     // places in use
  std::uint32_t balls = 0, robots = 0, borders = 0;  // balls: the surest first
  std::array<SeenLine, 10> line{};
  std::array<SeenMark, 8> mark{};
  std::array<GroundPoint, 4> post{};  // foot of a goal's post
  std::array<SeenBall, 4> ball{};
  std::array<SeenRobot, 7> robot{};
  std::array<GroundPoint, 8> border{};  // where the carpet ends, from left to right in the picture
};

/// Where a robot believes it is on the field.
struct FieldPose {
  Time stamp;
  double x_m = 0, y_m = 0, heading_rad = 0;  // frame "field"
  std::array<double, 9> covariance{};        // of these three, by rows
  double mirrored = 0.5;          // probability that the truth is this pose turned by half a turn about the middle
  std::uint32_t found = 0;        // 1: it knows where it is, up to that symmetry
  std::uint32_t relocations = 0;  // times that the pose jumped, since the start
};

/// Where the ball is, by the robot's own eyes. Stays when the ball is out of sight; the covariance grows.
struct BallModel {
  Time stamp;
  Time seen;                            // the last sighting used; 0: none yet
  double x_m = 0, y_m = 0;              // frame "robot"
  double vx_mps = 0, vy_mps = 0;        // over the ground, along the axes of "robot"
  std::array<double, 16> covariance{};  // of these four, by rows
  double field_x_m = 0, field_y_m = 0;  // frame "field", by FieldPose
  double confidence = 0;                // 0..1: it is there
  std::uint32_t gone = 0;               // 1: the robot looked where it should be, and it was not there
  std::uint32_t sightings = 0;          // used since the start
};

/// A robot or another thing in the way.
struct Obstacle {
  Time seen;
  double x_m = 0, y_m = 0, vx_mps = 0, vy_mps = 0;  // frame "robot"
  double sigma_m = 0, radius_m = 0;
  JerseyColour colour = JerseyColour::unknown;
  std::uint32_t sightings = 0;  // used
};

struct ObstacleModel {
  Time stamp;
  std::uint32_t obstacles = 0;  // places in use
  std::uint32_t dropped = 0;    // for lack of room, since the start
  std::array<Obstacle, 12> obstacle{};
};

enum class SoccerRole : std::uint32_t {
  none = 0,  // not in the game: penalised, lying, or before its start
  striker = 1,
  supporter = 2,
  goalie = 3
};

inline constexpr ValueName kSoccerRoleNames[] = {{"none", SoccerRole::none},
                                                 {"striker", SoccerRole::striker},
                                                 {"supporter", SoccerRole::supporter},
                                                 {"goalie", SoccerRole::goalie}};

/// What a robot tells its mates, about twice a second ("mates/..." as SoccerReportFromMate).
struct SoccerReport {
  Time stamp;
  Time ball_seen;                           // 0: never
  float x_m = 0, y_m = 0, heading_rad = 0;  // itself, frame "field"
  float xx_m2 = 0, xy_m2 = 0, yy_m2 = 0;    // covariance of x and y
  float heading_sigma_rad = 0;
  float mirrored = 0.5F;                   // as FieldPose
  GroundPoint ball;                        // frame "field"
  float ball_vx_mps = 0, ball_vy_mps = 0;  // frame "field"
  float ball_confidence = 0;
  float to_ball_s = 0;                 // time until it could kick; infinite: it cannot
  SoccerRole role = SoccerRole::none;  // that it plays now
  std::uint32_t plays = 0;             // 1: on its feet and not penalised
  std::uint32_t has_ball = 0;          // 1: the ball lies before its feet
};

/// What the team knows together, put together by each robot for itself.
struct TeamModel {
  Time stamp;
  Time ball_seen;                           // newest sighting of anybody that was used; 0: none
  double ball_x_m = 0, ball_y_m = 0;        // frame "field"
  double ball_vx_mps = 0, ball_vy_mps = 0;  // frame "field"
  std::array<double, 4> ball_covariance_m2{};
  double ball_confidence = 0;
  std::uint32_t mates = 0;             // that were heard lately and play
  std::uint32_t distrusted = 0;        // bit n: mate n in the order of the robot file contradicts the others
  std::uint32_t ball_from = 0;         // bit n: the sighting of mate n is part of the ball; bit 31: the own one
  SoccerRole role = SoccerRole::none;  // of this robot
  std::array<SoccerReport, 7> mate{};  // the newest of each, in the order of the robot file; stamp 0: none
};

template <>
struct Description<GroundPoint> {
  using M = GroundPoint;
  static constexpr std::string_view name = "GroundPoint", doc = "A point on the ground, and how sure it is.";
  static constexpr auto fields =
      describe(field<&M::x_m>("m"), field<&M::y_m>("m"), field<&M::xx_m2>("m^2", "covariance"), field<&M::xy_m2>("m^2"),
               field<&M::yy_m2>("m^2"));
};

template <>
struct Description<SeenMark> {
  using M = SeenMark;
  static constexpr std::string_view name = "SeenMark", doc = "A corner, mark or circle of the field.";
  static constexpr auto fields =
      describe(field<&M::at>(""), field<&M::heading_rad>("rad", "by kind, see msg/soccer.hpp; NaN: not seen"),
               field<&M::heading_sigma_rad>("rad"), enum_field<&M::kind>(kFieldMarkNames));
};

template <>
struct Description<SeenLine> {
  using M = SeenLine;
  static constexpr std::string_view name = "SeenLine", doc = "A piece of the middle of a straight line of the field.";
  static constexpr auto fields = describe(field<&M::from>(""), field<&M::to>(""));
};

template <>
struct Description<SeenBall> {
  using M = SeenBall;
  static constexpr std::string_view name = "SeenBall", doc = "A ball in one picture.";
  static constexpr auto fields =
      describe(field<&M::at>("", "where it touches the ground"), field<&M::u_px>("px"), field<&M::v_px>("px"),
               field<&M::radius_px>("px"), field<&M::confidence>("1", "share of such sightings that are balls"));
};

template <>
struct Description<SeenRobot> {
  using M = SeenRobot;
  static constexpr std::string_view name = "SeenRobot", doc = "A robot in one picture.";
  static constexpr auto fields = describe(field<&M::at>("", "middle of its feet"), field<&M::confidence>("1"),
                                          enum_field<&M::colour>(kJerseyColourNames));
};

template <>
struct Description<SoccerSight> {
  using M = SoccerSight;
  static constexpr std::string_view name = "SoccerSight",
                                    doc = "What one picture shows of a game; points in the robot's frame.";
  static constexpr auto fields = describe(
      field<&M::stamp>("ns", "middle of the exposure"), field<&M::x_m>("m", "the robot's frame in the odometry's"),
      field<&M::y_m>("m"), field<&M::heading_rad>("rad"), field<&M::camera>("1", "0, 1: order of the body's file"),
      field<&M::lines>("1", "places in use"), field<&M::marks>("1"), field<&M::posts>("1"), field<&M::balls>("1"),
      field<&M::robots>("1"), field<&M::borders>("1"), field<&M::line>(""), field<&M::mark>(""),
      field<&M::post>("", "foot of a goal's post"), field<&M::ball>("", "the surest first"), field<&M::robot>(""),
      field<&M::border>("", "where the carpet ends, from left to right in the picture"));
};

template <>
struct Description<FieldPose> {
  using M = FieldPose;
  static constexpr std::string_view name = "FieldPose", doc = "Where a robot believes it is on the field.";
  static constexpr auto fields = describe(
      field<&M::stamp>("ns"), field<&M::x_m>("m", "x towards the other team's goal, from the middle"),
      field<&M::y_m>("m"), field<&M::heading_rad>("rad"), field<&M::covariance>("", "3x3 by rows: m, m, rad"),
      field<&M::mirrored>("1", "probability that the truth is turned by half a turn about the middle"),
      field<&M::found>("1", "1: known up to that symmetry"), field<&M::relocations>("1", "jumps since the start"));
};

template <>
struct Description<BallModel> {
  using M = BallModel;
  static constexpr std::string_view name = "BallModel", doc = "Where the ball is, by the robot's own eyes.";
  static constexpr auto fields =
      describe(field<&M::stamp>("ns"), field<&M::seen>("ns", "the last sighting used; 0: none yet"),
               field<&M::x_m>("m", "robot's frame"), field<&M::y_m>("m"),
               field<&M::vx_mps>("m/s", "over the ground, robot's axes"), field<&M::vy_mps>("m/s"),
               field<&M::covariance>("", "4x4 by rows: m, m, m/s, m/s"), field<&M::field_x_m>("m", "field's frame"),
               field<&M::field_y_m>("m"), field<&M::confidence>("1", "that it is there"),
               field<&M::gone>("1", "1: looked for, and not there"), field<&M::sightings>("1", "used since the start"));
};

template <>
struct Description<Obstacle> {
  using M = Obstacle;
  static constexpr std::string_view name = "Obstacle", doc = "A robot or another thing in the way.";
  static constexpr auto fields =
      describe(field<&M::seen>("ns"), field<&M::x_m>("m", "robot's frame"), field<&M::y_m>("m"),
               field<&M::vx_mps>("m/s"), field<&M::vy_mps>("m/s"), field<&M::sigma_m>("m"), field<&M::radius_m>("m"),
               enum_field<&M::colour>(kJerseyColourNames), field<&M::sightings>("1", "used"));
};

template <>
struct Description<ObstacleModel> {
  using M = ObstacleModel;
  static constexpr std::string_view name = "ObstacleModel", doc = "What is in the robot's way.";
  static constexpr auto fields =
      describe(field<&M::stamp>("ns"), field<&M::obstacles>("1", "places in use"),
               field<&M::dropped>("1", "for lack of room, since the start"), field<&M::obstacle>(""));
};

template <>
struct Description<SoccerReport> {
  using M = SoccerReport;
  static constexpr std::string_view name = "SoccerReport", doc = "What a robot tells its mates of the game.";
  static constexpr auto fields = describe(
      field<&M::stamp>("ns"), field<&M::ball_seen>("ns", "0: never"), field<&M::x_m>("m", "itself, field's frame"),
      field<&M::y_m>("m"), field<&M::heading_rad>("rad"), field<&M::xx_m2>("m^2", "covariance of x and y"),
      field<&M::xy_m2>("m^2"), field<&M::yy_m2>("m^2"), field<&M::heading_sigma_rad>("rad"),
      field<&M::mirrored>("1", "as FieldPose"), field<&M::ball>("", "field's frame"),
      field<&M::ball_vx_mps>("m/s", "field's frame"), field<&M::ball_vy_mps>("m/s"), field<&M::ball_confidence>("1"),
      field<&M::to_ball_s>("s", "until it could kick; infinite: it cannot"),
      enum_field<&M::role>(kSoccerRoleNames, "that it plays now"),
      field<&M::plays>("1", "1: on its feet and not penalised"),
      field<&M::has_ball>("1", "1: the ball lies before its feet"));
};

template <>
struct Description<TeamModel> {
  using M = TeamModel;
  static constexpr std::string_view name = "TeamModel", doc = "What a team knows together of the game.";
  static constexpr auto fields =
      describe(field<&M::stamp>("ns"), field<&M::ball_seen>("ns", "newest sighting used; 0: none"),
               field<&M::ball_x_m>("m", "field's frame"), field<&M::ball_y_m>("m"), field<&M::ball_vx_mps>("m/s"),
               field<&M::ball_vy_mps>("m/s"), field<&M::ball_covariance_m2>("m^2", "2x2 by rows"),
               field<&M::ball_confidence>("1"), field<&M::mates>("1", "heard lately and playing"),
               field<&M::distrusted>("1", "bit n: mate n contradicts the others"),
               field<&M::ball_from>("1", "bit n: by the sighting of mate n; bit 31: by the own one"),
               enum_field<&M::role>(kSoccerRoleNames, "of this robot"),
               field<&M::mate>("", "newest report of each, in the order of the robot file; stamp 0: none"));
};

}  // namespace sinew::msg
