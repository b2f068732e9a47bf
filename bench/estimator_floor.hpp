#pragma once
// One filter step of 15 states, predict and a measured 3-vector, written for speed and with a simpler model than a
// flying one: the floor (block structure) and the peer (dense Eigen).

namespace sinew::bench {

struct EstimatorFloor {
  virtual ~EstimatorFloor() = default;
  virtual void step(const double (&z)[3]) = 0;
};
/// Row and column additions for the products with F, three scalar corrections; no attitude arithmetic.
EstimatorFloor* block_floor();
/// The same with 23 states (fields of earth and body, wind) and what a flight outdoors brings in 50 inertial samples:
/// 10 times three rows of a magnetometer (7 errors each), once six rows of a fix (4 errors each). step() is all of it.
EstimatorFloor* outdoor_floor();
/// Dense products, as in a straightforward program. Null where Eigen is missing.
EstimatorFloor* dense_eigen();

}  // namespace sinew::bench
