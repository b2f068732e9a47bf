#pragma once
// The arithmetic of networks. Each kernel has one order of additions, however many numbers a processor takes at once,
// and rounds after each operation: all variants give the same bits.
#include <cstddef>
#include <cstdint>

namespace sinew::onnx {

enum class Unary : std::uint8_t { relu, leaky_relu, elu, tanh, sigmoid, exp, clip, sqrt, neg, abs, square, canonical };
enum class Binary : std::uint8_t { add, sub, mul, div, min, max };

/// Outputs of a layer are padded to whole panels. Weights of `dense` stand in blocks of two panels, one row of kBlock
/// weights for each input: first the rows of inputs 0 1 4 5 8 9 ..., then those of 2 3 6 7 10 11 ... The last block has
/// one panel where their number is odd.
inline constexpr std::size_t kPanel = 16, kBlock = 2 * kPanel;

/// How many inputs each of the four sums of an output has.
struct SumLengths {
  std::size_t of[4];
  explicit SumLengths(std::size_t inputs) : of{(inputs + 3) / 4, (inputs + 2) / 4, (inputs + 1) / 4, inputs / 4} {}
};
/// Where a weight stands. `padded`: outputs of the layer, a multiple of kPanel.
inline std::size_t place_of_weight(std::size_t input, std::size_t output, std::size_t inputs, std::size_t padded) {
  const SumLengths n(inputs);
  const std::size_t block = output / kBlock * kBlock, width = padded - block < kBlock ? kPanel : kBlock;
  const std::size_t row = (input % 4 < 2 ? 0 : n.of[0] + n.of[1]) + input / 4 * 2 + input % 2;
  return block * inputs + row * width + (output - block);
}

/// Numbers that a kernel may touch behind the end of what it reads and writes: it takes kPanel at a time.
inline constexpr std::size_t kBehind = kPanel;

struct GruGates {
  const float *x, *h;  // both have z, r and n, `stride` apart: from the input, and from the state
  std::size_t stride, size;
  const float* state;
  float* next;
};
struct LstmGates {
  const float *x, *h;  // i, o, f, c
  std::size_t stride, size;
  const float* cell;
  float *next_cell, *next;
};

/// One variant of all kernels.
/// Thread:  any.   RT: yes.
struct Kernels {
  const char* name;
  /// y[n] = bias + sum of x[i] * weight[i][n]. Each sum is four sums, of i = 0 4 8 ..., 1 5 9 ..., 2 6 10 ... and
  /// 3 7 11 ..., added as (0 + 1) + (2 + 3); the bias comes last.
  void (*dense)(const float* weights, const float* bias, const float* x, std::size_t inputs, float* y,
                std::size_t outputs);
  void (*unary)(Unary op, const float* x, float* y, std::size_t n, float a, float b);
  void (*binary)(Binary op, const float* a, const float* b, float* y, std::size_t n);
  /// linear_before_reset = 1: next = (1 - z) * tanh(x.n + r * h.n) + z * state.
  void (*gru_linear)(const GruGates& g);
  /// linear_before_reset = 0, in two steps: `next` becomes r * state and x.z becomes z; then, with h.n made of that:
  void (*gru_reset)(const GruGates& g, float* z);
  void (*gru_finish)(const GruGates& g, const float* z);
  void (*lstm)(const LstmGates& g);
};

/// In portable code: four at a time where every processor of the target can do that, else one by one.
const Kernels& portable_kernels();
/// The fastest variant on this processor.
const Kernels& best_kernels();
/// Null: not in this build, or not on this processor.
const Kernels* avx2_kernels();

}  // namespace sinew::onnx
