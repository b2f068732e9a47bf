#pragma once
// Networks of the usual forms, with weights that are the same on every machine: for tests and measurements.
#include <string>
#include <vector>

#include "math/random.hpp"
#include "model_writer.hpp"

namespace sinew::onnx::test {

/// The same numbers on every machine.
class Numbers {
 public:
  explicit Numbers(std::uint64_t seed) : random_(seed) {}
  std::vector<float> some(std::int64_t count, double most = 1) {
    std::vector<float> v(static_cast<std::size_t>(count));
    for (float& x : v) x = static_cast<float>(random_.uniform(-most, most));
    return v;
  }

 private:
  math::Random random_;
};

inline std::int64_t count(const Dims& dims) {
  std::int64_t n = 1;
  for (const std::int64_t d : dims) n *= d < 0 ? 1 : d;
  return n;
}

/// x -> op -> y.
inline ModelWriter single(const std::string& op, const Dims& in, const Dims& out, const Attributes& a = {},
                          std::int64_t opset = 17) {
  ModelWriter m(opset);
  m.input("x", in).output("y", out).node(op, {"x"}, {"y"}, a);
  return m;
}

/// A multilayer perceptron of Gemm nodes as PyTorch writes them.
inline ModelWriter mlp(const Dims& sizes, const std::string& activation, std::uint64_t seed) {
  Numbers numbers(seed);
  ModelWriter m;
  m.input("obs", {-1, sizes.front()}).output("actions", {-1, sizes.back()});
  std::string from = "obs";
  for (std::size_t i = 0; i + 1 < sizes.size(); ++i) {
    const std::string n = std::to_string(i), w = "actor." + n + ".weight", b = "actor." + n + ".bias";
    const bool last = i + 2 == sizes.size();
    const double most = 1.5 / static_cast<double>(sizes[i]) * 8;
    m.weight(w, {sizes[i + 1], sizes[i]}, numbers.some(sizes[i + 1] * sizes[i], most < 1 ? most : 1));
    m.weight(b, {sizes[i + 1]}, numbers.some(sizes[i + 1]));
    m.node("Gemm", {from, w, b}, {last ? "actions" : "pre" + n}, {{"transB", std::int64_t{1}}},
           "/actor/" + n + "/Gemm");
    if (!last) m.node(activation, {"pre" + n}, {"act" + n}, {}, "/actor/" + n + "/" + activation);
    from = "act" + n;
  }
  return m;
}

/// A cell with its state as input and output, and a Gemm behind it.
inline ModelWriter recurrent(const std::string& op, std::int64_t steps, std::int64_t inputs, std::int64_t hidden,
                             bool linear, bool bias, bool with_state, std::uint64_t seed) {
  Numbers numbers(seed);
  const bool lstm = op == "LSTM";
  const std::int64_t gates = lstm ? 4 : 3;
  ModelWriter m;
  m.input("x", {steps, 1, inputs});
  m.weight("W", {1, gates * hidden, inputs}, numbers.some(gates * hidden * inputs, 0.5));
  m.weight("R", {1, gates * hidden, hidden}, numbers.some(gates * hidden * hidden, 0.3));
  Names in{"x", "W", "R"};
  if (bias) m.weight("B", {1, 2 * gates * hidden}, numbers.some(2 * gates * hidden));
  in.push_back(bias ? "B" : "");
  in.push_back("");
  if (with_state) {
    m.input("h", {1, 1, hidden});
    in.push_back("h");
    if (lstm) m.input("c", {1, 1, hidden}), in.push_back("c");
  }
  while (in.back().empty()) in.pop_back();
  Attributes a{{"hidden_size", hidden}};
  if (!lstm) a.push_back({"linear_before_reset", std::int64_t{linear}});
  Names out{"all", "h_out"};
  m.output("all", {steps, 1, 1, hidden}).output("h_out", {1, 1, hidden});
  if (lstm) m.output("c_out", {1, 1, hidden}), out.push_back("c_out");
  m.node(op, in, out, a, "/rnn/" + op);
  m.weight("Wa", {hidden, 3}, numbers.some(hidden * 3)).integers("flat", {2}, {-1, hidden});
  m.output("actions", {1, 3});
  m.node("Reshape", {"h_out", "flat"}, {"row"}).node("MatMul", {"row", "Wa"}, {"actions"});
  return m;
}

inline ModelWriter conv(const Dims& in, const Dims& weights, const Dims& out, const Attributes& a, bool bias,
                        std::uint64_t seed) {
  Numbers numbers(seed);
  ModelWriter m;
  m.input("x", in).output("y", out).weight("w", weights, numbers.some(count(weights)));
  Names names{"x", "w"};
  if (bias) m.weight("b", {weights[0]}, numbers.some(weights[0])), names.push_back("b");
  m.node("Conv", names, {"y"}, a);
  return m;
}

}  // namespace sinew::onnx::test
