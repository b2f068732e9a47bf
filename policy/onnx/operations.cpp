#include "policy/onnx/operations.hpp"

#include <cstring>

#include "math/elementary.hpp"

namespace sinew::onnx {
namespace {

/// Four sums, added in pairs: one order, and none waits for the one before.
template <class Of>
double sum_of(std::size_t n, Of&& of) {
  double sums[4] = {};
  for (std::size_t i = 0; i < n; ++i) sums[i % 4] += of(i);
  return (sums[0] + sums[1]) + (sums[2] + sums[3]);
}

void copy(float* to, const float* from, std::size_t count) { std::memmove(to, from, count * sizeof(float)); }

}  // namespace

void DenseOperation::run(float* memory) noexcept {
  const std::size_t in = weights_.inputs(), out = weights_.outputs();
  for (std::size_t row = 0; row < rows_; ++row)
    weights_.run(kernels_, memory + x_.offset + row * in, memory + y_.offset + row * out);
}

void UnaryOperation::run(float* memory) noexcept {
  kernels_.unary(op_, memory + x_.offset, memory + y_.offset, y_.count, a_, b_);
}

void BinaryOperation::run(float* memory) noexcept {
  kernels_.binary(op_, memory + a_.offset, memory + b_.offset, memory + y_.offset, y_.count);
}

void MoveOperation::run(float* memory) noexcept {
  const float* x = memory + x_.offset;
  float* y = memory + y_.offset;
  for (std::size_t i = 0; i < from_.size(); ++i) y[i] = x[from_[i]];
}

void BlockOperation::run(float* memory) noexcept {
  for (std::size_t i = 0; i < blocks_; ++i)
    copy(memory + y_.offset + first_ + i * stride_, memory + x_.offset + i * size_, size_);
}

void RowOperation::run(float* memory) noexcept {
  for (std::size_t row = 0; row < rows_; ++row) {
    const float* x = memory + x_.offset + row * size_;
    if (kind_ == Kind::mean) {
      const double sum = sum_of(size_, [x](std::size_t i) { return double{x[i]}; });
      memory[y_.offset + row] = static_cast<float>(sum / static_cast<double>(size_));
      continue;
    }
    float most = x[0];
    for (std::size_t i = 1; i < size_; ++i) most = x[i] > most ? x[i] : most;
    float* e = row_.data();
    for (std::size_t i = 0; i < size_; ++i) e[i] = x[i] - most;
    kernels_.unary(Unary::exp, e, e, size_, 0, 0);
    const auto sum = static_cast<float>(sum_of(size_, [e](std::size_t i) { return double{e[i]}; }));
    for (std::size_t i = 0; i < size_; ++i) memory[y_.offset + row * size_ + i] = e[i] / sum;
  }
}

void LayerNormOperation::run(float* memory) noexcept {
  const float *scale = memory + scale_.offset, *bias = memory + bias_.offset;
  const auto n = static_cast<double>(size_);
  for (std::size_t row = 0; row < rows_; ++row) {
    const float* x = memory + x_.offset + row * size_;
    float* y = memory + y_.offset + row * size_;
    const double mean = sum_of(size_, [x](std::size_t i) { return double{x[i]}; }) / n;
    const double variance = sum_of(size_, [&](std::size_t i) { return (x[i] - mean) * (x[i] - mean); }) / n;
    const double factor = 1 / math::sqrt(variance + epsilon_);
    for (std::size_t i = 0; i < size_; ++i) y[i] = static_cast<float>((x[i] - mean) * factor) * scale[i] + bias[i];
  }
}

GruOperation::GruOperation(const Kernels& k, CellShape shape, bool linear, Weights input, Weights state,
                           Weights candidate, Place x, Place first, Place all, Place last)
    : kernels_(k),
      shape_(shape),
      linear_(linear),
      input_(std::move(input)),
      state_(std::move(state)),
      candidate_(std::move(candidate)),
      gates_x_(3 * shape.stride()),
      gates_h_(3 * shape.stride()),
      h_(shape.stride()),
      next_(shape.stride()),
      z_(shape.stride()),
      x_(x),
      first_(first),
      all_(all),
      last_(last) {}

void GruOperation::run(float* memory) noexcept {
  const std::size_t hidden = shape_.hidden, stride = shape_.stride();
  copy(h_.data(), memory + first_.offset, hidden);
  for (std::size_t step = 0; step < shape_.steps; ++step) {
    input_.run(kernels_, memory + x_.offset + step * input_.inputs(), gates_x_.data());
    state_.run(kernels_, h_.data(), gates_h_.data());
    const GruGates gates{gates_x_.data(), gates_h_.data(), stride, hidden, h_.data(), next_.data()};
    if (linear_) {
      kernels_.gru_linear(gates);
    } else {
      kernels_.gru_reset(gates, z_.data());
      candidate_.run(kernels_, next_.data(), gates_h_.data() + 2 * stride);
      kernels_.gru_finish(gates, z_.data());
    }
    copy(memory + all_.offset + step * hidden, next_.data(), hidden);
    std::swap(h_, next_);
  }
  copy(memory + last_.offset, h_.data(), hidden);
}

LstmOperation::LstmOperation(const Kernels& k, CellShape shape, Weights input, Weights state, Place x, Place first_h,
                             Place first_c, Place all, Place last_h, Place last_c)
    : kernels_(k),
      shape_(shape),
      input_(std::move(input)),
      state_(std::move(state)),
      gates_x_(4 * shape.stride()),
      gates_h_(4 * shape.stride()),
      h_(shape.stride()),
      c_(shape.stride()),
      next_h_(shape.stride()),
      next_c_(shape.stride()),
      x_(x),
      first_h_(first_h),
      first_c_(first_c),
      all_(all),
      last_h_(last_h),
      last_c_(last_c) {}

void LstmOperation::run(float* memory) noexcept {
  const std::size_t hidden = shape_.hidden;
  copy(h_.data(), memory + first_h_.offset, hidden);
  copy(c_.data(), memory + first_c_.offset, hidden);
  for (std::size_t step = 0; step < shape_.steps; ++step) {
    input_.run(kernels_, memory + x_.offset + step * input_.inputs(), gates_x_.data());
    state_.run(kernels_, h_.data(), gates_h_.data());
    kernels_.lstm(
        {gates_x_.data(), gates_h_.data(), shape_.stride(), hidden, c_.data(), next_c_.data(), next_h_.data()});
    copy(memory + all_.offset + step * hidden, next_h_.data(), hidden);
    std::swap(h_, next_h_);
    std::swap(c_, next_c_);
  }
  copy(memory + last_h_.offset, h_.data(), hidden);
  copy(memory + last_c_.offset, c_.data(), hidden);
}

ConvOperation::ConvOperation(const Kernels& k, const ConvShape& shape, std::vector<Weights> groups, Place x, Place y)
    : kernels_(k),
      shape_(shape),
      groups_(std::move(groups)),
      patch_(shape.patch()),
      result_(Weights::padded(shape.outputs / shape.groups)),
      x_(x),
      y_(y) {}

/// What the kernel sees at one place of the output: channel by channel, row by row.
void ConvOperation::gather(const float* x, std::size_t group, std::size_t row, std::size_t column) noexcept {
  const ConvShape& s = shape_;
  const std::size_t channels = s.channels / s.groups;
  float* out = patch_.data();
  for (std::size_t c = 0; c < channels; ++c) {
    const float* plane = x + (group * channels + c) * s.in[0] * s.in[1];
    for (std::size_t i = 0; i < s.kernel[0]; ++i) {
      const std::size_t r = row * s.stride[0] + i * s.dilation[0] - s.pad[0];  // below 0: wraps to a large number
      for (std::size_t j = 0; j < s.kernel[1]; ++j) {
        const std::size_t q = column * s.stride[1] + j * s.dilation[1] - s.pad[1];
        *out++ = r < s.in[0] && q < s.in[1] ? plane[r * s.in[1] + q] : 0.0f;
      }
    }
  }
}

void ConvOperation::run(float* memory) noexcept {
  const std::size_t each = shape_.outputs / shape_.groups, places = shape_.out[0] * shape_.out[1];
  for (std::size_t group = 0; group < shape_.groups; ++group)
    for (std::size_t row = 0; row < shape_.out[0]; ++row)
      for (std::size_t column = 0; column < shape_.out[1]; ++column) {
        gather(memory + x_.offset, group, row, column);
        groups_[group].run(kernels_, patch_.data(), result_.data());
        float* y = memory + y_.offset + group * each * places + row * shape_.out[1] + column;
        for (std::size_t m = 0; m < each; ++m) y[m * places] = result_.data()[m];
      }
}

}  // namespace sinew::onnx
