#pragma once
// The bare matrix products of a network: nothing but weights read and multiplied, with every instruction of an AVX2 and
// FMA machine; no bias, no activation, no state. policy_bench compares with it.
#include <cstddef>
#include <vector>

namespace sinew::bench::floor {

class Matrix {
 public:
  Matrix(std::size_t inputs, std::size_t outputs);
  /// y has room for a multiple of 16.
  void multiply(const float* x, float* y) const;
  float& at(std::size_t input, std::size_t output);
  std::size_t outputs() const { return outputs_; }

 private:
  std::size_t inputs_, outputs_, shift_ = 0;
  std::vector<float> memory_;
};

}  // namespace sinew::bench::floor
