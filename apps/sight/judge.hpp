#pragma once
// What soccer/sight sees against what is there.
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "apps/sight/scenes.hpp"

namespace sinew::sight {

/// So many of so many, with the 95 % interval of the share.
/// Source:  E. Wilson, Probable inference, the law of succession, and statistical inference, JASA 22 (1927).
struct Share {
  std::uint64_t of = 0, all = 0;
  void add(bool yes) { of += yes, ++all; }
  double value() const { return all > 0 ? static_cast<double>(of) / static_cast<double>(all) : 0; }
  double low() const { return bound(-1); }
  double high() const { return bound(1); }

 private:
  double bound(double sign) const;
};
std::string text(const Share& s);

struct JudgeOptions {
  double least_visible = 0.6;  // of a ball that must be found
  double least_diameter_px = 8;
};

struct Judgement {
  struct Sighting {
    double confidence;
    bool is_ball;          // of a ball that must be found
    bool is_wrong;         // of no ball, or a second one of the same
    double off_m, true_m;  // of its place on the ground; its true distance
    double chi2;           // of this error by the covariance that was given
  };
  std::vector<Sighting> sightings;

  /// What became of a ball that must be found, in the order of the stages.
  enum class Fate : std::uint8_t { no_carpet, no_candidate, poor_candidate, physics, doubted, seen };
  struct Ball {
    Fate fate = Fate::no_carpet;
    double confidence = 0;  // if seen
    double distance_m = 0, diameter_px = 0, visible = 0, blur_px = 0;
    bool spotted = false, at_line = false, at_robot = false;
  };
  std::vector<Ball> asked;
  /// What a wrong sighting lies on.
  enum class Lure : std::uint8_t { ball, carpet, line, goal, upright, lying, own_body, beyond };
  struct Mistake {
    Lure lure = Lure::beyond;
    double confidence = 0;
  };
  std::vector<Mistake> mistakes;
  /// Wrong sightings of robots and posts, by what most of their box shows; and what became of robots and posts that
  /// must be found: nothing over their columns, something elsewhere on the ground, something of another kind, found.
  std::array<std::uint64_t, 8> robot_lures{}, post_lures{};
  enum class Upright : std::uint8_t { nothing, elsewhere, other_kind, found };
  std::array<std::uint64_t, 4> robot_fates{}, post_fates{};
  std::uint64_t balls = 0;             // that must be found
  std::uint64_t balls_candidates = 0;  // and were among the candidates
  std::uint64_t pictures = 0, without_ball = 0, candidates = 0;
  Share lines_right, line_length, marks_right, marks_found, posts_right, posts_found, robots_right, robots_found,
      jerseys_right, borders_right;
  Share mark_kind_right[5];

  /// The recall at the least confidence at which this share of sightings is right.
  struct AtPrecision {
    Share recall, precision;
    double confidence = 1;
  };
  AtPrecision at_precision(double precision) const;
  AtPrecision at_confidence(double confidence) const;
};

void judge(SceneMaker& maker, std::uint64_t first, std::uint64_t count, const JudgeOptions& options, Judgement& out);
std::string report(const Judgement& j);
/// Where the balls that must be found are lost, and what is taken for balls, at the least confidence for 99 %
/// precision.
std::string losses(const Judgement& j);

}  // namespace sinew::sight
