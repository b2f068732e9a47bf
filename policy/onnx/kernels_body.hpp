// The kernels of one variant; included once for each by the .cpp files, which define
//   SINEW_KERNEL_NAMESPACE   of the variant
//   SINEW_KERNEL_TARGET      attributes of its functions
//   SINEW_LANES              numbers in a vector: 1, 4 or 8
//   SINEW_MIN, SINEW_MAX     where the processor has them: a < b ? a : b, and a > b ? a : b
#include <cstring>

#include "math/elementary.hpp"
#include "policy/onnx/kernels.hpp"

#define SINEW_INLINE SINEW_KERNEL_TARGET __attribute__((always_inline)) inline

namespace sinew::onnx::SINEW_KERNEL_NAMESPACE {

#if SINEW_LANES == 1
using V = float;
using I = std::int32_t;
using VMemory = float;
#else
using V [[gnu::vector_size(SINEW_LANES * 4)]] = float;
using I [[gnu::vector_size(SINEW_LANES * 4)]] = std::int32_t;
using VMemory [[gnu::vector_size(SINEW_LANES * 4), gnu::aligned(4), gnu::may_alias]] = float;
#endif
inline constexpr std::size_t kLanes = SINEW_LANES;

SINEW_INLINE V load(const float* p) {
#if SINEW_LANES == 1
  return *p;
#else
  return static_cast<V>(*static_cast<const VMemory*>(static_cast<const void*>(p)));
#endif
}
SINEW_INLINE void store(float* p, V v) {
#if SINEW_LANES == 1
  *p = v;
#else
  *static_cast<VMemory*>(static_cast<void*>(p)) = v;
#endif
}
SINEW_INLINE V splat(float x) {
#if SINEW_LANES == 1
  return x;
#else
  return x - V{};  // x - 0 is x, also for -0
#endif
}
SINEW_INLINE I bits(V v) { return __builtin_bit_cast(I, v); }
SINEW_INLINE V number(I i) { return __builtin_bit_cast(V, i); }
/// All bits where a > b; none where either is NaN.
SINEW_INLINE I above(V a, V b) {
#if SINEW_LANES == 1
  return -static_cast<I>(a > b);
#else
  return a > b;
#endif
}
SINEW_INLINE V select(I mask, V a, V b) { return mask ? a : b; }
/// The first where neither is greater, so NaN in `a` stays.
SINEW_INLINE V smaller(V a, V b) {
#ifdef SINEW_MIN
  return SINEW_MIN(b, a);
#else
  return b < a ? b : a;
#endif
}
SINEW_INLINE V larger(V a, V b) {
#ifdef SINEW_MAX
  return SINEW_MAX(b, a);
#else
  return b > a ? b : a;
#endif
}
SINEW_INLINE V magnitude(V v) { return number(bits(v) & 0x7FFFFFFF); }

/// e^x for x in -87 to 88, and what stands there beyond. Within 2 ULP, also relative to small results.
/// Source:  the reduction and the polynomial of Cephes' expf (S. L. Moshier, netlib.org/cephes).
SINEW_INLINE V exponential(V x) {
  x = larger(smaller(x, splat(88.0f)), splat(-87.0f));
  const V magic = splat(12583039.0f);  // 1.5 * 2^23 + 127: what is added to it is rounded to an integer
  const V shifted = x * splat(1.44269504088896341f) + magic;
  const V n = shifted - magic;
  const V r = (x - n * splat(0.693359375f)) - n * splat(-2.12194440e-4f), r2 = r * r;
  // In pairs: the processor waits for five operations in a row in place of twelve.
  const V p54 = splat(1.3981999507e-3f) + r * splat(1.9875691500e-4f);
  const V p32 = splat(4.1665795894e-2f) + r * splat(8.3334519073e-3f);
  const V p10 = splat(5.0000001201e-1f) + r * splat(1.6666665459e-1f);
  const V y = (splat(1.0f) + r) + r2 * (p10 + r2 * (p32 + r2 * p54));
  return y * number(bits(shifted) << 23);  // 2^n: the low bits are n + 127, the others leave
}

// What activations need is right to some 1e-7 of 1, however small the result is: so one multiplication reduces x.

/// 2^x = whole * (1 + rest), for x in -126 to 126: `whole` is a power of two, `rest` is 2^f - 1 for |f| <= 0.5.
/// Source:  rest / f is the polynomial of degree 5 whose largest relative error is the least: 1.1e-8 (Remez exchange).
SINEW_INLINE void power_of_two(V x, V& whole, V& rest) {
  const V magic = splat(12583039.0f);  // 1.5 * 2^23 + 127: what is added to it is rounded to an integer
  const V shifted = x + magic, f = x - (shifted - magic), f2 = f * f;
  const V p54 = splat(1.33907354776e-3f) + f * splat(1.54035123676e-4f);
  const V p32 = splat(5.55035743364e-2f) + f * splat(9.61823749491e-3f);
  const V p10 = splat(6.93147187927e-1f) + f * splat(2.40226497950e-1f);
  rest = f * (p10 + f2 * (p32 + f2 * p54));
  whole = number(bits(shifted) << 23);  // the low bits are n + 127, the others leave
}
inline constexpr float kLog2E = 1.44269504088896341f;

/// e^x - 1 for x in -87 to 0, and what stands at -87 below; anything above.
SINEW_INLINE V exponential_less_1(V x) {
  V whole, rest;
  power_of_two(larger(x, splat(-87.0f)) * splat(kLog2E), whole, rest);
  return (whole - splat(1.0f)) + whole * rest;
}
/// e^-x, of x within 60: beyond it a sigmoid is 0 or 1 to 1e-26, and products of what gates have stay finite.
SINEW_INLINE V exponential_of_gate(V x) {
  V whole, rest;
  power_of_two(larger(smaller(x, splat(60.0f)), splat(-60.0f)) * splat(-kLog2E), whole, rest);
  return whole + whole * rest;
}
/// d = e^2x - 1, of which tanh is d / (d + 2); of x within 9.1, where it is 1.
SINEW_INLINE V exponential_of_tangent(V x) {
  V whole, rest;
  power_of_two(larger(smaller(x, splat(9.1f)), splat(-9.1f)) * splat(2 * kLog2E), whole, rest);
  return (whole - splat(1.0f)) + whole * rest;
}
SINEW_INLINE V hyperbolic_tangent(V x) {
  const V d = exponential_of_tangent(x);
  return d / (d + splat(2.0f));
}
SINEW_INLINE V sigmoid(V x) { return splat(1.0f) / (splat(1.0f) + exponential_of_gate(x)); }

/// Of four vectors of outputs the sums over inputs x[0], x[4], ... and x[1], x[5], ..., added: eight sums at a time, so
/// that none waits for the one before. Rows of `w` are kBlock apart.
SINEW_INLINE void two_sums(const float* w, const float* x, std::size_t first, std::size_t second, V (&sum)[4]) {
  V a0{}, a1{}, a2{}, a3{}, b0{}, b1{}, b2{}, b3{};
  for (std::size_t i = 0; i < second; ++i, x += 4, w += 2 * kBlock) {
    const V x0 = splat(x[0]), x1 = splat(x[1]);
    a0 = a0 + x0 * load(w);
    a1 = a1 + x0 * load(w + kLanes);
    a2 = a2 + x0 * load(w + 2 * kLanes);
    a3 = a3 + x0 * load(w + 3 * kLanes);
    b0 = b0 + x1 * load(w + kBlock);
    b1 = b1 + x1 * load(w + kBlock + kLanes);
    b2 = b2 + x1 * load(w + kBlock + 2 * kLanes);
    b3 = b3 + x1 * load(w + kBlock + 3 * kLanes);
  }
  if (first > second) {
    const V x0 = splat(x[0]);
    a0 = a0 + x0 * load(w);
    a1 = a1 + x0 * load(w + kLanes);
    a2 = a2 + x0 * load(w + 2 * kLanes);
    a3 = a3 + x0 * load(w + 3 * kLanes);
  }
  sum[0] = a0 + b0, sum[1] = a1 + b1, sum[2] = a2 + b2, sum[3] = a3 + b3;
}

/// A block of kBlock outputs.
SINEW_INLINE void dense_block(const float* w, const float* bias, const float* x, const SumLengths& n, float* y) {
  for (std::size_t part = 0; part < kBlock; part += 4 * kLanes) {
    V even[4], odd[4];
    two_sums(w + part, x, n.of[0], n.of[1], even);
    two_sums(w + (n.of[0] + n.of[1]) * kBlock + part, x + 2, n.of[2], n.of[3], odd);
    float* to = y + part;
    const float* from = bias + part;
    store(to, (even[0] + odd[0]) + load(from));
    store(to + kLanes, (even[1] + odd[1]) + load(from + kLanes));
    store(to + 2 * kLanes, (even[2] + odd[2]) + load(from + 2 * kLanes));
    store(to + 3 * kLanes, (even[3] + odd[3]) + load(from + 3 * kLanes));
  }
}

/// A last panel of kPanel outputs: all four sums of two vectors at a time.
SINEW_INLINE void dense_panel(const float* panel, const float* bias, const float* x, const SumLengths& n, float* y) {
  for (std::size_t part = 0; part < kPanel; part += 2 * kLanes) {
    const float *w = panel + part, *u = w + (n.of[0] + n.of[1]) * kPanel, *at = x;
    V a0{}, a1{}, a2{}, a3{}, b0{}, b1{}, b2{}, b3{};
    for (std::size_t i = 0; i < n.of[3]; ++i, at += 4, w += 2 * kPanel, u += 2 * kPanel) {
      const V x0 = splat(at[0]), x1 = splat(at[1]), x2 = splat(at[2]), x3 = splat(at[3]);
      a0 = a0 + x0 * load(w);
      b0 = b0 + x0 * load(w + kLanes);
      a1 = a1 + x1 * load(w + kPanel);
      b1 = b1 + x1 * load(w + kPanel + kLanes);
      a2 = a2 + x2 * load(u);
      b2 = b2 + x2 * load(u + kLanes);
      a3 = a3 + x3 * load(u + kPanel);
      b3 = b3 + x3 * load(u + kPanel + kLanes);
    }
    if (n.of[0] > n.of[3]) {
      a0 = a0 + splat(at[0]) * load(w);
      b0 = b0 + splat(at[0]) * load(w + kLanes);
    }
    if (n.of[1] > n.of[3]) {
      a1 = a1 + splat(at[1]) * load(w + kPanel);
      b1 = b1 + splat(at[1]) * load(w + kPanel + kLanes);
    }
    if (n.of[2] > n.of[3]) {
      a2 = a2 + splat(at[2]) * load(u);
      b2 = b2 + splat(at[2]) * load(u + kLanes);
    }
    store(y + part, ((a0 + a1) + (a2 + a3)) + load(bias + part));
    store(y + part + kLanes, ((b0 + b1) + (b2 + b3)) + load(bias + part + kLanes));
  }
}

SINEW_KERNEL_TARGET void dense(const float* weights, const float* bias, const float* x, std::size_t inputs, float* y,
                               std::size_t outputs) {
  const SumLengths lengths(inputs);
  std::size_t n = 0;
  for (; n + kPanel < outputs; n += kBlock, weights += inputs * kBlock)
    dense_block(weights, bias + n, x, lengths, y + n);
  if (n < outputs) dense_panel(weights, bias + n, x, lengths, y + n);
}

SINEW_INLINE V unary_of(Unary op, V x, V a, V b) {
  switch (op) {
    case Unary::relu:
      return larger(x, V{});
    case Unary::leaky_relu:
      return select(above(V{}, x), a * x, x);
    case Unary::elu:
      return select(bits(x) < I{}, a * exponential_less_1(x), x);
    case Unary::tanh:
      return hyperbolic_tangent(x);
    case Unary::sigmoid:
      return sigmoid(x);
    case Unary::exp:
      return exponential(x);
    case Unary::clip:
      return smaller(larger(x, a), b);
    case Unary::sqrt: {
      V root = x;
#if SINEW_LANES == 1
      root = __builtin_sqrtf(x);
#else
      for (std::size_t i = 0; i < kLanes; ++i) root[i] = __builtin_sqrtf(x[i]);
#endif
      return root;
    }
    case Unary::neg:
      return -x;
    case Unary::abs:
      return magnitude(x);
    case Unary::square:
      return x * x;
    case Unary::canonical:
      return x == x ? x : splat(math::kNanF);
  }
  return x;
}

/// `op` is a constant where this is called, so each has a loop of its own.
SINEW_INLINE void each(Unary op, const float* x, float* y, std::size_t n, float a, float b) {
  const V va = splat(a), vb = splat(b);
  for (std::size_t i = 0; i < n; i += kLanes) store(y + i, unary_of(op, load(x + i), va, vb));
}

SINEW_KERNEL_TARGET void unary(Unary op, const float* x, float* y, std::size_t n, float a, float b) {
  switch (op) {
    case Unary::relu:
      return each(Unary::relu, x, y, n, a, b);
    case Unary::leaky_relu:
      return each(Unary::leaky_relu, x, y, n, a, b);
    case Unary::elu:
      return each(Unary::elu, x, y, n, a, b);
    case Unary::tanh:
      return each(Unary::tanh, x, y, n, a, b);
    case Unary::sigmoid:
      return each(Unary::sigmoid, x, y, n, a, b);
    case Unary::exp:
      return each(Unary::exp, x, y, n, a, b);
    case Unary::canonical:
      return each(Unary::canonical, x, y, n, a, b);
    default:
      return each(op, x, y, n, a, b);
  }
}

SINEW_INLINE V binary_of(Binary op, V a, V b) {
  switch (op) {
    case Binary::add:
      return a + b;
    case Binary::sub:
      return a - b;
    case Binary::mul:
      return a * b;
    case Binary::div:
      return a / b;
    case Binary::min:
      return smaller(a, b);
    case Binary::max:
      return larger(a, b);
  }
  return a;
}

SINEW_KERNEL_TARGET void binary(Binary op, const float* a, const float* b, float* y, std::size_t n) {
  for (std::size_t i = 0; i < n; i += kLanes) store(y + i, binary_of(op, load(a + i), load(b + i)));
}

/// In two loops, so that nothing waits for two functions in a row; with e = e^-z and d = e^2n - 1 the second has one
/// division: next = (e d + state (d + 2)) / ((1 + e) (d + 2)).
SINEW_KERNEL_TARGET void gru_linear(const GruGates& g) {
  const float *xr = g.x + g.stride, *hr = g.h + g.stride, *xn = xr + g.stride, *hn = hr + g.stride;
  const V one = splat(1.0f), two = splat(2.0f);
  for (std::size_t i = 0; i < g.size; i += kLanes) {
    const V e = exponential_of_gate(load(xr + i) + load(hr + i));
    store(g.next + i, load(xn + i) + load(hn + i) / (one + e));
  }
  for (std::size_t i = 0; i < g.size; i += kLanes) {
    const V e = exponential_of_gate(load(g.x + i) + load(g.h + i));
    const V d = exponential_of_tangent(load(g.next + i)), below = d + two;
    store(g.next + i, (e * d + load(g.state + i) * below) / ((one + e) * below));
  }
}
SINEW_KERNEL_TARGET void gru_reset(const GruGates& g, float* z) {
  for (std::size_t i = 0; i < g.size; i += kLanes) {
    store(z + i, sigmoid(load(g.x + i) + load(g.h + i)));
    const V r = sigmoid(load(g.x + g.stride + i) + load(g.h + g.stride + i));
    store(g.next + i, r * load(g.state + i));
  }
}
SINEW_KERNEL_TARGET void gru_finish(const GruGates& g, const float* z) {
  for (std::size_t i = 0; i < g.size; i += kLanes) {
    const V n = hyperbolic_tangent(load(g.x + 2 * g.stride + i) + load(g.h + 2 * g.stride + i));
    store(g.next + i, (splat(1.0f) - load(z + i)) * n + load(z + i) * load(g.state + i));
  }
}
SINEW_KERNEL_TARGET void lstm(const LstmGates& g) {
  const V one = splat(1.0f), two = splat(2.0f);
  for (std::size_t i = 0; i < g.size; i += kLanes) {
    const V in = exponential_of_gate(load(g.x + i) + load(g.h + i));
    const V out = exponential_of_gate(load(g.x + g.stride + i) + load(g.h + g.stride + i));
    const V forget = exponential_of_gate(load(g.x + 2 * g.stride + i) + load(g.h + 2 * g.stride + i));
    const V fresh = exponential_of_tangent(load(g.x + 3 * g.stride + i) + load(g.h + 3 * g.stride + i));
    const V cell = load(g.cell + i) / (one + forget) + fresh / ((one + in) * (fresh + two));
    const V d = exponential_of_tangent(cell);
    store(g.next_cell + i, cell);
    store(g.next + i, d / ((one + out) * (d + two)));
  }
}

}  // namespace sinew::onnx::SINEW_KERNEL_NAMESPACE

#undef SINEW_INLINE
