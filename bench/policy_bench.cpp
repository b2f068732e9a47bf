// A step of a network beside the bare products of its matrices with vectors, on one core.
//   policy_bench [PAIRS]                    ratios
//   policy_bench --count N NETWORK WHICH    N runs of `ours` or `floor`, for callgrind (bench/instructions)
#include <algorithm>
#include <cstdlib>
#include <cstring>

#include "networks.hpp"
#include "pairs.hpp"
#include "policy/onnx/network.hpp"
#include "policy_floor.hpp"

using namespace sinew;

namespace {

struct Subject {
  const char* name;
  double goal;
  std::unique_ptr<onnx::Network> network;
  std::vector<bench::floor::Matrix> matrices{};
  std::vector<std::vector<float>> results{};
  std::vector<float> x = onnx::test::Numbers(2).some(256);

  Subject(const char* n, double most, const onnx::test::ModelWriter& model,
          const std::vector<std::pair<std::size_t, std::size_t>>& sizes)
      : name(n), goal(most) {
    const std::string bytes = model.bytes();
    auto loaded = onnx::Network::load({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()});
    if (!loaded.network) std::printf("%s: %s\n", n, loaded.problems.front().c_str()), std::exit(1);
    network = std::move(loaded.network);
    for (std::size_t i = 0; i < network->inputs().size(); ++i)
      std::copy_n(x.begin(), network->input(i).size(), network->input(i).begin());
    for (const auto& [inputs, outputs] : sizes) {
      bench::floor::Matrix& m = matrices.emplace_back(inputs, outputs);
      const auto weights = onnx::test::Numbers(3).some(static_cast<std::int64_t>(inputs * outputs));
      for (std::size_t i = 0; i < inputs; ++i)
        for (std::size_t o = 0; o < outputs; ++o) m.at(i, o) = weights[i * outputs + o];
      results.emplace_back(m.outputs());
    }
  }
  void ours() { network->run(), bench::keep(network->output(0).data()); }
  void floor() {
    for (std::size_t i = 0; i < matrices.size(); ++i) matrices[i].multiply(x.data(), results[i].data());
    bench::keep(results.back().data());
  }
};

}  // namespace

int main(int argc, char** argv) {
#ifdef __x86_64__
  if (!__builtin_cpu_supports("avx2") || !__builtin_cpu_supports("fma")) {
    std::printf("skipped: the floors need AVX2 and FMA\n");
    return 0;
  }
#endif
  Subject subjects[] = {
      {"policy_mlp_48_256_128_12_relu",
       1.15,
       onnx::test::mlp({48, 256, 128, 12}, "Relu", 1),
       {{48, 256}, {256, 128}, {128, 12}}},
      {"policy_mlp_48_256_128_12_elu",
       1.15,
       onnx::test::mlp({48, 256, 128, 12}, "Elu", 1),
       {{48, 256}, {256, 128}, {128, 12}}},
      {"policy_gru_48_128",
       0,
       onnx::test::recurrent("GRU", 1, 48, 128, true, true, true, 1),
       {{48, 384}, {128, 384}, {128, 3}}},
      {"policy_gru_128_128",
       1.15,
       onnx::test::recurrent("GRU", 1, 128, 128, true, true, true, 1),
       {{128, 384}, {128, 384}, {128, 3}}},
  };
  if (argc == 5 && std::strcmp(argv[1], "--count") == 0) {
    for (Subject& s : subjects)
      for (long i = 0; std::strcmp(argv[3], s.name) == 0 && i < std::atol(argv[2]); ++i)
        std::strcmp(argv[4], "ours") == 0 ? s.ours() : s.floor();
    return 0;
  }
  const int pairs = std::max(15, argc > 1 ? std::atoi(argv[1]) : 25);
  bool good = true;
  for (Subject& s : subjects)
    good &= bench::report(s.name,
                          bench::alternate(
                              pairs, 400, [&] { s.ours(); }, [&] { s.floor(); }),
                          s.goal);
  return good ? 0 : 1;
}
