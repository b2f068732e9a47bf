// For any bytes: no network, or one that runs and gives the same bits with every kernel.
#include "policy/onnx/network.hpp"

#include <cstdlib>
#include <cstring>

using namespace sinew;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  auto loaded = onnx::Network::load({data, size}, {&onnx::portable_kernels()});
  if (static_cast<bool>(loaded.network) != loaded.problems.empty()) std::abort();
  if (!loaded.network || loaded.network->multiplications() > 1'000'000) return 0;
  onnx::Network& network = *loaded.network;
  for (std::size_t i = 0; i < network.inputs().size(); ++i) {
    float x = 0.5f;
    for (float& v : network.input(i)) v = x = 3.7f * x * (1 - x);
  }
  network.run();
  if (!onnx::avx2_kernels()) return 0;
  auto other = onnx::Network::load({data, size}, {onnx::avx2_kernels()});
  if (!other.network) std::abort();
  for (std::size_t i = 0; i < network.inputs().size(); ++i)
    std::memcpy(other.network->input(i).data(), network.input(i).data(), network.input(i).size_bytes());
  other.network->run();
  for (std::size_t o = 0; o < network.outputs().size(); ++o)
    if (std::memcmp(network.output(o).data(), other.network->output(o).data(), network.output(o).size_bytes()) != 0)
      std::abort();
  return 0;
}
