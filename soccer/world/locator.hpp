#pragma once
// Where a robot is on the field: a bank of filters, one for each place that it may be at.
// A filter's covariance follows what it sees to centimetres with one pose, where particles need hundreds around each
// place for that, and it has the camera's tilt in its state, which moves all that is far away; where the robot may be
// otherwise is few places, since the field is made of right angles. Which ones is searched with hundreds of poses
// (PoseSearch), all the time.
// The field looks the same after half a turn: each filter stands for both poses, and has a probability that the other
// one is true. What is seen never changes it; rules, the way since the last place, and mates do.
// Frames:  "field" and "robot" of msg/soccer.hpp; odometry: GaitState.
// Thread:  owner.   RT: yes, after the constructor.
#include "math/matrix.hpp"
#include "soccer/world/pose_search.hpp"

namespace sinew::soccer {

struct LocatorOptions {
  // Of the odometry: standard deviations that grow with the root of the way.
  double way_sigma = 0.1;                // m after 1 m
  double turn_sigma = 0.06;              // rad after 1 rad
  double sway_mps = 0.02;                // m after 1 s, also of a robot that stands
  double drift_radps = 0.01;             // rad after 1 s
  double fall_m = 0.15, fall_rad = 0.3;  // after 1 s that it is not on its feet
  // Of what is seen.
  double sight_scale = 0.5;   // of the standard deviations in SoccerSight: the lasting part of the tilt is estimated
  double tilt_rad = 0.02;     // of that lasting part, about both axes
  double tilt_s = 10;         // time in which it is forgotten
  double camera_m = 0.45;     // of the cameras over the ground
  double gate = 16;           // squared error by covariance beyond which a sighting is taken for another thing
  double temper = 0.25;       // share of a picture's evidence that is new: errors last over several pictures
  double forget_s = 6;        // evidence fades
  double memory_s = 4;        // sightings that the search uses
  double search_penalty = 4;  // logarithm: how improbable it is that a new place is right, before it is tried
  double lead = 1;            // logarithm: a place takes over from the last one when it is better by this
};

class Locator {
 public:
  static constexpr std::size_t kMost = 8;

  struct Hypothesis {
    FieldAt at;
    double tilt_x_rad = 0, tilt_y_rad = 0;  // the cameras look as if the robot were turned by these; robot's axes
    math::Mat<5, 5> covariance;             // x, y, heading, tilts
    double log_weight = 0;                  // the best has 0
    double fit = 0.5;                       // share of its sightings that agreed, lately
    double mirrored = 0.5;                  // probability that the truth is turned by half a turn
    double used = 0;                        // sightings
  };
  /// Plain, for rt's saved state.
  struct State {
    std::array<Hypothesis, kMost> hypothesis;
    SightMemory memory;
    FieldAt odometry;           // that the hypotheses are at
    std::int64_t stamp_ns = 0;  // 0: nothing came yet
    std::uint32_t count = 0;    // hypotheses, the leading one first
    std::uint32_t pictures = 0;
    std::uint32_t relocations = 0;
    std::uint32_t own_half = 0;  // 1: the first place that it finds is in the own half
    FieldAt begin;               // of the odometry, when it was told that it is in its own half
    // Where it believed to be when it last was sure, moved on by the odometry.
    FieldAt anchor;
    double anchor_mirrored = 0.5, anchor_m2 = 0, anchor_rad2 = 0;  // and how far that may be off; 0: it never was sure
  };

  explicit Locator(const Field& field, const LocatorOptions& options = {})
      : field_(field), search_(field), options_(options) {}

  LocatorOptions& options() { return options_; }
  State& state() { return s_; }
  const State& state() const { return s_; }

  /// It knows nothing. `own_half`: but that it is in its own half, as before the kick-off.
  void forget(bool own_half);
  /// It is put down at the touch line of its own half and looks into the field, as after a penalty.
  void reenter();
  /// The teams have changed ends: it stays where it is, and the frame "field" turns by half a turn.
  void change_ends();
  /// Walks on by the odometry to this picture, and takes what it shows. Pictures of several cameras may come a little
  /// out of order.
  void see(const msg::SoccerSight& sight, bool on_its_feet);
  /// Bayes factor, as a logarithm, for the places as they are against all turned by half a turn: a mate's ball, say.
  void weigh_halves(double log_factor);

  /// What it believes, at the last picture's time; all but the stamp. The pose is of the more probable half.
  void fill(msg::FieldPose& out) const;
  std::span<const Hypothesis> hypotheses() const { return {s_.hypothesis.data(), s_.count}; }

 private:
  struct Step;  // one scalar measurement
  void move_to(const FieldAt& odometry, double dt_s, bool on_its_feet);
  double use(Hypothesis& h, const msg::SoccerSight& sight);
  bool use_line(Hypothesis& h, const msg::SeenLine& line, double& log_likelihood);
  bool use_place(Hypothesis& h, const msg::GroundPoint& at, std::span<const FieldCorner> places, double heading_rad,
                 double heading_sigma_rad, double alike_rad, double floor_m, double wrong, double& log_likelihood);
  void look_elsewhere();
  void insert(const FieldAt& at, double log_weight);
  void tidy();
  double mirrored_of(const FieldAt& at) const;
  double mirrored_by_rule(const FieldAt& at) const;
  bool is_sure() const;

  const Field& field_;
  PoseSearch search_;
  LocatorOptions options_;
  State s_;
};

}  // namespace sinew::soccer
