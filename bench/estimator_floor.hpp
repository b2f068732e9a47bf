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
/// Dense products, as in a straightforward program. Null where Eigen is missing.
EstimatorFloor* dense_eigen();

}  // namespace sinew::bench
