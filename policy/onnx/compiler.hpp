#pragma once
// From the nodes of a file to operations: infers shapes, computes what is constant, packs weights.
#include <map>
#include <optional>

#include "policy/onnx/network.hpp"

namespace sinew::onnx {

class Compiler {
 public:
  Compiler(const Model& model, const Kernels& kernels) : model_(model), kernels_(kernels) {}
  LoadedNetwork compile();

  using Handler = bool (Compiler::*)(const Node&);
  struct Operator {
    std::string_view name;
    Handler handler;
  };
  static std::span<const Operator> operators();

 private:
  /// A named value. Integers (shapes, indices) exist while loading only.
  struct Value {
    Dims dims{};
    bool is_constant = false, is_float = true;
    Place place{};
    std::vector<std::int64_t> ints{};
    std::size_t count() const { return is_float ? place.count : ints.size(); }
  };

  // ---- compiler.cpp
  bool fail(const Node& node, const std::string& why);
  bool add_constant(const std::string& name, const Tensor& t);
  void add_inputs();
  void add_node(const Node& node);
  bool add_outputs(LoadedNetwork& out);
  void move_together(Network& network);

  bool has(const Node& node, std::size_t i) const { return i < node.inputs.size() && !node.inputs[i].empty(); }
  const Value& in(const Node& node, std::size_t i) const { return values_.at(node.inputs[i]); }
  /// A float input; false: it is not there, or holds integers.
  bool float_in(const Node& node, std::size_t i);
  bool want_inputs(const Node& node, std::size_t least, std::size_t most);
  /// Constant integers of an input; nothing, with a problem, when it is something else.
  std::optional<std::vector<std::int64_t>> integers(const Node& node, std::size_t i);
  std::span<const float> floats(const Value& v) const { return {memory_.data() + v.place.offset, v.place.count}; }
  std::optional<float> scalar(const Node& node, std::size_t i, float otherwise);
  /// -n..n-1 as 0..n-1; nothing, with a problem, outside.
  std::optional<std::size_t> axis_of(const Node& node, std::int64_t axis, std::size_t rank);

  std::optional<Place> room(const Node& node, const Dims& dims);
  bool define(const Node& node, std::size_t output, Value value);
  bool alias(const Node& node, const Value& of, Dims dims);
  /// Runs it now where all that it reads is constant, else in each run.
  void emit(std::unique_ptr<Operation> op, bool constant);
  bool unary(const Node& node, Unary op, float a = 0, float b = 0);
  bool binary(const Node& node, Binary op);
  /// The output is made of `value`'s elements at `from`.
  bool move(const Node& node, const Value& value, Dims dims, std::vector<std::uint32_t> from, std::size_t output = 0);
  std::optional<Value> moved(const Node& node, const Value& value, Dims dims, std::vector<std::uint32_t> from);
  std::optional<Value> expanded(const Node& node, const Value& value, const Dims& to);
  bool dense(const Node& node, Weights weights, std::size_t rows, const Value& x, Dims dims);
  bool count_multiplications(const Node& node, std::uint64_t more);

  // ---- operators_*.cpp
  bool gemm(const Node& n);
  bool mat_mul(const Node& n);
  bool conv(const Node& n);
  bool gru(const Node& n);
  bool lstm(const Node& n);
  bool layer_normalization(const Node& n);
  bool softmax(const Node& n);
  bool reduce_mean(const Node& n);
  bool add(const Node& n) { return binary(n, Binary::add); }
  bool sub(const Node& n) { return binary(n, Binary::sub); }
  bool mul(const Node& n) { return binary(n, Binary::mul); }
  bool div(const Node& n) { return binary(n, Binary::div); }
  bool min(const Node& n) { return binary(n, Binary::min); }
  bool max(const Node& n) { return binary(n, Binary::max); }
  bool relu(const Node& n) { return unary(n, Unary::relu); }
  bool tanh(const Node& n) { return unary(n, Unary::tanh); }
  bool sigmoid(const Node& n) { return unary(n, Unary::sigmoid); }
  bool sqrt(const Node& n) { return unary(n, Unary::sqrt); }
  bool neg(const Node& n) { return unary(n, Unary::neg); }
  bool abs(const Node& n) { return unary(n, Unary::abs); }
  bool elu(const Node& n);
  bool leaky_relu(const Node& n);
  bool clip(const Node& n);
  bool pow(const Node& n);
  bool cast(const Node& n);
  bool identity(const Node& n);
  bool dropout(const Node& n);
  bool constant(const Node& n);
  bool constant_of_shape(const Node& n);
  bool shape(const Node& n);
  bool reshape(const Node& n);
  bool flatten(const Node& n);
  bool squeeze(const Node& n);
  bool unsqueeze(const Node& n);
  bool transpose(const Node& n);
  bool concat(const Node& n);
  bool slice(const Node& n);
  bool split(const Node& n);
  bool gather(const Node& n);
  bool expand(const Node& n);

  std::optional<std::vector<std::int64_t>> axes_of(const Node& node, std::size_t input);
  /// Of GRU and LSTM: what both have in common; false, with a problem, where it is not supported.
  bool recurrent(const Node& n, std::size_t gates, CellShape& shape, std::size_t& inputs);
  std::optional<Place> first_state(const Node& n, std::size_t input, std::size_t hidden);
  bool conv_shape(const Node& n, ConvShape& s);

  const Model& model_;
  const Kernels& kernels_;
  std::map<std::string, Value, std::less<>> values_;
  std::map<std::string, bool, std::less<>> lost_;  // made by nodes that have problems
  std::vector<float> memory_;                      // while loading
  Operations operations_;
  std::vector<Network::Port> inputs_, outputs_;
  std::vector<std::string> problems_;
  std::uint64_t multiplications_ = 0;
  std::size_t integers_ = 0;
};

/// Row-major indices into something of `dims`: for each element of `to`, broadcast over it. The shapes fit.
std::vector<std::uint32_t> broadcast_indices(const Dims& dims, const Dims& to);
/// Nothing: they do not fit.
std::optional<Dims> broadcast_dims(const Dims& a, const Dims& b);
std::vector<std::size_t> strides_of(const Dims& dims);

}  // namespace sinew::onnx
