// Runs a network out of an ONNX file, without a robot: what it takes, what it gives, and what a run gives for zeros.
// usage: example_run_policy FILE.onnx
#include <cstdio>
#include <fstream>
#include <iterator>
#include <string>

#include "policy/onnx/network.hpp"

using namespace sinew;

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: %s FILE.onnx\n", argv[0]);
    return 2;
  }
  std::ifstream in(argv[1], std::ios::binary);
  const std::string file((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());

  auto loaded = onnx::Network::load({reinterpret_cast<const std::uint8_t*>(file.data()), file.size()});
  for (const std::string& problem : loaded.problems) std::fprintf(stderr, "%s: %s\n", argv[1], problem.c_str());
  if (!loaded.network) return 1;
  onnx::Network& network = *loaded.network;

  for (const auto& port : network.inputs())
    std::printf("takes %s %s\n", port.name.c_str(), onnx::text_of(port.dims).c_str());
  std::printf("%zu operations, %llu multiplications\n", network.operations(),
              static_cast<unsigned long long>(network.multiplications()));

  network.run();  // no allocation from here on; inputs are zeros until somebody writes to input(i)
  for (std::size_t o = 0; o < network.outputs().size(); ++o) {
    std::printf("gives %s %s:", network.outputs()[o].name.c_str(), onnx::text_of(network.outputs()[o].dims).c_str());
    for (const float y : network.output(o)) std::printf(" %.6g", double{y});
    std::printf("\n");
  }
  return 0;
}
