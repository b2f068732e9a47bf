// Networks out of files: values, the same bits everywhere, and what is refused in which words.
#include "policy/onnx/network.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "math/hash.hpp"
#include "zoo.hpp"

namespace sinew::onnx::network_test {
namespace {

using test::ModelWriter;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using Ints = std::vector<std::int64_t>;

LoadedNetwork load(const std::string& bytes, const Kernels* kernels = nullptr) {
  return Network::load({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()}, {kernels});
}
std::string problem(const ModelWriter& m) {
  const auto loaded = load(m.bytes());
  EXPECT_EQ(loaded.network, nullptr);
  return loaded.problems.empty() ? "" : loaded.problems.front();
}
std::vector<std::vector<float>> run(Network& network, const std::vector<std::vector<float>>& inputs) {
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    EXPECT_EQ(network.input(i).size(), inputs[i].size());
    std::copy(inputs[i].begin(), inputs[i].end(), network.input(i).begin());
  }
  network.run();
  std::vector<std::vector<float>> out;
  for (std::size_t o = 0; o < network.outputs().size(); ++o)
    out.emplace_back(network.output(o).begin(), network.output(o).end());
  return out;
}
std::uint64_t hash_of(const std::vector<std::vector<float>>& numbers) {
  math::Hash64 hash;
  for (const auto& n : numbers) hash.add(n.data(), n.size() * sizeof(float));
  return hash.value();
}

TEST(NetworkTest, AnMlpHasTheValuesOfItsSums) {
  const auto model = test::mlp({5, 33, 2}, "Relu", 33);
  auto loaded = load(model.bytes());
  ASSERT_TRUE(loaded.network) << ::testing::PrintToString(loaded.problems);
  test::Numbers numbers(33);
  const auto w0 = numbers.some(33 * 5, 1), b0 = numbers.some(33), w1 = numbers.some(2 * 33, 1.5 / 33 * 8),
             b1 = numbers.some(2);
  const std::vector<float> x{0.5f, -1.0f, 2.0f, 0.25f, -0.125f};
  double hidden[33];
  for (std::size_t i = 0; i < 33; ++i) {
    hidden[i] = b0[i];
    for (std::size_t j = 0; j < 5; ++j) hidden[i] += double{w0[i * 5 + j]} * x[j];
    hidden[i] = std::max(0.0, hidden[i]);
  }
  const auto y = run(*loaded.network, {x}).front();
  for (std::size_t i = 0; i < 2; ++i) {
    double sum = b1[i];
    for (std::size_t j = 0; j < 33; ++j) sum += double{w1[i * 33 + j]} * hidden[j];
    EXPECT_NEAR(y[i], sum, 1e-5);
  }
}

TEST(NetworkTest, ActivationsAreWithinSomeUlpOfTheTrueOnes) {
  for (const auto& [op, truth] : std::vector<std::pair<std::string, double (*)(double)>>{
           {"Tanh", [](double x) { return std::tanh(x); }},
           {"Sigmoid", [](double x) { return 1 / (1 + std::exp(-x)); }},
           {"Elu", [](double x) { return x > 0 ? x : std::expm1(x); }}}) {
    auto loaded = load(test::single(op, {1, 4096}, {1, 4096}).bytes());
    ASSERT_TRUE(loaded.network);
    for (const double most : {0.01, 1.0, 12.0, 200.0}) {
      const auto x = test::Numbers(9).some(4096, most);
      const auto y = run(*loaded.network, {x}).front();
      for (std::size_t i = 0; i < x.size(); ++i) EXPECT_NEAR(y[i], truth(double{x[i]}), 2.5e-7) << op << " of " << x[i];
    }
  }
}

TEST(NetworkTest, EveryKernelGivesTheSameBits) {
  if (!avx2_kernels()) GTEST_SKIP() << "this processor has one variant";
  for (const auto& one : test::zoo()) {
    auto fast = load(one.model.bytes(), avx2_kernels()), plain = load(one.model.bytes(), &portable_kernels());
    ASSERT_TRUE(fast.network && plain.network) << one.name << ": " << ::testing::PrintToString(fast.problems);
    const auto inputs = test::inputs_for(one);
    EXPECT_EQ(hash_of(run(*fast.network, inputs)), hash_of(run(*plain.network, inputs))) << one.name;
  }
}

/// The number was printed by this test on x86-64; every board and compiler has to give it.
TEST(NetworkTest, AllNetworksOfTheTestsHaveTheSameBytesOnEveryMachine) {
  math::Hash64 all;
  for (const auto& one : test::zoo()) {
    auto loaded = load(one.model.bytes());
    ASSERT_TRUE(loaded.network) << one.name << ": " << ::testing::PrintToString(loaded.problems);
    std::uint64_t hash = hash_of(run(*loaded.network, test::inputs_for(one)));
    all.add(&hash, sizeof hash);
  }
  EXPECT_EQ(all.value(), 8520383737919051190u);
}

TEST(NetworkTest, ARunDependsOnItsInputsAlone) {
  for (const auto& one : test::zoo()) {
    auto loaded = load(one.model.bytes());
    ASSERT_TRUE(loaded.network) << one.name;
    const auto inputs = test::inputs_for(one);
    const auto first = run(*loaded.network, inputs);
    auto others = inputs;
    for (auto& numbers : others)
      for (float& x : numbers) x = 3.0f - x;
    run(*loaded.network, others);
    EXPECT_EQ(run(*loaded.network, inputs), first) << one.name;
  }
}

TEST(NetworkTest, ShapesAreThoseThatTheFileSays) {
  for (const auto& one : test::zoo()) {
    auto loaded = load(one.model.bytes());
    ASSERT_TRUE(loaded.network) << one.name;
    Model model;
    std::string why;
    const std::string bytes = one.model.bytes();
    ASSERT_TRUE(read_model({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()}, model, why)) << why;
    for (const GraphPort& port : model.outputs) {
      Dims dims = port.dims;
      for (auto& d : dims) d = d < 0 ? 1 : d;
      const auto at = static_cast<std::size_t>(loaded.network->find_output(port.name));
      EXPECT_EQ(loaded.network->outputs()[at].dims, dims) << one.name << ": " << port.name;
    }
  }
}

TEST(NetworkTest, NotANumberGoesThroughAndHasOneForm) {
  auto loaded = load(test::mlp({5, 33, 2}, "Elu", 33).bytes());
  ASSERT_TRUE(loaded.network);
  const auto y = run(*loaded.network, {{0.5f, -std::nanf(""), 2.0f, 0.25f, -0.125f}}).front();
  for (const float v : y) EXPECT_EQ(std::bit_cast<std::uint32_t>(v), 0x7FC00000u);
}

TEST(NetworkTest, AnUnknownOperatorIsToldWithItsNode) {
  ModelWriter m;
  m.input("x", {1, 4}).output("y", {1, 4}).node("Einsum", {"x"}, {"z"}, {}, "/actor/attention/Einsum");
  m.node("Relu", {"z"}, {"y"}).node("FusedGelu", {"x"}, {"g"}, {}, "/actor/gelu", "com.microsoft");
  const auto loaded = load(m.bytes());
  ASSERT_EQ(loaded.problems.size(), 2u) << "what follows from a problem is not told";
  EXPECT_THAT(
      loaded.problems[0],
      HasSubstr("node '/actor/attention/Einsum' (Einsum): operator Einsum is not supported; supported are Abs Add"));
  EXPECT_EQ(loaded.problems[1], "node '/actor/gelu' (FusedGelu): operator com.microsoft.FusedGelu is not supported");
}

TEST(NetworkTest, WhatDoesNotFitIsToldWithItsNode) {
  const auto gemm = [](const test::Dims& x, const test::Dims& w) {
    ModelWriter m;
    m.input("x", x).output("y", {1, 1}).weight("w", w, std::vector<float>(static_cast<std::size_t>(test::count(w))));
    m.node("Gemm", {"x", "w"}, {"y"}, {}, "/out/Gemm");
    return problem(m);
  };
  EXPECT_EQ(gemm({1, 4}, {5, 3}), "node '/out/Gemm' (Gemm): multiplies [1, 4] by a matrix for 5 inputs");
  EXPECT_THAT(gemm({4}, {5, 3}), HasSubstr("two dimensions each are needed"));
  ModelWriter two;
  two.input("x", {1, 4}).input("z", {1, 3}).output("y", {1, 4}).node("Add", {"x", "z"}, {"y"}, {}, "/sum");
  EXPECT_EQ(problem(two), "node '/sum' (Add): the shapes [1, 4] and [1, 3] do not fit each other");
  ModelWriter backward = test::recurrent("GRU", 1, 2, 3, true, false, false, 1);
  backward.node("GRU", {"x", "W", "R"}, {"again"}, {{"direction", std::string("reverse")}}, "/back");
  EXPECT_EQ(problem(backward), "node '/back' (GRU): direction reverse; forward is supported");
  ModelWriter nothing;
  nothing.input("x", {1, 4}).output("y", {1, 4}).node("Relu", {"w"}, {"y"}, {}, "/r");
  EXPECT_EQ(problem(nothing), "node '/r' (Relu): reads 'w', which nothing before it makes");
  ModelWriter dynamic;
  dynamic.input("x", {1, 4}).input("w", {4, 4}).output("y", {1, 4}).node("MatMul", {"x", "w"}, {"y"}, {}, "/attend");
  EXPECT_THAT(problem(dynamic), HasSubstr("node '/attend' (MatMul): the second matrix must be constant (weights)"));
  EXPECT_EQ(problem(test::single("Relu", {1, 4}, {1, 4}, {}, 99)), "opset 99; 7 to 22 are supported");
}

TEST(NetworkTest, FilesThatAreNoneAreRefused) {
  EXPECT_THAT(load("").problems.front(), HasSubstr("no ONNX file, or a damaged one"));
  EXPECT_THAT(load("a text\nof some lines").problems.front(), HasSubstr("no ONNX file, or a damaged one"));
  const std::string whole = test::mlp({5, 8, 2}, "Elu", 1).bytes();
  for (std::size_t size = 0; size < whole.size(); ++size)
    EXPECT_EQ(load(whole.substr(0, size)).network, nullptr) << size;
  test::PbWriter outside;
  outside.integer(1, 4).integer(2, 1).text(8, "w").integer(14, 1);
  ModelWriter m = test::single("Relu", {1, 4}, {1, 4});
  m.raw_weight(outside);
  EXPECT_EQ(problem(m), "weight 'w' is in another file (external data): export the network as one file");
  test::PbWriter half;
  half.integer(1, 4).integer(2, 10).text(8, "w").text(9, "12345678");
  ModelWriter n = test::single("Relu", {1, 4}, {1, 4});
  n.raw_weight(half);
  EXPECT_EQ(problem(n), "weight 'w' is of float16; float and, for shapes, int32 and int64 are supported");
}

}  // namespace
}  // namespace sinew::onnx::network_test
