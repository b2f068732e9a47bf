#pragma once
// What soccer/sight sees against what is there.
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
  std::uint64_t balls = 0;             // that must be found
  std::uint64_t balls_candidates = 0;  // and were among the candidates
  std::uint64_t pictures = 0, without_ball = 0;
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

}  // namespace sinew::sight
