// Operators that compute with each number, with rows, or only move numbers; and the table of all operators.
#include <algorithm>
#include <array>

#include "policy/onnx/compiler.hpp"

namespace sinew::onnx {
namespace {

std::int64_t integer_of(const Node& n, std::string_view name, std::int64_t otherwise) {
  const Attribute* a = n.find(name);
  return a && a->has_int ? a->i : otherwise;
}
std::size_t product(const Dims& dims, std::size_t from, std::size_t to) {
  std::size_t count = 1;
  for (std::size_t i = from; i < to; ++i) count *= static_cast<std::size_t>(dims[i]);
  return count;
}

/// Indices of all elements in another order of their axes: axis i of the result is axis order[i].
std::vector<std::uint32_t> turned(const Dims& dims, const std::vector<std::size_t>& order, Dims& out) {
  const auto strides = strides_of(dims);
  out.clear();
  for (const std::size_t axis : order) out.push_back(dims[axis]);
  std::vector<std::size_t> at(dims.size(), 0);
  std::vector<std::uint32_t> from(product(dims, 0, dims.size()));
  for (std::uint32_t& f : from) {
    std::size_t index = 0;
    for (std::size_t i = 0; i < order.size(); ++i) index += at[i] * strides[order[i]];
    f = static_cast<std::uint32_t>(index);
    for (std::size_t i = order.size(); i-- > 0;) {
      if (++at[i] < static_cast<std::size_t>(out[i])) break;
      at[i] = 0;
    }
  }
  return from;
}

}  // namespace

bool Compiler::elu(const Node& n) {
  const Attribute* a = n.find("alpha");
  return unary(n, Unary::elu, a && a->has_float ? a->f : 1.0f);
}
bool Compiler::leaky_relu(const Node& n) {
  const Attribute* a = n.find("alpha");
  return unary(n, Unary::leaky_relu, a && a->has_float ? a->f : 0.01f);
}

bool Compiler::clip(const Node& n) {
  constexpr float kAll = 3.4028235e38f;
  const Attribute *low = n.find("min"), *high = n.find("max");  // before opset 11
  const auto min = scalar(n, 1, low && low->has_float ? low->f : -kAll);
  const auto max = min ? scalar(n, 2, high && high->has_float ? high->f : kAll) : std::nullopt;
  return max && unary(n, Unary::clip, *min, *max);
}

bool Compiler::pow(const Node& n) {
  if (!want_inputs(n, 2, 2)) return false;
  const auto exponent = scalar(n, 1, 1);
  if (!exponent) return false;
  if (*exponent == 2.0f) return unary(n, Unary::square);
  if (*exponent == 0.5f) return unary(n, Unary::sqrt);
  if (*exponent == 1.0f) return alias(n, in(n, 0), in(n, 0).dims);
  return fail(n, "an exponent other than 0.5, 1 and 2");
}

bool Compiler::cast(const Node& n) {
  if (!want_inputs(n, 1, 1)) return false;
  const auto to = static_cast<std::uint64_t>(integer_of(n, "to", 0));
  const Value& x = in(n, 0);
  const bool to_float = to == static_cast<std::uint64_t>(ElementType::f32);
  const bool to_int =
      to == static_cast<std::uint64_t>(ElementType::i64) || to == static_cast<std::uint64_t>(ElementType::i32);
  if ((to_float && x.is_float) || (to_int && !x.is_float)) return alias(n, x, x.dims);
  if (!to_float || x.is_float)
    return fail(n, "to " + element_type_name(to) + "; only casts that change nothing are supported");
  const std::vector<std::int64_t> ints = x.ints;
  const Dims dims = x.dims;
  const auto place = room(n, dims);
  if (!place) return false;
  for (std::size_t i = 0; i < ints.size(); ++i) memory_[place->offset + i] = static_cast<float>(ints[i]);
  return define(n, 0, {dims, true, true, *place});
}

bool Compiler::identity(const Node& n) { return want_inputs(n, 1, 1) && alias(n, in(n, 0), in(n, 0).dims); }

bool Compiler::dropout(const Node& n) {
  if (!want_inputs(n, 1, 3)) return false;
  if (n.outputs.size() > 1 && !n.outputs[1].empty()) return fail(n, "its mask is not supported");
  return alias(n, in(n, 0), in(n, 0).dims);
}

bool Compiler::constant(const Node& n) {
  if (n.outputs.size() != 1) return fail(n, "must have one output");
  Tensor t;
  if (const Attribute* a = n.find("value"); a && a->has_tensor) {
    t = a->t;
  } else if (const Attribute* f = n.find("value_float")) {
    t.floats = {f->f};
  } else if (const Attribute* i = n.find("value_int")) {
    t.is_float = false;
    t.ints = {i->i};
  } else if (const Attribute* fs = n.find("value_floats")) {
    t.floats = fs->floats;
    t.dims = {static_cast<std::int64_t>(fs->floats.size())};
  } else if (const Attribute* is = n.find("value_ints")) {
    t.is_float = false;
    t.ints = is->ints;
    t.dims = {static_cast<std::int64_t>(is->ints.size())};
  } else {
    return fail(n, "has no value that is supported");
  }
  return !values_.contains(n.outputs[0]) ? add_constant(n.outputs[0], t) : fail(n, "makes what exists already");
}

bool Compiler::constant_of_shape(const Node& n) {
  const auto dims = integers(n, 0);
  if (!dims) return false;
  const std::int64_t count = dims->size() <= kMostRank ? count_of(*dims) : -1;
  if (count < 0) return fail(n, "makes the shape " + text_of(*dims) + ", which is too large");
  const Attribute* a = n.find("value");
  if (a && a->has_tensor && !a->t.is_float) {
    Value value{*dims, true, false, {}};
    value.ints.assign(static_cast<std::size_t>(count), a->t.ints.empty() ? 0 : a->t.ints[0]);
    return define(n, 0, std::move(value));
  }
  const auto place = room(n, *dims);
  if (!place) return false;
  const float v = a && !a->t.floats.empty() ? a->t.floats[0] : 0.0f;
  std::fill_n(memory_.begin() + place->offset, place->count, v);
  return define(n, 0, {*dims, true, true, *place});
}

bool Compiler::shape(const Node& n) {
  if (!want_inputs(n, 1, 1)) return false;
  const Dims& dims = in(n, 0).dims;
  const auto rank = static_cast<std::int64_t>(dims.size());
  const auto bound = [&](std::int64_t at) { return std::clamp<std::int64_t>(at < 0 ? at + rank : at, 0, rank); };
  const std::int64_t first = bound(integer_of(n, "start", 0)), last = bound(integer_of(n, "end", rank));
  Value value{{std::max<std::int64_t>(0, last - first)}, true, false, {}};
  for (std::int64_t i = first; i < last; ++i) value.ints.push_back(dims[static_cast<std::size_t>(i)]);
  return define(n, 0, std::move(value));
}

bool Compiler::reshape(const Node& n) {
  if (!want_inputs(n, 2, 2)) return false;
  auto dims = integers(n, 1);
  if (!dims) return false;
  const Value& x = in(n, 0);
  std::int64_t known = 1;
  std::size_t open = dims->size();
  for (std::size_t i = 0; i < dims->size(); ++i) {
    std::int64_t& d = (*dims)[i];
    if (d == 0 && integer_of(n, "allowzero", 0) == 0 && i < x.dims.size()) d = x.dims[i];
    if (d == -1 && open == dims->size())
      open = i;
    else if (d < 0 || d > kMostElements || (known *= d) > kMostElements)
      return fail(n, "cannot make " + text_of(*dims) + " of " + text_of(x.dims));
  }
  if (open < dims->size()) (*dims)[open] = known > 0 ? static_cast<std::int64_t>(x.count()) / known : 0;
  return alias(n, x, *dims);
}

bool Compiler::flatten(const Node& n) {
  if (!want_inputs(n, 1, 1)) return false;
  const Value& x = in(n, 0);
  const std::int64_t asked = integer_of(n, "axis", 1), rank = static_cast<std::int64_t>(x.dims.size());
  if (asked < -rank || asked > rank) return fail(n, "axis " + std::to_string(asked) + " of " + text_of(x.dims));
  const auto axis = static_cast<std::size_t>(asked < 0 ? asked + rank : asked);
  return alias(n, x,
               {static_cast<std::int64_t>(product(x.dims, 0, axis)),
                static_cast<std::int64_t>(product(x.dims, axis, x.dims.size()))});
}

/// The attribute (before opset 13 or 18), or the input. Nothing given: empty.
std::optional<std::vector<std::int64_t>> Compiler::axes_of(const Node& node, std::size_t input) {
  if (const Attribute* a = node.find("axes")) return a->ints;
  if (!has(node, input)) return std::vector<std::int64_t>{};
  return integers(node, input);
}

bool Compiler::squeeze(const Node& n) {
  if (!want_inputs(n, 1, 2)) return false;
  const Value& x = in(n, 0);
  const auto axes = axes_of(n, 1);
  if (!axes) return false;
  std::vector<bool> gone(x.dims.size(), axes->empty());
  for (const std::int64_t a : *axes) {
    const auto axis = axis_of(n, a, x.dims.size());
    if (!axis) return false;
    if (x.dims[*axis] != 1) return fail(n, "axis " + std::to_string(a) + " of " + text_of(x.dims) + " is not 1");
    gone[*axis] = true;
  }
  Dims dims;
  for (std::size_t i = 0; i < x.dims.size(); ++i)
    if (!gone[i] || x.dims[i] != 1) dims.push_back(x.dims[i]);
  return alias(n, x, std::move(dims));
}

bool Compiler::unsqueeze(const Node& n) {
  if (!want_inputs(n, 1, 2)) return false;
  const Value& x = in(n, 0);
  const auto axes = axes_of(n, 1);
  if (!axes) return false;
  const std::size_t rank = x.dims.size() + axes->size();
  if (rank > kMostRank) return fail(n, "more than " + std::to_string(kMostRank) + " dimensions");
  Dims dims(rank, 0);
  for (const std::int64_t a : *axes) {
    const auto axis = axis_of(n, a, rank);
    if (!axis) return false;
    if (dims[*axis] == 1) return fail(n, "axis " + std::to_string(a) + " twice");
    dims[*axis] = 1;
  }
  std::size_t next = 0;
  for (std::int64_t& d : dims)
    if (d == 0) d = x.dims[next++];
  return alias(n, x, std::move(dims));
}

bool Compiler::transpose(const Node& n) {
  if (!want_inputs(n, 1, 1)) return false;
  const Value x = in(n, 0);
  std::vector<std::size_t> order;
  if (const Attribute* a = n.find("perm")) {
    for (const std::int64_t p : a->ints) order.push_back(static_cast<std::size_t>(p));
  } else {
    for (std::size_t i = x.dims.size(); i-- > 0;) order.push_back(i);
  }
  std::vector<std::size_t> sorted = order;
  std::sort(sorted.begin(), sorted.end());
  bool good = order.size() == x.dims.size();
  for (std::size_t i = 0; good && i < sorted.size(); ++i) good = sorted[i] == i;
  if (!good) return fail(n, "perm does not name each axis of " + text_of(x.dims) + " once");
  Dims dims;
  auto from = turned(x.dims, order, dims);
  const bool is_view = std::is_sorted(from.begin(), from.end());
  return is_view ? alias(n, x, std::move(dims)) : move(n, x, std::move(dims), std::move(from));
}

bool Compiler::concat(const Node& n) {
  if (n.inputs.empty() || !want_inputs(n, n.inputs.size(), n.inputs.size())) return false;
  Value out = in(n, 0);
  const auto axis = axis_of(n, integer_of(n, "axis", 0), out.dims.size());
  if (!axis) return false;
  std::vector<Value> parts;
  out.dims[*axis] = 0;
  out.is_constant = true;
  for (std::size_t i = 0; i < n.inputs.size(); ++i) {
    const Value& part = in(n, i);
    Dims rest = part.dims;
    if (rest.size() == out.dims.size()) rest[*axis] = out.dims[*axis];
    if (rest != out.dims || part.is_float != out.is_float)
      return fail(n, "'" + printable(n.inputs[i]) + "' of " + text_of(part.dims) + " does not fit the others");
    out.dims[*axis] += part.dims[*axis];
    out.is_constant &= part.is_constant;
    parts.push_back(part);
  }
  const std::size_t rank = out.dims.size(), blocks = product(out.dims, 0, *axis);
  if (count_of(out.dims) < 0) return fail(n, "makes " + text_of(out.dims) + ", which is too large");
  const std::size_t stride = product(out.dims, *axis, rank);
  out.ints.assign(out.is_float ? 0 : blocks * stride, 0);
  if (out.is_float) {
    const auto place = room(n, out.dims);
    if (!place) return false;
    out.place = *place;
  }
  std::size_t first = 0;
  for (const Value& part : parts) {
    const std::size_t size = product(part.dims, *axis, rank);
    if (out.is_float) {
      emit(std::make_unique<BlockOperation>(blocks, size, stride, first, part.place, out.place), out.is_constant);
    } else {
      for (std::size_t b = 0; b < blocks; ++b)
        std::copy_n(part.ints.data() + b * size, size, out.ints.data() + b * stride + first);
    }
    first += size;
  }
  return define(n, 0, std::move(out));
}

bool Compiler::slice(const Node& n) {
  if (!want_inputs(n, 1, 5)) return false;
  const Value x = in(n, 0);
  std::vector<std::int64_t> starts, ends, axes, steps;
  if (const Attribute* s = n.find("starts")) {  // before opset 10
    starts = s->ints;
    if (n.find("ends")) ends = n.find("ends")->ints;
    if (n.find("axes")) axes = n.find("axes")->ints;
  } else {
    for (const auto& [i, target] : {std::pair{1, &starts}, {2, &ends}, {3, &axes}, {4, &steps}}) {
      const auto input = static_cast<std::size_t>(i);
      if (i > 2 && !has(n, input)) continue;
      const auto given = integers(n, input);
      if (!given) return false;
      *target = *given;
    }
  }
  if (axes.empty())
    for (std::size_t i = 0; i < starts.size(); ++i) axes.push_back(static_cast<std::int64_t>(i));
  if (steps.empty()) steps.assign(starts.size(), 1);
  if (ends.size() != starts.size() || axes.size() != starts.size() || steps.size() != starts.size())
    return fail(n, "starts, ends, axes and steps differ in number");
  std::vector<std::vector<std::size_t>> picked(x.dims.size());
  for (std::size_t i = 0; i < x.dims.size(); ++i)
    for (std::int64_t j = 0; j < x.dims[i]; ++j) picked[i].push_back(static_cast<std::size_t>(j));
  for (std::size_t i = 0; i < starts.size(); ++i) {
    const auto axis = axis_of(n, axes[i], x.dims.size());
    if (!axis) return false;
    const std::int64_t size = x.dims[*axis], step = steps[i];
    if (step == 0 || step > kMostElements || step < -kMostElements) return fail(n, "step " + std::to_string(step));
    const auto bound = [size](std::int64_t at, std::int64_t low, std::int64_t high) {
      return std::clamp(at < 0 ? at + size : at, low, high);
    };
    picked[*axis].clear();
    if (size == 0) continue;
    if (step > 0)
      for (std::int64_t j = bound(starts[i], 0, size); j < bound(ends[i], 0, size); j += step)
        picked[*axis].push_back(static_cast<std::size_t>(j));
    else
      for (std::int64_t j = bound(starts[i], 0, size - 1); j > bound(ends[i], -1, size - 1); j += step)
        picked[*axis].push_back(static_cast<std::size_t>(j));
  }
  Dims dims;
  for (const auto& p : picked) dims.push_back(static_cast<std::int64_t>(p.size()));
  const auto strides = strides_of(x.dims);
  std::vector<std::uint32_t> from{0};
  for (std::size_t i = 0; i < picked.size(); ++i) {
    std::vector<std::uint32_t> finer;
    for (const std::uint32_t f : from)
      for (const std::size_t p : picked[i]) finer.push_back(static_cast<std::uint32_t>(f + p * strides[i]));
    from = std::move(finer);
  }
  return move(n, x, std::move(dims), std::move(from));
}

bool Compiler::split(const Node& n) {
  if (!want_inputs(n, 1, 2)) return false;
  const Value x = in(n, 0);
  const auto axis = axis_of(n, integer_of(n, "axis", 0), x.dims.size());
  if (!axis) return false;
  const std::size_t outputs = n.outputs.size();
  std::vector<std::int64_t> sizes;
  if (const Attribute* a = n.find("split")) {  // before opset 13
    sizes = a->ints;
  } else if (has(n, 1)) {
    const auto given = integers(n, 1);
    if (!given) return false;
    sizes = *given;
  } else if (outputs > 0) {
    const auto parts = static_cast<std::int64_t>(outputs), each = (x.dims[*axis] + parts - 1) / parts;
    for (std::int64_t i = 0; i < parts; ++i) sizes.push_back(std::min(each, x.dims[*axis] - i * each));
  }
  std::int64_t sum = 0;
  for (const std::int64_t s : sizes) {
    if (s <= 0 || s > x.dims[*axis]) return fail(n, "parts of " + text_of(sizes) + " of " + text_of(x.dims));
    sum += s;
  }
  if (sizes.size() != outputs || sum != x.dims[*axis])
    return fail(n, "parts of " + text_of(sizes) + " of " + text_of(x.dims));
  const std::size_t blocks = product(x.dims, 0, *axis), inner = product(x.dims, *axis + 1, x.dims.size());
  const std::size_t stride = inner * static_cast<std::size_t>(x.dims[*axis]);
  std::size_t first = 0;
  for (std::size_t o = 0; o < outputs; ++o) {
    Dims dims = x.dims;
    dims[*axis] = sizes[o];
    const std::size_t size = inner * static_cast<std::size_t>(sizes[o]);
    std::vector<std::uint32_t> from;
    for (std::size_t b = 0; b < blocks; ++b)
      for (std::size_t i = 0; i < size; ++i) from.push_back(static_cast<std::uint32_t>(b * stride + first + i));
    if (!move(n, x, std::move(dims), std::move(from), o)) return false;
    first += size;
  }
  return true;
}

bool Compiler::gather(const Node& n) {
  if (!want_inputs(n, 2, 2)) return false;
  const Value x = in(n, 0);
  const auto indices = integers(n, 1);
  const auto axis = indices ? axis_of(n, integer_of(n, "axis", 0), x.dims.size()) : std::nullopt;
  if (!axis) return false;
  const Dims& picked = in(n, 1).dims;
  Dims dims(x.dims.begin(), x.dims.begin() + static_cast<std::ptrdiff_t>(*axis));
  dims.insert(dims.end(), picked.begin(), picked.end());
  dims.insert(dims.end(), x.dims.begin() + static_cast<std::ptrdiff_t>(*axis) + 1, x.dims.end());
  if (dims.size() > kMostRank || count_of(dims) < 0) return fail(n, "makes " + text_of(dims) + ", which is too large");
  const std::size_t blocks = product(x.dims, 0, *axis), inner = product(x.dims, *axis + 1, x.dims.size());
  const auto size = x.dims[*axis];
  std::vector<std::uint32_t> from;
  for (std::size_t b = 0; b < blocks; ++b)
    for (const std::int64_t i : *indices) {
      if (i < -size || i >= size) return fail(n, "index " + std::to_string(i) + " of " + std::to_string(size));
      const auto row = b * static_cast<std::size_t>(size) + static_cast<std::size_t>(i < 0 ? i + size : i);
      for (std::size_t j = 0; j < inner; ++j) from.push_back(static_cast<std::uint32_t>(row * inner + j));
    }
  return move(n, x, std::move(dims), std::move(from));
}

bool Compiler::expand(const Node& n) {
  if (!want_inputs(n, 2, 2)) return false;
  const auto asked = integers(n, 1);
  if (!asked) return false;
  const Value x = in(n, 0);
  const auto dims = asked->size() <= kMostRank ? broadcast_dims(x.dims, *asked) : std::nullopt;
  if (!dims || count_of(*dims) < 0) return fail(n, "cannot make " + text_of(*asked) + " of " + text_of(x.dims));
  auto value = expanded(n, x, *dims);
  return value && define(n, 0, std::move(*value));
}

bool Compiler::softmax(const Node& n) {
  if (!want_inputs(n, 1, 1) || !float_in(n, 0)) return false;
  const Value x = in(n, 0);
  const bool flat = model_.opset < 13;  // then all axes from `axis` on are one
  const auto axis = axis_of(n, integer_of(n, "axis", flat ? 1 : -1), x.dims.size());
  if (!axis) return false;
  const std::size_t inner = product(x.dims, *axis + 1, x.dims.size());
  if (!flat && inner != 1) return fail(n, "over an axis that is not the last");
  const std::size_t size = flat ? product(x.dims, *axis, x.dims.size()) : static_cast<std::size_t>(x.dims[*axis]);
  const auto place = room(n, x.dims);
  if (!place) return false;
  emit(std::make_unique<RowOperation>(kernels_, RowOperation::Kind::softmax, x.count() / size, size, x.place, *place),
       x.is_constant);
  return define(n, 0, {x.dims, x.is_constant, true, *place});
}

bool Compiler::reduce_mean(const Node& n) {
  if (!want_inputs(n, 1, 2) || !float_in(n, 0)) return false;
  Value x = in(n, 0);
  const auto axes = axes_of(n, 1);
  if (!axes) return false;
  if (axes->empty() && integer_of(n, "noop_with_empty_axes", 0) != 0) return alias(n, x, x.dims);
  std::vector<bool> reduced(x.dims.size(), axes->empty());
  for (const std::int64_t a : *axes) {
    const auto axis = axis_of(n, a, x.dims.size());
    if (!axis) return false;
    reduced[*axis] = true;
  }
  std::vector<std::size_t> order;
  Dims dims;
  std::size_t size = 1;
  for (std::size_t i = 0; i < x.dims.size(); ++i)
    if (!reduced[i]) order.push_back(i);
  for (std::size_t i = 0; i < x.dims.size(); ++i) {
    if (reduced[i]) order.push_back(i), size *= static_cast<std::size_t>(x.dims[i]);
    if (!reduced[i] || integer_of(n, "keepdims", 1) != 0) dims.push_back(reduced[i] ? 1 : x.dims[i]);
  }
  if (!std::is_sorted(order.begin(), order.end())) {
    Dims out;
    auto from = turned(x.dims, order, out);
    const auto made = moved(n, x, out, std::move(from));
    if (!made) return false;
    x = *made;
  }
  const auto place = room(n, dims);
  if (!place) return false;
  emit(std::make_unique<RowOperation>(kernels_, RowOperation::Kind::mean, x.count() / size, size, x.place, *place),
       x.is_constant);
  return define(n, 0, {dims, x.is_constant, true, *place});
}

bool Compiler::layer_normalization(const Node& n) {
  if (!want_inputs(n, 2, 3) || !float_in(n, 0) || !float_in(n, 1)) return false;
  for (std::size_t i = 1; i < n.outputs.size(); ++i)
    if (!n.outputs[i].empty()) return fail(n, "its mean and deviation as outputs are not supported");
  const Value x = in(n, 0), scale = in(n, 1);
  const auto axis = axis_of(n, integer_of(n, "axis", -1), x.dims.size());
  if (!axis) return false;
  const std::size_t size = product(x.dims, *axis, x.dims.size());
  if (has(n, 2) && !float_in(n, 2)) return false;
  if (scale.count() != size || (has(n, 2) && in(n, 2).count() != size))
    return fail(n, "scale and bias must have " + std::to_string(size) + " numbers");
  const auto bias = has(n, 2) ? std::optional(in(n, 2).place) : room(n, {static_cast<std::int64_t>(size)});
  const auto place = bias ? room(n, x.dims) : std::nullopt;
  if (!place) return false;
  const bool is_constant = x.is_constant && scale.is_constant && (!has(n, 2) || in(n, 2).is_constant);
  const Attribute* e = n.find("epsilon");
  emit(std::make_unique<LayerNormOperation>(x.count() / size, size, e && e->has_float ? e->f : 1e-5f, x.place,
                                            scale.place, *bias, *place),
       is_constant);
  return define(n, 0, {x.dims, is_constant, true, *place});
}

std::span<const Compiler::Operator> Compiler::operators() {
  static constexpr std::array kAll{
      Operator{"Abs", &Compiler::abs},
      Operator{"Add", &Compiler::add},
      Operator{"Cast", &Compiler::cast},
      Operator{"Clip", &Compiler::clip},
      Operator{"Concat", &Compiler::concat},
      Operator{"Constant", &Compiler::constant},
      Operator{"ConstantOfShape", &Compiler::constant_of_shape},
      Operator{"Conv", &Compiler::conv},
      Operator{"Div", &Compiler::div},
      Operator{"Dropout", &Compiler::dropout},
      Operator{"Elu", &Compiler::elu},
      Operator{"Expand", &Compiler::expand},
      Operator{"Flatten", &Compiler::flatten},
      Operator{"GRU", &Compiler::gru},
      Operator{"Gather", &Compiler::gather},
      Operator{"Gemm", &Compiler::gemm},
      Operator{"Identity", &Compiler::identity},
      Operator{"LSTM", &Compiler::lstm},
      Operator{"LayerNormalization", &Compiler::layer_normalization},
      Operator{"LeakyRelu", &Compiler::leaky_relu},
      Operator{"MatMul", &Compiler::mat_mul},
      Operator{"Max", &Compiler::max},
      Operator{"Min", &Compiler::min},
      Operator{"Mul", &Compiler::mul},
      Operator{"Neg", &Compiler::neg},
      Operator{"Pow", &Compiler::pow},
      Operator{"ReduceMean", &Compiler::reduce_mean},
      Operator{"Relu", &Compiler::relu},
      Operator{"Reshape", &Compiler::reshape},
      Operator{"Shape", &Compiler::shape},
      Operator{"Sigmoid", &Compiler::sigmoid},
      Operator{"Slice", &Compiler::slice},
      Operator{"Softmax", &Compiler::softmax},
      Operator{"Split", &Compiler::split},
      Operator{"Sqrt", &Compiler::sqrt},
      Operator{"Squeeze", &Compiler::squeeze},
      Operator{"Sub", &Compiler::sub},
      Operator{"Tanh", &Compiler::tanh},
      Operator{"Transpose", &Compiler::transpose},
      Operator{"Unsqueeze", &Compiler::unsqueeze},
  };
  return kAll;
}

}  // namespace sinew::onnx
