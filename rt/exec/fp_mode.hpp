#pragma once
// The floating-point mode of a thread, on which all bits of a run depend: rounding to nearest, and numbers below the
// normal ones kept. A library may have left another one (fast-math start-up code flushes them to zero).
#include <cstdint>

#if defined(__x86_64__) || defined(__SSE2__)
#include <xmmintrin.h>
#endif

namespace sinew::rt {

/// RT: yes, all.   Thread: the calling thread's own mode.
/// Source:  Intel 64 and IA-32 SDM, volume 1, 10.2.3 (MXCSR); Arm ARM for A-profile, FPCR and FPSCR; MIPS32
///          Architecture, volume I-A, and MIPS32 24K software manual, FCSR.
class FpMode {
 public:
  /// Rounds to nearest, keeps subnormal numbers, traps nothing.
  static void set() noexcept { write((read() & ~kMustBeZero) | kMustBeSet); }
  /// True when the control register says so; a few instructions. On processors other than x86, Arm and MIPS:
  /// computes_right().
  static bool is_set() noexcept {
    return kHasRegister ? (read() & (kMustBeZero | kMustBeSet)) == kMustBeSet : computes_right();
  }
  /// True when trial computations come out right: they also show what no register shows.
  static bool computes_right() noexcept {
    volatile double one = 1.0, tiny = 0x1p-1022, ulp = 0x1p-53, half = 0.5;
    const double up = one + ulp * 1.5, down = one + ulp * half, minus = -one - ulp * half;
    return tiny * half != 0 && up > one && down == one && minus == -one;
  }

 private:
  friend class FpModeScope;
#if defined(__x86_64__) || defined(__SSE2__)
  using Word = std::uint32_t;
  // MXCSR: bit 6 DAZ, bits 13-14 rounding, bit 15 FTZ; 7-12 mask the exceptions.
  static constexpr Word kMustBeZero = 1U << 6 | 3U << 13 | 1U << 15, kMustBeSet = 0x3FU << 7;
  static Word read() noexcept { return _mm_getcsr(); }
  static constexpr bool kHasRegister = true;
  static void write(Word w) noexcept { _mm_setcsr(w); }
#elif defined(__aarch64__)
  using Word = std::uint64_t;
  // FPCR: bits 0-2 AH, FIZ, NEP, 8-12 and 15 trap enables, 19 FZ16, 22-23 rounding, 24 FZ, 25 DN (other NaN bits).
  static constexpr Word kMustBeZero = Word{7} | Word{0x1F} << 8 | Word{1} << 15 | Word{1} << 19 | Word{0xF} << 22,
                        kMustBeSet = 0;
  static Word read() noexcept {
    Word w;
    asm volatile("mrs %0, fpcr" : "=r"(w));
    return w;
  }
  static constexpr bool kHasRegister = true;
  static void write(Word w) noexcept { asm volatile("msr fpcr, %0" ::"r"(w)); }
#elif defined(__arm__) && defined(__ARM_FP)
  using Word = std::uint32_t;
  // FPSCR: bits 8-12 and 15 trap enables, 22-23 rounding, 24 FZ, 25 DN.
  static constexpr Word kMustBeZero = 0x1FU << 8 | 1U << 15 | 0xFU << 22, kMustBeSet = 0;
  static Word read() noexcept {
    Word w;
    asm volatile("vmrs %0, fpscr" : "=r"(w));
    return w;
  }
  static constexpr bool kHasRegister = true;
  static void write(Word w) noexcept { asm volatile("vmsr fpscr, %0" ::"r"(w)); }
#elif defined(__mips_hard_float)
  using Word = std::uint32_t;
  // FCSR: bits 0-1 rounding, 7-11 trap enables, 21-22 FN and FO (other ways to flush, on some processors), 24 FS.
  static constexpr Word kMustBeZero = 3U | 0x1FU << 7 | 3U << 21 | 1U << 24, kMustBeSet = 0;
  static Word read() noexcept {
    Word w;
    asm volatile("cfc1 %0, $31" : "=r"(w));
    return w;
  }
  static constexpr bool kHasRegister = true;
  // Bits 12-17 are the causes of the last operation: written beside their trap enables, they trap.
  static void write(Word w) noexcept { asm volatile("ctc1 %0, $31" ::"r"(w & ~(0x3FU << 12))); }
#else
  using Word = std::uint32_t;
  static constexpr Word kMustBeZero = 0, kMustBeSet = 0;
  static Word read() noexcept { return 0; }
  static void write(Word) noexcept {}
  static constexpr bool kHasRegister = false;
#endif
};

/// Sets the right mode for the calling thread, and restores the old mode at the end of the scope.
class FpModeScope {
 public:
  FpModeScope() noexcept : before_(FpMode::read()) { FpMode::set(); }
  ~FpModeScope() { FpMode::write(before_); }
  FpModeScope(const FpModeScope&) = delete;
  FpModeScope& operator=(const FpModeScope&) = delete;

 private:
  const FpMode::Word before_;
};

}  // namespace sinew::rt
