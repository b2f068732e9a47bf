#include "record/crc32.hpp"

#include <array>
#include <cstring>

#if defined(__x86_64__)
#include <immintrin.h>
#define SINEW_FOLDED_CRC 1
#endif

namespace sinew::record {
namespace {

// Polynomials over GF(2) with the bits reversed: bit 31 is x^0, bit 0 is x^31; shifting right multiplies by x.
constexpr std::uint32_t kPolynomial = 0xEDB88320;
constexpr std::uint32_t kOne = 0x80000000;

constexpr std::uint32_t times_x(std::uint32_t a) { return (a >> 1) ^ ((a & 1) != 0 ? kPolynomial : 0); }

constexpr std::uint32_t multiply(std::uint32_t a, std::uint32_t b) {
  std::uint32_t product = 0;
  for (std::uint32_t bit = kOne; bit != 0; bit >>= 1) {
    if ((a & bit) != 0) product ^= b;
    b = times_x(b);
  }
  return product;
}

/// x^n modulo the polynomial.
constexpr std::uint32_t power(std::uint64_t n) {
  std::uint32_t result = kOne;
  for (std::uint32_t square = kOne >> 1; n != 0; n >>= 1) {
    if ((n & 1) != 0) result = multiply(result, square);
    square = multiply(square, square);
  }
  return result;
}

// kTables[k][b]: the sum of byte b followed by k zero bytes.
using Tables = std::array<std::array<std::uint32_t, 256>, 8>;
constexpr Tables make_tables() {
  Tables t{};
  for (std::uint32_t b = 0; b < 256; ++b) {
    std::uint32_t sum = b;
    for (int i = 0; i < 8; ++i) sum = times_x(sum);
    t[0][b] = sum;
  }
  for (std::size_t k = 1; k < t.size(); ++k)
    for (std::size_t b = 0; b < 256; ++b) t[k][b] = (t[k - 1][b] >> 8) ^ t[0][t[k - 1][b] & 0xFF];
  return t;
}
constexpr Tables kTables = make_tables();

std::uint32_t load32(const std::byte* at) {
  const auto b = [at](int i) { return std::to_integer<std::uint32_t>(at[i]); };
  return b(0) | b(1) << 8 | b(2) << 16 | b(3) << 24;
}

/// `sum` here and below is the bare remainder, without the inversions at both ends.
std::uint32_t by_tables(const std::byte* at, std::size_t size, std::uint32_t sum) {
  for (; size >= 8; at += 8, size -= 8) {
    const std::uint32_t low = load32(at) ^ sum, high = load32(at + 4);
    sum = kTables[7][low & 0xFF] ^ kTables[6][low >> 8 & 0xFF] ^ kTables[5][low >> 16 & 0xFF] ^ kTables[4][low >> 24] ^
          kTables[3][high & 0xFF] ^ kTables[2][high >> 8 & 0xFF] ^ kTables[1][high >> 16 & 0xFF] ^
          kTables[0][high >> 24];
  }
  for (; size != 0; ++at, --size) sum = (sum >> 8) ^ kTables[0][(sum ^ std::to_integer<std::uint32_t>(*at)) & 0xFF];
  return sum;
}

#ifdef SINEW_FOLDED_CRC
// Source: V. Gopal et al., "Fast CRC Computation for Generic Polynomials Using PCLMULQDQ Instruction", Intel 2009: 128
// bits are moved over n bits of message by two products with x^(n+32) and x^(n-32), here one bit to the left because of
// the reversed order.
constexpr long long fold_constant(int bits) { return static_cast<long long>(std::uint64_t{power(bits)} << 1); }
struct Fold {
  long long low, high;
};
constexpr Fold fold_over(int bytes) { return {fold_constant(8 * bytes + 32), fold_constant(8 * bytes - 32)}; }
constexpr Fold k256Bytes = fold_over(256), k64Bytes = fold_over(64), k16Bytes = fold_over(16);
static_assert(k64Bytes.low == 0x154442bd4 && k64Bytes.high == 0x1c6e41596, "as printed in the paper");
static_assert(k16Bytes.low == 0x1751997d0 && k16Bytes.high == 0x0ccaa009e, "as printed in the paper");

/// 64 bytes of message, 16 in each, with the same remainder as all bytes before.
struct Folded {
  __m128i a, b, c, d;
};

#define SINEW_FOLDING __attribute__((target("pclmul,sse2")))
// gcc 12 does not align its address sanitizer's own stack to 64 bytes, but then relies on that alignment.
#define SINEW_WIDE_FOLDING __attribute__((target("avx512f,vpclmulqdq,pclmul,sse2"), no_sanitize("address")))

SINEW_FOLDING inline __m128i load(const std::byte* at) { return _mm_loadu_si128(reinterpret_cast<const __m128i*>(at)); }

SINEW_FOLDING inline __m128i fold(__m128i sum, __m128i next, __m128i constant) {
  const __m128i low = _mm_clmulepi64_si128(sum, constant, 0x00);
  const __m128i high = _mm_clmulepi64_si128(sum, constant, 0x11);
  return _mm_xor_si128(_mm_xor_si128(low, high), next);
}

/// The sum over `state` and the rest of the message.
SINEW_FOLDING std::uint32_t finish_folding(const Folded& state, const std::byte* at, std::size_t size) {
  const __m128i far = _mm_set_epi64x(k64Bytes.high, k64Bytes.low), near = _mm_set_epi64x(k16Bytes.high, k16Bytes.low);
  auto [a, b, c, d] = state;
  for (; size >= 64; at += 64, size -= 64) {
    a = fold(a, load(at), far), b = fold(b, load(at + 16), far);
    c = fold(c, load(at + 32), far), d = fold(d, load(at + 48), far);
  }
  a = fold(fold(fold(a, b, near), c, near), d, near);
  for (; size >= 16; at += 16, size -= 16) a = fold(a, load(at), near);
  std::byte rest[16];
  _mm_storeu_si128(reinterpret_cast<__m128i*>(rest), a);
  return by_tables(at, size, by_tables(rest, sizeof rest, 0));
}

SINEW_FOLDING std::uint32_t by_folding(const std::byte* at, std::size_t size, std::uint32_t sum) {
  const __m128i first = _mm_xor_si128(load(at), _mm_cvtsi32_si128(static_cast<int>(sum)));
  return finish_folding({first, load(at + 16), load(at + 32), load(at + 48)}, at + 64, size - 64);
}

SINEW_WIDE_FOLDING inline __m512i wide_fold(__m512i sum, __m512i next, __m512i constant) {
  const __m512i low = _mm512_clmulepi64_epi128(sum, constant, 0x00);
  const __m512i high = _mm512_clmulepi64_epi128(sum, constant, 0x11);
  return _mm512_ternarylogic_epi64(low, high, next, 0x96);  // exclusive or of all three
}

SINEW_WIDE_FOLDING inline __m512i all_lanes(Fold f) {
  return _mm512_set_epi64(f.high, f.low, f.high, f.low, f.high, f.low, f.high, f.low);
}

/// The same four times as wide, for 256 bytes and more.
SINEW_WIDE_FOLDING std::uint32_t by_wide_folding(const std::byte* at, std::size_t size, std::uint32_t sum) {
  const __m512i far = all_lanes(k256Bytes), near = all_lanes(k64Bytes);
  __m512i a = _mm512_xor_si512(_mm512_loadu_si512(at), _mm512_set_epi64(0, 0, 0, 0, 0, 0, 0, sum));
  __m512i b = _mm512_loadu_si512(at + 64), c = _mm512_loadu_si512(at + 128), d = _mm512_loadu_si512(at + 192);
  for (at += 256, size -= 256; size >= 256; at += 256, size -= 256) {
    a = wide_fold(a, _mm512_loadu_si512(at), far), b = wide_fold(b, _mm512_loadu_si512(at + 64), far);
    c = wide_fold(c, _mm512_loadu_si512(at + 128), far), d = wide_fold(d, _mm512_loadu_si512(at + 192), far);
  }
  a = wide_fold(wide_fold(wide_fold(a, b, near), c, near), d, near);
  std::byte state[64];
  _mm512_storeu_si512(state, a);
  return finish_folding({load(state), load(state + 16), load(state + 32), load(state + 48)}, at, size);
}

const bool kCanFold = __builtin_cpu_supports("pclmul") != 0;
const bool kCanFoldWide =
    kCanFold && __builtin_cpu_supports("avx512f") != 0 && __builtin_cpu_supports("vpclmulqdq") != 0;
#endif

}  // namespace

std::uint32_t crc32(std::span<const std::byte> bytes, std::uint32_t before) {
#ifdef SINEW_FOLDED_CRC
  if (bytes.size() >= 1024 && kCanFoldWide) return ~by_wide_folding(bytes.data(), bytes.size(), ~before);
  if (bytes.size() >= 64 && kCanFold) return ~by_folding(bytes.data(), bytes.size(), ~before);
#endif
  return ~by_tables(bytes.data(), bytes.size(), ~before);
}

std::uint32_t crc32_joined(std::uint32_t first, std::uint32_t second, std::uint64_t second_bytes) {
  return multiply(power(second_bytes * 8), first) ^ second;
}

}  // namespace sinew::record
