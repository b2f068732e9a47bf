#pragma once
// Where on the field a robot may be that has seen these lines and marks: found without knowing anything before.
#include <span>

#include "math/random.hpp"
#include "soccer/world/field_at.hpp"
#include "soccer/world/pose_score.hpp"
#include "soccer/world/sight_memory.hpp"

namespace sinew::soccer {

/// Poses out of pairs of a sighting and a thing of the field, of two lines that cross, and of a mark and a line; all
/// scored by the same ten sightings; the best scattered and scored again. The field is the same after half a turn: of
/// two poses that look the same one is made. Thread:  owner.   RT: yes, after the constructor.
class PoseSearch {
 public:
  static constexpr std::size_t kMostSights = 10, kMostFound = 6;
  explicit PoseSearch(const Field& field) : field_(field), score_(field) {}

  struct Found {
    FieldAt at;
    double cost = 0;  // as PoseScore, of all sightings together
  };
  /// Chooses the sightings that count: marks that were seen twice, and long lines. False: too few to tell anything.
  bool choose(std::span<const RememberedSight> seen, const FieldAt& odometry);
  /// After choose(): what these poses cost.
  void cost_of(std::span<const FieldAt> poses, std::span<double> costs);
  /// After choose(): the best, unlike each other, by rising cost; valid until the next call.
  std::span<const Found> search(math::Random& random);
  std::size_t sights() const { return sights_; }

 private:
  void add_candidates();
  bool add(double x_m, double y_m, double heading_rad);
  std::size_t best(std::span<Found> out) const;

  const Field& field_;
  PoseScore score_;
  ScoredPoses poses_;
  std::array<double, ScoredPoses::kMost> heading_{};
  std::array<ScoredSight, kMostSights> sight_{};
  std::array<double, kMostSights> sight_heading_{};  // of marks; NaN: none
  std::size_t sights_ = 0;
  std::array<Found, kMostFound> found_{};
};

}  // namespace sinew::soccer
