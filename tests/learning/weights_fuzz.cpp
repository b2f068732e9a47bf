// Weights of a landing policy as text: what is read is a number each, or there is a reason why not.
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "robots/quad/landing_policy.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace sinew;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  std::array<double, 3> weights{7, 7, 7};
  const std::string why = control::read_weights(text, weights);
  if (!why.empty()) {
    if (weights != std::array<double, 3>{7, 7, 7}) std::abort();
    return 0;
  }
  for (const double w : weights)
    if (!math::is_finite(w)) std::abort();
  std::array<double, 3> again{};
  if (!control::read_weights(control::weights_text(weights), again).empty() || again != weights) std::abort();
  return 0;
}
