#include "policy/onnx/kernels.hpp"

#ifdef __x86_64__
#define SINEW_KERNEL_NAMESPACE avx2
#define SINEW_KERNEL_TARGET __attribute__((target("avx2")))
#define SINEW_LANES 8
#define SINEW_MIN __builtin_ia32_minps256
#define SINEW_MAX __builtin_ia32_maxps256
#include "policy/onnx/kernels_body.hpp"
#undef SINEW_KERNEL_NAMESPACE
#undef SINEW_KERNEL_TARGET
#undef SINEW_LANES
#undef SINEW_MIN
#undef SINEW_MAX
#endif

namespace sinew::onnx {

const Kernels* avx2_kernels() {
#ifdef __x86_64__
  static constexpr Kernels kernels{"avx2",           avx2::dense,     avx2::unary,      avx2::binary,
                                   avx2::gru_linear, avx2::gru_reset, avx2::gru_finish, avx2::lstm};
  if (__builtin_cpu_supports("avx2")) return &kernels;
#endif
  return nullptr;
}

}  // namespace sinew::onnx
