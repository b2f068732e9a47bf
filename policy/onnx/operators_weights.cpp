// Operators with weights: matrices, convolution, recurrent cells.
#include <algorithm>

#include "policy/onnx/compiler.hpp"

namespace sinew::onnx {
namespace {

float float_attribute(const Node& n, std::string_view name, float otherwise) {
  const Attribute* a = n.find(name);
  return a && a->has_float ? a->f : otherwise;
}
std::int64_t int_attribute(const Node& n, std::string_view name, std::int64_t otherwise) {
  const Attribute* a = n.find(name);
  return a && a->has_int ? a->i : otherwise;
}
std::size_t size_at(const Dims& dims, std::size_t i) { return static_cast<std::size_t>(dims[i]); }

}  // namespace

bool Compiler::gemm(const Node& n) {
  if (!want_inputs(n, 2, 3) || !float_in(n, 0) || !float_in(n, 1)) return false;
  Value a = in(n, 0);
  const Value& b = in(n, 1);
  if (a.dims.size() != 2 || b.dims.size() != 2)
    return fail(n, "the shapes " + text_of(a.dims) + " and " + text_of(b.dims) + "; two dimensions each are needed");
  if (!b.is_constant) return fail(n, "the second matrix must be constant (weights)");
  if (int_attribute(n, "transA", 0) != 0) {
    const Dims turned{a.dims[1], a.dims[0]};
    std::vector<std::uint32_t> from;
    for (std::size_t i = 0; i < size_at(turned, 0); ++i)
      for (std::size_t j = 0; j < size_at(turned, 1); ++j)
        from.push_back(static_cast<std::uint32_t>(j * size_at(turned, 0) + i));
    const auto made = moved(n, a, turned, std::move(from));
    if (!made) return false;
    a = *made;
  }
  const bool turned = int_attribute(n, "transB", 0) != 0;
  const std::size_t inputs = size_at(b.dims, turned ? 1 : 0), outputs = size_at(b.dims, turned ? 0 : 1);
  if (size_at(a.dims, 1) != inputs)
    return fail(n, "multiplies " + text_of(a.dims) + " by a matrix for " + std::to_string(inputs) + " inputs");
  const float alpha = float_attribute(n, "alpha", 1), beta = float_attribute(n, "beta", 1);
  Weights w(inputs, outputs);
  const auto numbers = floats(b);
  for (std::size_t i = 0; i < inputs; ++i)
    for (std::size_t o = 0; o < outputs; ++o) w.at(i, o) = alpha * numbers[turned ? o * inputs + i : i * outputs + o];
  const Dims dims{a.dims[0], static_cast<std::int64_t>(outputs)};
  if (!has(n, 2)) return dense(n, std::move(w), size_at(a.dims, 0), a, dims);
  if (!float_in(n, 2)) return false;
  const Value& c = in(n, 2);
  const Dims row{1, dims[1]};
  const auto fits = broadcast_dims(c.dims, row);
  if (!c.is_constant || !fits || *fits != row)
    return fail(n, "the bias " + text_of(c.dims) + " must be constant and the same for each row of " + text_of(dims));
  const auto from = broadcast_indices(c.dims, row);
  for (std::size_t o = 0; o < outputs; ++o) w.bias(o) = beta * floats(c)[from[o]];
  return dense(n, std::move(w), size_at(a.dims, 0), a, dims);
}

bool Compiler::mat_mul(const Node& n) {
  if (!want_inputs(n, 2, 2) || !float_in(n, 0) || !float_in(n, 1)) return false;
  const Value &a = in(n, 0), &b = in(n, 1);
  if (!b.is_constant || b.dims.size() != 2)
    return fail(n, "the second matrix must be constant (weights), of two dimensions; it is " + text_of(b.dims));
  const std::size_t inputs = size_at(b.dims, 0), outputs = size_at(b.dims, 1);
  if (a.dims.empty() || static_cast<std::size_t>(a.dims.back()) != inputs)
    return fail(n, "multiplies " + text_of(a.dims) + " by " + text_of(b.dims));
  Weights w(inputs, outputs);
  for (std::size_t i = 0; i < inputs; ++i)
    for (std::size_t o = 0; o < outputs; ++o) w.at(i, o) = floats(b)[i * outputs + o];
  Dims dims = a.dims;
  dims.back() = static_cast<std::int64_t>(outputs);
  return dense(n, std::move(w), a.count() / inputs, a, std::move(dims));
}

bool Compiler::conv_shape(const Node& n, ConvShape& s) {
  const Value &x = in(n, 0), &w = in(n, 1);
  const std::size_t rank = x.dims.size(), lines = rank - 2;
  if ((rank != 3 && rank != 4) || w.dims.size() != rank || x.dims[0] != 1)
    return fail(n, "the shapes " + text_of(x.dims) + " and " + text_of(w.dims) +
                       "; [1, channels, (rows,) columns] and weights of as many dimensions are supported");
  const std::int64_t groups = int_attribute(n, "group", 1);
  s.channels = size_at(x.dims, 1);
  s.outputs = size_at(w.dims, 0);
  if (groups < 1 || x.dims[1] % groups != 0 || w.dims[0] % groups != 0 || w.dims[1] != x.dims[1] / groups)
    return fail(n, "the weights " + text_of(w.dims) + " do not fit " + std::to_string(x.dims[1]) + " channels in " +
                       std::to_string(groups) + " groups");
  s.groups = static_cast<std::size_t>(groups);
  const auto list = [&](std::string_view name, std::int64_t otherwise, std::size_t count, Dims& out) {
    const Attribute* a = n.find(name);
    out = a && !a->ints.empty() ? a->ints : Dims(count, otherwise);
    return (out.size() == count &&
            std::all_of(out.begin(), out.end(), [&](auto v) { return v >= otherwise && v <= 4096; })) ||
           fail(n, std::string(name) + " " + text_of(out));
  };
  Dims strides, dilations, pads;
  if (!list("strides", 1, lines, strides) || !list("dilations", 1, lines, dilations) ||
      !list("pads", 0, 2 * lines, pads))
    return false;
  const Attribute* automatic = n.find("auto_pad");
  const std::string how = automatic ? automatic->s : "NOTSET";
  if (how != "NOTSET" && how != "" && how != "VALID" && how != "SAME_UPPER" && how != "SAME_LOWER")
    return fail(n, "auto_pad " + how);
  for (std::size_t i = 0; i < lines; ++i) {
    const std::size_t to = 2 - lines + i;
    const std::int64_t size = x.dims[2 + i], kernel = w.dims[2 + i], reach = (kernel - 1) * dilations[i] + 1;
    std::int64_t before = pads[i], after = pads[lines + i];
    if (how == "VALID") before = after = 0;
    if (how.starts_with("SAME")) {
      const std::int64_t made = (size + strides[i] - 1) / strides[i];
      const std::int64_t all = std::max<std::int64_t>(0, (made - 1) * strides[i] + reach - size);
      before = how == "SAME_UPPER" ? all / 2 : all - all / 2;
      after = all - before;
    }
    const std::int64_t left = size + before + after - reach;
    if (left < 0) return fail(n, "the kernel " + text_of(w.dims) + " is larger than its input " + text_of(x.dims));
    s.in[to] = size_at(x.dims, 2 + i);
    s.kernel[to] = size_at(w.dims, 2 + i);
    s.stride[to] = static_cast<std::size_t>(strides[i]);
    s.dilation[to] = static_cast<std::size_t>(dilations[i]);
    s.pad[to] = static_cast<std::size_t>(before);
    s.out[to] = static_cast<std::size_t>(left / strides[i] + 1);
  }
  return true;
}

bool Compiler::conv(const Node& n) {
  if (!want_inputs(n, 2, 3) || !float_in(n, 0) || !float_in(n, 1)) return false;
  const Value &x = in(n, 0), &w = in(n, 1);
  if (!w.is_constant || (has(n, 2) && !in(n, 2).is_constant)) return fail(n, "weights and bias must be constant");
  ConvShape s;
  if (!conv_shape(n, s)) return false;
  if (has(n, 2) && (!float_in(n, 2) || in(n, 2).count() != s.outputs))
    return fail(n, "the bias " + text_of(in(n, 2).dims) + "; one number for each of " + std::to_string(s.outputs) +
                       " outputs is needed");
  if (!count_multiplications(n, std::uint64_t{s.outputs} * s.out[0] * s.out[1] * s.patch())) return false;
  const std::size_t each = s.outputs / s.groups, patch = s.patch();
  std::vector<Weights> groups;
  for (std::size_t g = 0; g < s.groups; ++g) {
    Weights& packed = groups.emplace_back(patch, each);
    for (std::size_t m = 0; m < each; ++m) {
      for (std::size_t i = 0; i < patch; ++i) packed.at(i, m) = floats(w)[(g * each + m) * patch + i];
      if (has(n, 2)) packed.bias(m) = floats(in(n, 2))[g * each + m];
    }
  }
  Dims dims{1, static_cast<std::int64_t>(s.outputs)};
  if (x.dims.size() == 4) dims.push_back(static_cast<std::int64_t>(s.out[0]));
  dims.push_back(static_cast<std::int64_t>(s.out[1]));
  const bool is_constant = x.is_constant;
  const Place from = x.place;
  const auto place = room(n, dims);
  if (!place) return false;
  emit(std::make_unique<ConvOperation>(kernels_, s, std::move(groups), from, *place), is_constant);
  return define(n, 0, {dims, is_constant, true, *place});
}

bool Compiler::recurrent(const Node& n, std::size_t gates, CellShape& shape, std::size_t& inputs) {
  for (std::size_t i = 0; i < 3; ++i)
    if (!float_in(n, i)) return false;
  const Value &x = in(n, 0), &w = in(n, 1), &r = in(n, 2);
  const Attribute* direction = n.find("direction");
  if (direction && direction->s != "forward") return fail(n, "direction " + direction->s + "; forward is supported");
  if (n.find("clip") && n.find("clip")->f != 0) return fail(n, "clip is not supported");
  if (int_attribute(n, "layout", 0) != 0) return fail(n, "layout 1; 0 is supported");
  if (const Attribute* a = n.find("activations"); a && !a->strings.empty()) {
    std::vector<std::string> usual{"sigmoid", "tanh"};
    if (gates == 4) usual.push_back("tanh");
    std::vector<std::string> asked = a->strings;
    for (std::string& name : asked)
      for (char& c : name) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
    if (asked != usual) return fail(n, "activations other than Sigmoid and Tanh");
  }
  if (!w.is_constant || !r.is_constant) return fail(n, "its weights must be constant");
  if (x.dims.size() != 3 || x.dims[1] != 1)
    return fail(n, "the input " + text_of(x.dims) + "; [steps, 1, features] is supported");
  if (w.dims.size() != 3 || r.dims.size() != 3 || w.dims[0] != 1 || r.dims[0] != 1 || w.dims[2] != x.dims[2] ||
      w.dims[1] != r.dims[1] || r.dims[1] != static_cast<std::int64_t>(gates) * r.dims[2])
    return fail(
        n, "the weights " + text_of(w.dims) + " and " + text_of(r.dims) + " do not fit the input " + text_of(x.dims));
  shape.steps = size_at(x.dims, 0);
  shape.hidden = size_at(r.dims, 2);
  inputs = size_at(x.dims, 2);
  if (has(n, 3) && (!float_in(n, 3) || !in(n, 3).is_constant || in(n, 3).count() != 2 * gates * shape.hidden))
    return fail(n, "the bias " + text_of(in(n, 3).dims) + "; it must be constant, " +
                       std::to_string(2 * gates * shape.hidden) + " numbers");
  if (has(n, 4)) {
    const auto lengths = integers(n, 4);
    if (!lengths) return false;
    if (lengths->size() != 1 || (*lengths)[0] != x.dims[0]) return fail(n, "sequence_lens other than all steps");
  }
  return count_multiplications(n, std::uint64_t{shape.steps} * gates * shape.hidden * (inputs + shape.hidden));
}

/// Zeros where the node has none.
std::optional<Place> Compiler::first_state(const Node& n, std::size_t input, std::size_t hidden) {
  if (!has(n, input)) return room(n, {static_cast<std::int64_t>(hidden)});
  if (!float_in(n, input)) return std::nullopt;
  if (in(n, input).count() == hidden) return in(n, input).place;
  fail(n, "the initial state " + text_of(in(n, input).dims) + "; " + std::to_string(hidden) + " numbers are needed");
  return std::nullopt;
}

bool Compiler::gru(const Node& n) {
  CellShape shape;
  std::size_t inputs = 0;
  if (!want_inputs(n, 3, 6) || !recurrent(n, 3, shape, inputs)) return false;
  const bool linear = int_attribute(n, "linear_before_reset", 0) != 0;
  const std::size_t hidden = shape.hidden, stride = shape.stride();
  Weights input(inputs, 3 * stride), state(hidden, (linear ? 3 : 2) * stride), candidate;
  if (!linear) candidate = Weights(hidden, stride);
  const auto w = floats(in(n, 1)), r = floats(in(n, 2));
  const std::span<const float> b = has(n, 3) ? floats(in(n, 3)) : std::span<const float>();
  for (std::size_t gate = 0; gate < 3; ++gate)
    for (std::size_t j = 0; j < hidden; ++j) {
      const std::size_t row = gate * hidden + j, out = gate * stride + j;
      const bool apart = gate == 2 && !linear;
      Weights& of_state = apart ? candidate : state;
      const std::size_t state_out = apart ? j : out;
      for (std::size_t i = 0; i < inputs; ++i) input.at(i, out) = w[row * inputs + i];
      for (std::size_t i = 0; i < hidden; ++i) of_state.at(i, state_out) = r[row * hidden + i];
      if (b.empty()) continue;
      input.bias(out) = b[row];
      of_state.bias(state_out) = b[3 * hidden + row];
    }
  const Place x = in(n, 0).place;
  const bool is_constant = in(n, 0).is_constant && (!has(n, 5) || in(n, 5).is_constant);
  const auto size = static_cast<std::int64_t>(hidden);
  const Dims all{static_cast<std::int64_t>(shape.steps), 1, 1, size}, last{1, 1, size};
  const auto first = first_state(n, 5, hidden);
  const auto y = first ? room(n, all) : std::nullopt, y_h = y ? room(n, last) : std::nullopt;
  if (!y_h) return false;
  emit(std::make_unique<GruOperation>(kernels_, shape, linear, std::move(input), std::move(state), std::move(candidate),
                                      x, *first, *y, *y_h),
       is_constant);
  return define(n, 0, {all, is_constant, true, *y}) && define(n, 1, {last, is_constant, true, *y_h});
}

bool Compiler::lstm(const Node& n) {
  CellShape shape;
  std::size_t inputs = 0;
  if (!want_inputs(n, 3, 8) || !recurrent(n, 4, shape, inputs)) return false;
  if (has(n, 7)) return fail(n, "peepholes are not supported");
  if (int_attribute(n, "input_forget", 0) != 0) return fail(n, "input_forget is not supported");
  const std::size_t hidden = shape.hidden, stride = shape.stride();
  Weights input(inputs, 4 * stride), state(hidden, 4 * stride);
  const auto w = floats(in(n, 1)), r = floats(in(n, 2));
  const std::span<const float> b = has(n, 3) ? floats(in(n, 3)) : std::span<const float>();
  for (std::size_t gate = 0; gate < 4; ++gate)
    for (std::size_t j = 0; j < hidden; ++j) {
      const std::size_t row = gate * hidden + j, out = gate * stride + j;
      for (std::size_t i = 0; i < inputs; ++i) input.at(i, out) = w[row * inputs + i];
      for (std::size_t i = 0; i < hidden; ++i) state.at(i, out) = r[row * hidden + i];
      if (b.empty()) continue;
      input.bias(out) = b[row];
      state.bias(out) = b[4 * hidden + row];
    }
  const Place x = in(n, 0).place;
  bool is_constant = in(n, 0).is_constant;
  for (const std::size_t i : {5, 6}) is_constant &= !has(n, i) || in(n, i).is_constant;
  const auto size = static_cast<std::int64_t>(hidden);
  const Dims all{static_cast<std::int64_t>(shape.steps), 1, 1, size}, last{1, 1, size};
  const auto h = first_state(n, 5, hidden), c = h ? first_state(n, 6, hidden) : std::nullopt;
  const auto y = c ? room(n, all) : std::nullopt, y_h = y ? room(n, last) : std::nullopt,
             y_c = y_h ? room(n, last) : std::nullopt;
  if (!y_c) return false;
  emit(std::make_unique<LstmOperation>(kernels_, shape, std::move(input), std::move(state), x, *h, *c, *y, *y_h, *y_c),
       is_constant);
  return define(n, 0, {all, is_constant, true, *y}) && define(n, 1, {last, is_constant, true, *y_h}) &&
         define(n, 2, {last, is_constant, true, *y_c});
}

}  // namespace sinew::onnx
