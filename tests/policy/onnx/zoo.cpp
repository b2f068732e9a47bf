#include "zoo.hpp"

#include "math/hash.hpp"

namespace sinew::onnx::test {
namespace {

using Ints = std::vector<std::int64_t>;
constexpr std::int64_t kOne = 1;

void add_each_number(std::vector<ZooNetwork>& all) {
  for (const char* op : {"Relu", "Tanh", "Sigmoid", "Elu", "LeakyRelu", "Neg", "Abs"})
    all.push_back({op, single(op, {1, 37}, {1, 37})});
  all.push_back({"Elu_alpha", single("Elu", {1, 5}, {1, 5}, {{"alpha", 0.3f}})});
  all.push_back({"LeakyRelu_alpha", single("LeakyRelu", {1, 5}, {1, 5}, {{"alpha", 0.3f}})});
  all.push_back({"Softmax", single("Softmax", {2, 3, 19}, {2, 3, 19}, {{"axis", std::int64_t{-1}}})});
  all.push_back({"Softmax_old", single("Softmax", {1, 3, 5}, {1, 3, 5}, {}, 11)});
  all.push_back({"Clip_old", single("Clip", {1, 9}, {1, 9}, {{"min", -0.5f}, {"max", 1.0f}}, 9)});
  ModelWriter clip;
  clip.input("x", {1, 9}).output("y", {1, 9}).weight("top", {}, {0.75f}).node("Clip", {"x", "", "top"}, {"y"});
  all.push_back({"Clip_top", clip});
  ModelWriter root;
  root.input("x", {1, 21}).output("y", {1, 21}).weight("two", {}, {2.0f});
  root.node("Pow", {"x", "two"}, {"square"}).node("Sqrt", {"square"}, {"y"});
  all.push_back({"Pow_Sqrt", root});
  for (const char* op : {"Add", "Sub", "Mul", "Div", "Min", "Max"}) {
    Numbers numbers(3);
    ModelWriter rows, numbers_of_two, scalar;
    rows.input("x", {2, 3, 5}).output("y", {2, 3, 5}).weight("b", {3, 1}, numbers.some(3)).node(op, {"x", "b"}, {"y"});
    numbers_of_two.input("x", {1, 4}).input("z", {3, 1}).output("y", {3, 4}).node(op, {"x", "z"}, {"y"});
    scalar.input("x", {1, 7}).output("y", {1, 7}).weight("b", {}, {1.7f}).node(op, {"b", "x"}, {"y"});
    all.push_back({std::string(op) + "_rows", rows});
    all.push_back({std::string(op) + "_broadcast", numbers_of_two});
    all.push_back({std::string(op) + "_scalar", scalar});
  }
}

void add_matrices(std::vector<ZooNetwork>& all) {
  Numbers numbers(5);
  ModelWriter plain, turned, rows, product, product3;
  plain.input("x", {1, 11})
      .output("y", {1, 17})
      .weight("w", {11, 17}, numbers.some(187))
      .node("Gemm", {"x", "w"}, {"y"});
  all.push_back({"Gemm", plain});
  turned.input("x", {7, 1}).output("y", {1, 33}).weight("w", {33, 7}, numbers.some(231)).weight("b", {1}, {0.5f});
  turned.node("Gemm", {"x", "w", "b"}, {"y"}, {{"transA", kOne}, {"transB", kOne}, {"alpha", 0.25f}, {"beta", 2.0f}});
  all.push_back({"Gemm_turned", turned});
  rows.input("x", {3, 6})
      .output("y", {3, 18})
      .weight("w", {6, 18}, numbers.some(108))
      .weight("b", {1, 18}, numbers.some(18));
  rows.node("Gemm", {"x", "w", "b"}, {"y"});
  all.push_back({"Gemm_rows", rows});
  product.input("x", {1, 5})
      .output("y", {1, 2})
      .weight("w", {5, 2}, numbers.some(10))
      .node("MatMul", {"x", "w"}, {"y"});
  all.push_back({"MatMul", product});
  product3.input("x", {2, 3, 9}).output("y", {2, 3, 20}).weight("w", {9, 20}, numbers.some(180));
  product3.node("MatMul", {"x", "w"}, {"y"});
  all.push_back({"MatMul_three", product3});
}

void add_rows(std::vector<ZooNetwork>& all) {
  Numbers numbers(7);
  ModelWriter norm, old;
  norm.input("x", {2, 21}).output("y", {2, 21}).weight("s", {21}, numbers.some(21)).weight("b", {21}, numbers.some(21));
  norm.node("LayerNormalization", {"x", "s", "b"}, {"y"}, {{"epsilon", 1e-4f}});
  all.push_back({"LayerNormalization", norm});
  ModelWriter two;
  two.input("x", {2, 3, 4}).output("y", {2, 3, 4}).weight("s", {3, 4}, numbers.some(12));
  two.node("LayerNormalization", {"x", "s"}, {"y"}, {{"axis", kOne}});
  all.push_back({"LayerNormalization_two", two});
  // As exporters wrote it before there was an operator.
  old.input("x", {1, 16}).output("y", {1, 16}).weight("two", {}, {2.0f}).weight("e", {}, {1e-5f});
  old.node("ReduceMean", {"x"}, {"mean"}, {{"axes", Ints{-1}}}).node("Sub", {"x", "mean"}, {"off"});
  old.node("Pow", {"off", "two"}, {"square"}).node("ReduceMean", {"square"}, {"variance"}, {{"axes", Ints{-1}}});
  old.node("Add", {"variance", "e"}, {"sum"}).node("Sqrt", {"sum"}, {"root"}).node("Div", {"off", "root"}, {"y"});
  all.push_back({"ReduceMean_norm", old});
  all.push_back({"ReduceMean_middle",
                 single("ReduceMean", {2, 3, 4}, {2, 4}, {{"axes", Ints{1}}, {"keepdims", std::int64_t{0}}})});
}

void add_moves(std::vector<ZooNetwork>& all) {
  ModelWriter concat;
  concat.input("x", {2, 3}).input("z", {2, 2}).output("y", {2, 8});
  concat.node("Concat", {"x", "z", "x"}, {"y"}, {{"axis", std::int64_t{-1}}});
  all.push_back({"Concat", concat});
  ModelWriter slice;
  slice.input("x", {3, 8}).output("y", {2, 3}).integers("s", {2}, {0, 6}).integers("e", {2}, {2, -9});
  slice.integers("a", {2}, {0, 1}).integers("t", {2}, {1, -2}).node("Slice", {"x", "s", "e", "a", "t"}, {"y4"});
  slice.integers("s2", {1}, {1}).integers("e2", {1}, {1000}).integers("a2", {1}, {-1});
  slice.node("Slice", {"y4", "s2", "e2", "a2"}, {"y"});
  all.push_back({"Slice", slice});
  all.push_back(
      {"Slice_old", single("Slice", {3, 8}, {3, 2}, {{"starts", Ints{1}}, {"ends", Ints{3}}, {"axes", Ints{1}}}, 9)});
  ModelWriter split;
  split.input("x", {2, 7}).output("y", {2, 3}).output("z", {2, 4}).integers("n", {2}, {3, 4});
  split.node("Split", {"x", "n"}, {"y", "z"}, {{"axis", kOne}});
  all.push_back({"Split", split});
  all.push_back({"Transpose", single("Transpose", {2, 3, 4}, {4, 2, 3}, {{"perm", Ints{2, 0, 1}}})});
  all.push_back({"Flatten", single("Flatten", {2, 3, 4}, {2, 12})});
  ModelWriter gather;
  gather.input("x", {2, 5})
      .output("y", {2, 3})
      .integers("i", {3}, {4, 0, -2})
      .node("Gather", {"x", "i"}, {"y"}, {{"axis", kOne}});
  all.push_back({"Gather", gather});
  // What exporters make of x.view(x.size(0), -1, 2).squeeze(0).unsqueeze(0): shapes are computed in the file.
  ModelWriter shapes;
  shapes.input("x", {1, 6}).output("y", {1, 3, 2}).integers("zero", {}, {0}).integers("axes", {1}, {0});
  shapes.node("Shape", {"x"}, {"shape"}).node("Gather", {"shape", "zero"}, {"batch"}, {{"axis", std::int64_t{0}}});
  shapes.node("Unsqueeze", {"batch", "axes"}, {"batch1"});
  shapes.node("Constant", {}, {"rest"}, {{"value", tensor({2}, Ints{-1, 2})}});
  shapes.node("Concat", {"batch1", "rest"}, {"to"}, {{"axis", std::int64_t{0}}}).node("Reshape", {"x", "to"}, {"a"});
  shapes.node("Squeeze", {"a", "axes"}, {"b"}).node("Unsqueeze", {"b", "axes"}, {"c"}).node("Identity", {"c"}, {"d"});
  shapes.node("Cast", {"d"}, {"e"}, {{"to", kOne}}).node("Dropout", {"e"}, {"y"});
  all.push_back({"Shapes", shapes});
  ModelWriter expand;
  expand.input("x", {1, 3}).output("y", {2, 3}).integers("to", {2}, {2, 1}).node("Expand", {"x", "to"}, {"z"});
  expand.integers("of", {2}, {2, 3})
      .node("ConstantOfShape", {"of"}, {"ones"}, {{"value", tensor({1}, std::vector<float>{1.0f})}});
  expand.node("Add", {"z", "ones"}, {"y"});
  all.push_back({"Expand_ConstantOfShape", expand});
}

void add_cells(std::vector<ZooNetwork>& all) {
  all.push_back({"GRU", recurrent("GRU", 1, 9, 13, true, true, true, 11)});
  all.push_back({"GRU_reset_first", recurrent("GRU", 1, 9, 13, false, true, true, 12)});
  all.push_back({"GRU_steps", recurrent("GRU", 5, 4, 16, false, true, false, 13)});
  all.push_back({"GRU_steps_linear", recurrent("GRU", 4, 4, 16, true, false, true, 14)});
  all.push_back({"LSTM", recurrent("LSTM", 1, 9, 13, false, true, true, 15)});
  all.push_back({"LSTM_steps", recurrent("LSTM", 5, 4, 8, false, false, false, 16)});
}

void add_convolutions(std::vector<ZooNetwork>& all) {
  all.push_back({"Conv", conv({1, 3, 9, 8}, {5, 3, 3, 3}, {1, 5, 7, 6}, {}, true, 21)});
  all.push_back({"Conv_strides", conv({1, 2, 9, 8}, {4, 2, 3, 2}, {1, 4, 5, 5},
                                      {{"strides", Ints{2, 2}}, {"pads", Ints{1, 1, 1, 1}}}, false, 22)});
  all.push_back(
      {"Conv_groups", conv({1, 4, 6, 6}, {8, 1, 3, 3}, {1, 8, 4, 4}, {{"group", std::int64_t{4}}}, true, 23)});
  all.push_back(
      {"Conv_dilated", conv({1, 1, 9, 9}, {2, 1, 3, 3}, {1, 2, 5, 5}, {{"dilations", Ints{2, 2}}}, true, 24)});
  all.push_back({"Conv_same", conv({1, 1, 7, 8}, {3, 1, 2, 3}, {1, 3, 4, 4},
                                   {{"auto_pad", std::string("SAME_UPPER")}, {"strides", Ints{2, 2}}}, true, 25)});
  all.push_back({"Conv_line", conv({1, 3, 20}, {4, 3, 5}, {1, 4, 8}, {{"strides", Ints{2}}}, true, 26)});
}

void add_policies(std::vector<ZooNetwork>& all) {
  all.push_back({"mlp_elu", mlp({48, 256, 128, 12}, "Elu", 31)});
  all.push_back({"mlp_tanh", mlp({17, 64, 64, 6}, "Tanh", 32)});
  all.push_back({"mlp_relu", mlp({5, 33, 2}, "Relu", 33)});
  // A convolution over a history of observations, a normalised row, and a share of each of four actions.
  Numbers numbers(34);
  ModelWriter m;
  m.input("history", {1, 6, 20}).input("command", {1, 3}).output("shares", {1, 4});
  m.weight("c", {8, 6, 6}, numbers.some(288, 0.3)).weight("cb", {8}, numbers.some(8));
  m.node("Conv", {"history", "c", "cb"}, {"seen"}, {{"strides", Ints{3}}}).node("Elu", {"seen"}, {"felt"});
  m.node("Flatten", {"felt"}, {"flat"}).node("Concat", {"flat", "command"}, {"both"}, {{"axis", kOne}});
  m.weight("s", {43}, numbers.some(43)).weight("b", {43}, numbers.some(43));
  m.node("LayerNormalization", {"both", "s", "b"}, {"norm"});
  m.weight("w", {43, 4}, numbers.some(172)).node("MatMul", {"norm", "w"}, {"raw"});
  m.weight("wb", {4}, numbers.some(4)).node("Add", {"raw", "wb"}, {"sum"}).node("Softmax", {"sum"}, {"shares"});
  all.push_back({"history_conv", m});
  all.push_back({"gru_128", recurrent("GRU", 1, 48, 128, true, true, true, 35)});
  all.push_back({"lstm_64", recurrent("LSTM", 1, 30, 64, false, true, true, 36)});
}

}  // namespace

std::vector<ZooNetwork> zoo() {
  std::vector<ZooNetwork> all;
  add_each_number(all);
  add_matrices(all);
  add_rows(all);
  add_moves(all);
  add_cells(all);
  add_convolutions(all);
  add_policies(all);
  return all;
}

std::vector<std::vector<float>> inputs_for(const ZooNetwork& network) {
  Numbers numbers(math::fnv1a64(network.name));
  std::vector<std::vector<float>> all;
  for (const auto& [name, dims] : network.model.inputs) {
    all.push_back(numbers.some(count(dims), 2.5));
    if (name == "z")  // a divisor
      for (float& x : all.back()) x = x < 0 ? x - 1 : x + 1;
  }
  return all;
}

}  // namespace sinew::onnx::test
