// One step of the 15-state filter (one inertial sample and a measured position) beside its floor and beside dense
// Eigen.
// usage: estimator_bench [PAIRS]
#include <cstdlib>

#include "control/inertial_filter.hpp"
#include "estimator_floor.hpp"
#include "pairs.hpp"

namespace {

using namespace sinew;

constexpr double kPosition[3] = {0.1, 0.2, 0.3};
constexpr int kStepsPerCall = 20;

class Ours {
 public:
  Ours() { filter_.start({}, {}); }
  void step() {
    filter_.predict({0.01, 0.02, 0.03}, {0.1, 0.2, 9.8}, 0.005, noise_);
    std::array<control::Measurement, 3> rows;
    for (int i = 0; i < 3; ++i) {
      control::Measurement& m = rows[std::size_t(i)];
      m.add(control::kErrP + i, 1);
      m.residual = kPosition[i] - filter_.state().p_world_m[i];
      m.variance = 0.01;
    }
    filter_.update(rows, 1e18);
    bench::keep(filter_);
  }

 private:
  control::InertialFilter filter_;
  control::InertialNoise noise_;
};

/// 50 inertial samples outdoors, as outdoor_floor() has them.
class Outdoors {
 public:
  Outdoors() {
    filter_.start({}, {});
    filter_.open_surroundings({}, 1, 1, 3);
  }
  void step() {
    for (int i = 0; i < 50; ++i) {
      filter_.predict({0.01, 0.02, 0.03}, {0.1, 0.2, 9.8}, 0.004, noise_);
      if (i % 5 == 0) {
        std::array<control::Measurement, 3> rows;
        for (int axis = 0; axis < 3; ++axis) {
          control::Measurement& m = rows[std::size_t(axis)];
          for (int k = 0; k < 3; ++k) m.add(control::kErrTheta + k, 0.2 - 0.1 * k);
          for (int k = 0; k < 3; ++k) m.add(control::kErrEarthField + k, 0.5 + 0.1 * k);
          m.add(control::kErrBodyField + axis, 1);
          m.residual = kPosition[axis];
          m.variance = 0.01;
        }
        filter_.update(rows, 1e18);
      }
      if (i == 0) {
        std::array<control::Measurement, 6> rows;
        for (int axis = 0; axis < 6; ++axis) {
          control::Measurement& m = rows[std::size_t(axis)];
          m.add(control::kErrP + axis, 1);
          m.add(control::kErrTheta, 0.3);
          m.add(control::kErrTheta + 1, -0.2);
          m.add(control::kErrAccelBias + axis % 3, 0.1);
          m.residual = kPosition[axis % 3];
          m.variance = 0.01;
        }
        filter_.update(rows, 1e18);
      }
    }
    bench::keep(filter_);
  }

 private:
  control::InertialFilter filter_;
  control::InertialNoise noise_;
};

}  // namespace

int main(int argc, char** argv) {
  const int pairs = argc > 1 ? std::atoi(argv[1]) : 31;
  Ours ours;
  const auto run_ours = [&] {
    for (int i = 0; i < kStepsPerCall; ++i) ours.step();
  };
  const auto run = [](bench::EstimatorFloor& other) {
    for (int i = 0; i < kStepsPerCall; ++i) other.step(kPosition);
  };
  bool good = bench::report("filter step x 20 / block structure",
                            bench::alternate(pairs, 400, run_ours, [&] { run(*bench::block_floor()); }), 1.15);
  Outdoors outdoors;
  // Beyond its goal so far, so it is said and does not count: docs/estimator.md.
  bench::report("outdoors, 50 samples / block structure",
                bench::alternate(
                    pairs, 100, [&] { outdoors.step(); }, [&] { bench::outdoor_floor()->step(kPosition); }),
                1.15);
  if (bench::EstimatorFloor* dense = bench::dense_eigen()) {
    good &= bench::report("filter step x 20 / dense Eigen",
                          bench::alternate(pairs, 400, run_ours, [&] { run(*dense); }), 0.40);
  } else {
    std::printf("filter step / dense Eigen: skipped, Eigen is missing (Debian: libeigen3-dev)\n");
  }
  return good ? 0 : 1;
}
