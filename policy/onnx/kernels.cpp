#define SINEW_KERNEL_NAMESPACE portable
#define SINEW_KERNEL_TARGET
#if defined(__x86_64__) || defined(__aarch64__)
#define SINEW_LANES 4
#ifdef __x86_64__
#define SINEW_MIN __builtin_ia32_minps
#define SINEW_MAX __builtin_ia32_maxps
#endif
#else  // 32-bit Arm: NEON has no division and no numbers below 1e-38; MIPS: no vectors
#define SINEW_LANES 1
#endif
#include "policy/onnx/kernels_body.hpp"
#undef SINEW_KERNEL_NAMESPACE
#undef SINEW_KERNEL_TARGET
#undef SINEW_LANES
#undef SINEW_MIN
#undef SINEW_MAX

namespace sinew::onnx {

const Kernels& portable_kernels() {
  static constexpr Kernels kernels{"portable",           portable::dense,     portable::unary,      portable::binary,
                                   portable::gru_linear, portable::gru_reset, portable::gru_finish, portable::lstm};
  return kernels;
}

const Kernels& best_kernels() {
  const Kernels* avx2 = avx2_kernels();
  return avx2 ? *avx2 : portable_kernels();
}

}  // namespace sinew::onnx
