#include "policy_floor.hpp"

#include <cstdint>

#ifdef __x86_64__
#include <immintrin.h>
#endif

namespace sinew::bench::floor {
namespace {

constexpr std::size_t kPanel = 16, kLine = 16;

}  // namespace

Matrix::Matrix(std::size_t inputs, std::size_t outputs)
    : inputs_(inputs), outputs_((outputs + kPanel - 1) / kPanel * kPanel), memory_(inputs * outputs_ + kLine) {
  shift_ = (kLine - reinterpret_cast<std::uintptr_t>(memory_.data()) / sizeof(float) % kLine) % kLine;
}

float& Matrix::at(std::size_t input, std::size_t output) {
  return memory_[shift_ + output / kPanel * inputs_ * kPanel + input * kPanel + output % kPanel];
}

void Matrix::multiply(const float* x, float* y) const {
  const float* w = memory_.data() + shift_;
#ifdef __x86_64__
  for (std::size_t n = 0; n < outputs_; n += kPanel) {
    __m256 a[8] = {};
    std::size_t i = 0;
    for (; i + 4 <= inputs_; i += 4, w += 4 * kPanel) {
#pragma GCC unroll 4
      for (std::size_t j = 0; j < 4; ++j) {
        const __m256 v = _mm256_broadcast_ss(x + i + j);
        a[2 * j] = _mm256_fmadd_ps(v, _mm256_load_ps(w + j * kPanel), a[2 * j]);
        a[2 * j + 1] = _mm256_fmadd_ps(v, _mm256_load_ps(w + j * kPanel + 8), a[2 * j + 1]);
      }
    }
    for (; i < inputs_; ++i, w += kPanel) {
      const __m256 v = _mm256_broadcast_ss(x + i);
      a[0] = _mm256_fmadd_ps(v, _mm256_load_ps(w), a[0]);
      a[1] = _mm256_fmadd_ps(v, _mm256_load_ps(w + 8), a[1]);
    }
    for (std::size_t half = 0; half < 2; ++half)
      _mm256_storeu_ps(y + n + 8 * half,
                       _mm256_add_ps(_mm256_add_ps(a[half], a[half + 2]), _mm256_add_ps(a[half + 4], a[half + 6])));
  }
#else
  for (std::size_t n = 0; n < outputs_; n += kPanel) {
    float a[kPanel] = {};
    for (std::size_t i = 0; i < inputs_; ++i, w += kPanel)
      for (std::size_t j = 0; j < kPanel; ++j) a[j] += x[i] * w[j];
    for (std::size_t j = 0; j < kPanel; ++j) y[n + j] = a[j];
  }
#endif
}

}  // namespace sinew::bench::floor
