#pragma once
// What a loaded network does in a run, one operation after the other.
#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "policy/onnx/aligned.hpp"
#include "policy/onnx/kernels.hpp"

namespace sinew::onnx {

/// Where numbers lie in the network's memory. Each place has 2 * kBehind numbers behind it.
struct Place {
  std::uint32_t offset = 0, count = 0;
};

/// Reads and writes places of `memory`; all sizes are fixed when it is made.
/// RT: yes, once it is made.
class Operation {
 public:
  virtual ~Operation() = default;
  virtual void run(float* memory) noexcept = 0;
  /// Calls `each` for every place that run() touches; each may move it.
  virtual void places(const std::function<void(Place&)>& each) = 0;
};
using Operations = std::vector<std::unique_ptr<Operation>>;

/// A matrix in blocks (kBlock), with its bias.
class Weights {
 public:
  Weights() = default;
  Weights(std::size_t inputs, std::size_t outputs)
      : blocks_(inputs * padded(outputs)), bias_(padded(outputs)), inputs_(inputs), outputs_(outputs) {}
  static std::size_t padded(std::size_t outputs) { return (outputs + kPanel - 1) / kPanel * kPanel; }
  float& at(std::size_t input, std::size_t output) {
    return blocks_.data()[place_of_weight(input, output, inputs_, bias_.size())];
  }
  float& bias(std::size_t output) { return bias_.data()[output]; }
  std::size_t inputs() const { return inputs_; }
  std::size_t outputs() const { return outputs_; }
  /// y has room for padded(outputs).
  void run(const Kernels& kernels, const float* x, float* y) const {
    kernels.dense(blocks_.data(), bias_.data(), x, inputs_, y, outputs_);
  }

 private:
  AlignedFloats blocks_, bias_;
  std::size_t inputs_ = 0, outputs_ = 0;
};

/// Rows of x, each times the same matrix.
class DenseOperation final : public Operation {
 public:
  DenseOperation(const Kernels& k, Weights w, std::size_t rows, Place x, Place y)
      : kernels_(k), weights_(std::move(w)), rows_(rows), x_(x), y_(y) {}
  void run(float* memory) noexcept override;
  void places(const std::function<void(Place&)>& each) override { each(x_), each(y_); }

 private:
  const Kernels& kernels_;
  Weights weights_;
  std::size_t rows_;
  Place x_, y_;
};

class UnaryOperation final : public Operation {
 public:
  UnaryOperation(const Kernels& k, Unary op, float a, float b, Place x, Place y)
      : kernels_(k), op_(op), a_(a), b_(b), x_(x), y_(y) {}
  void run(float* memory) noexcept override;
  void places(const std::function<void(Place&)>& each) override { each(x_), each(y_); }

 private:
  const Kernels& kernels_;
  Unary op_;
  float a_, b_;
  Place x_, y_;
};

/// Both of the same shape.
class BinaryOperation final : public Operation {
 public:
  BinaryOperation(const Kernels& k, Binary op, Place a, Place b, Place y) : kernels_(k), op_(op), a_(a), b_(b), y_(y) {}
  void run(float* memory) noexcept override;
  void places(const std::function<void(Place&)>& each) override { each(a_), each(b_), each(y_); }

 private:
  const Kernels& kernels_;
  Binary op_;
  Place a_, b_, y_;
};

/// y[i] = x[from[i]]: whatever only moves numbers.
class MoveOperation final : public Operation {
 public:
  MoveOperation(std::vector<std::uint32_t> from, Place x, Place y) : from_(std::move(from)), x_(x), y_(y) {}
  void run(float* memory) noexcept override;
  void places(const std::function<void(Place&)>& each) override { each(x_), each(y_); }

 private:
  std::vector<std::uint32_t> from_;
  Place x_, y_;
};

/// Blocks of x to every `stride` of y: one input of a Concat.
class BlockOperation final : public Operation {
 public:
  BlockOperation(std::size_t blocks, std::size_t size, std::size_t stride, std::size_t first, Place x, Place y)
      : blocks_(blocks), size_(size), stride_(stride), first_(first), x_(x), y_(y) {}
  void run(float* memory) noexcept override;
  void places(const std::function<void(Place&)>& each) override { each(x_), each(y_); }

 private:
  std::size_t blocks_, size_, stride_, first_;
  Place x_, y_;
};

/// Over the rows of x: softmax, or the mean of each.
class RowOperation final : public Operation {
 public:
  enum class Kind : std::uint8_t { softmax, mean };
  RowOperation(const Kernels& k, Kind kind, std::size_t rows, std::size_t size, Place x, Place y)
      : kernels_(k), kind_(kind), rows_(rows), size_(size), row_(size), x_(x), y_(y) {}
  void run(float* memory) noexcept override;
  void places(const std::function<void(Place&)>& each) override { each(x_), each(y_); }

 private:
  const Kernels& kernels_;
  Kind kind_;
  std::size_t rows_, size_;
  AlignedFloats row_;
  Place x_, y_;
};

/// Scale and bias have the size of a row; without bias it is zeros.
class LayerNormOperation final : public Operation {
 public:
  LayerNormOperation(std::size_t rows, std::size_t size, float epsilon, Place x, Place scale, Place bias, Place y)
      : rows_(rows), size_(size), epsilon_(epsilon), x_(x), scale_(scale), bias_(bias), y_(y) {}
  void run(float* memory) noexcept override;
  void places(const std::function<void(Place&)>& each) override { each(x_), each(scale_), each(bias_), each(y_); }

 private:
  std::size_t rows_, size_;
  float epsilon_;
  Place x_, scale_, bias_, y_;
};

/// What GRU and LSTM have in common: gates of `hidden`, each beginning a panel.
struct CellShape {
  std::size_t steps = 1, hidden = 0;
  std::size_t stride() const { return Weights::padded(hidden); }
};

class GruOperation final : public Operation {
 public:
  GruOperation(const Kernels& k, CellShape shape, bool linear, Weights input, Weights state, Weights candidate, Place x,
               Place first, Place all, Place last);
  void run(float* memory) noexcept override;
  void places(const std::function<void(Place&)>& each) override { each(x_), each(first_), each(all_), each(last_); }

 private:
  const Kernels& kernels_;
  CellShape shape_;
  bool linear_;
  Weights input_, state_, candidate_;  // candidate: of n alone, where the reset comes before the product
  AlignedFloats gates_x_, gates_h_, h_, next_, z_;
  Place x_, first_, all_, last_;
};

class LstmOperation final : public Operation {
 public:
  LstmOperation(const Kernels& k, CellShape shape, Weights input, Weights state, Place x, Place first_h, Place first_c,
                Place all, Place last_h, Place last_c);
  void run(float* memory) noexcept override;
  void places(const std::function<void(Place&)>& each) override {
    for (Place* p : {&x_, &first_h_, &first_c_, &all_, &last_h_, &last_c_}) each(*p);
  }

 private:
  const Kernels& kernels_;
  CellShape shape_;
  Weights input_, state_;
  AlignedFloats gates_x_, gates_h_, h_, c_, next_h_, next_c_;
  Place x_, first_h_, first_c_, all_, last_h_, last_c_;
};

/// Of one picture or one line. For a line the first of the two dimensions is 1.
struct ConvShape {
  std::size_t channels = 0, outputs = 0, groups = 1;
  std::array<std::size_t, 2> in{1, 1}, kernel{1, 1}, out{1, 1}, stride{1, 1}, dilation{1, 1}, pad{0, 0};
  std::size_t patch() const { return channels / groups * kernel[0] * kernel[1]; }
};

class ConvOperation final : public Operation {
 public:
  ConvOperation(const Kernels& k, const ConvShape& shape, std::vector<Weights> groups, Place x, Place y);
  void run(float* memory) noexcept override;
  void places(const std::function<void(Place&)>& each) override { each(x_), each(y_); }

 private:
  void gather(const float* x, std::size_t group, std::size_t row, std::size_t column) noexcept;

  const Kernels& kernels_;
  ConvShape shape_;
  std::vector<Weights> groups_;
  AlignedFloats patch_, result_;
  Place x_, y_;
};

}  // namespace sinew::onnx
