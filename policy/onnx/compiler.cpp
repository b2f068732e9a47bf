#include "policy/onnx/compiler.hpp"

#include <algorithm>

#include "math/elementary.hpp"

namespace sinew::onnx {
namespace {

constexpr std::size_t kMostIntegers = 4 << 20;

}  // namespace

std::vector<std::size_t> strides_of(const Dims& dims) {
  std::vector<std::size_t> strides(dims.size(), 1);
  for (std::size_t i = dims.size(); i-- > 1;) strides[i - 1] = strides[i] * static_cast<std::size_t>(dims[i]);
  return strides;
}

std::optional<Dims> broadcast_dims(const Dims& a, const Dims& b) {
  Dims out(std::max(a.size(), b.size()), 1);
  for (std::size_t i = 0; i < out.size(); ++i) {
    const std::int64_t x = i < a.size() ? a[a.size() - 1 - i] : 1, y = i < b.size() ? b[b.size() - 1 - i] : 1;
    if (x != y && x != 1 && y != 1) return std::nullopt;
    out[out.size() - 1 - i] = x == 1 ? y : x;
  }
  return out;
}

std::vector<std::uint32_t> broadcast_indices(const Dims& dims, const Dims& to) {
  const auto strides = strides_of(dims);
  std::vector<std::size_t> step(to.size(), 0), at(to.size(), 0);
  for (std::size_t i = 0; i < dims.size(); ++i)
    if (dims[i] != 1) step[to.size() - dims.size() + i] = strides[i];
  std::vector<std::uint32_t> from(static_cast<std::size_t>(count_of(to)));
  std::size_t index = 0;
  for (std::uint32_t& f : from) {
    f = static_cast<std::uint32_t>(index);
    for (std::size_t i = to.size(); i-- > 0;) {
      index += step[i];
      if (++at[i] < static_cast<std::size_t>(to[i])) break;
      index -= step[i] * at[i];
      at[i] = 0;
    }
  }
  return from;
}

bool Compiler::fail(const Node& node, const std::string& why) {
  if (problems_.size() < kMostProblems) problems_.push_back(node.title() + ": " + why);
  return false;
}

bool Compiler::float_in(const Node& node, std::size_t i) {
  if (!has(node, i)) return fail(node, "input " + std::to_string(i + 1) + " is missing");
  return in(node, i).is_float || fail(node, "'" + printable(node.inputs[i]) + "' holds integers; float is supported");
}

bool Compiler::want_inputs(const Node& node, std::size_t least, std::size_t most) {
  for (std::size_t i = 0; i < least; ++i)
    if (!has(node, i)) return fail(node, "input " + std::to_string(i + 1) + " is missing");
  return node.inputs.size() <= most ||
         fail(node, "has " + std::to_string(node.inputs.size()) + " inputs; " + std::to_string(most) + " are known");
}

std::optional<std::vector<std::int64_t>> Compiler::integers(const Node& node, std::size_t i) {
  if (has(node, i) && !in(node, i).is_float) return in(node, i).ints;
  fail(node, "input " + std::to_string(i + 1) + " must be constant integers");
  return std::nullopt;
}

std::optional<float> Compiler::scalar(const Node& node, std::size_t i, float otherwise) {
  if (!has(node, i)) return otherwise;
  const Value& v = in(node, i);
  if (v.is_float && v.is_constant && v.place.count == 1) return floats(v)[0];
  if (!v.is_float && v.ints.size() == 1) return static_cast<float>(v.ints[0]);
  fail(node, "'" + printable(node.inputs[i]) + "' must be one constant number");
  return std::nullopt;
}

std::optional<std::size_t> Compiler::axis_of(const Node& node, std::int64_t axis, std::size_t rank) {
  const auto n = static_cast<std::int64_t>(rank);
  if (axis >= -n && axis < n) return static_cast<std::size_t>(axis < 0 ? axis + n : axis);
  fail(node, "axis " + std::to_string(axis) + " of " + std::to_string(rank) + " dimensions");
  return std::nullopt;
}

std::optional<Place> Compiler::room(const Node& node, const Dims& dims) {
  const std::int64_t count = count_of(dims);
  if (count <= 0 || dims.size() > kMostRank) {
    fail(node, "makes the shape " + text_of(dims) + "; at least 1 and at most " + std::to_string(kMostElements) +
                   " elements and " + std::to_string(kMostRank) + " dimensions are supported");
    return std::nullopt;
  }
  const Place place{static_cast<std::uint32_t>(memory_.size()), static_cast<std::uint32_t>(count)};
  if (memory_.size() + place.count > kMostMemory) {
    fail(node, "all values together have more than " + std::to_string(kMostMemory) + " numbers");
    return std::nullopt;
  }
  memory_.resize(memory_.size() + place.count + 2 * kBehind);
  return place;
}

bool Compiler::define(const Node& node, std::size_t output, Value value) {
  if (output >= node.outputs.size() || node.outputs[output].empty()) return true;
  integers_ += value.ints.size();
  if (integers_ > kMostIntegers)
    return fail(node, "shapes and indices together have more than " + std::to_string(kMostIntegers) + " integers");
  if (values_.contains(node.outputs[output]))
    return fail(node, "makes '" + printable(node.outputs[output]) + "', which exists already");
  values_.emplace(node.outputs[output], std::move(value));
  return true;
}

bool Compiler::alias(const Node& node, const Value& of, Dims dims) {
  if (count_of(dims) != static_cast<std::int64_t>(of.count()) || dims.size() > kMostRank)
    return fail(node, "cannot make " + text_of(dims) + " of " + text_of(of.dims));
  Value value = of;
  value.dims = std::move(dims);
  return define(node, 0, std::move(value));
}

void Compiler::emit(std::unique_ptr<Operation> op, bool is_constant) {
  if (is_constant)
    op->run(memory_.data());
  else
    operations_.push_back(std::move(op));
}

bool Compiler::unary(const Node& node, Unary op, float a, float b) {
  if (!want_inputs(node, 1, 3) || !float_in(node, 0)) return false;
  const Value x = in(node, 0);
  const auto place = room(node, x.dims);
  if (!place) return false;
  emit(std::make_unique<UnaryOperation>(kernels_, op, a, b, x.place, *place), x.is_constant);
  return define(node, 0, {x.dims, x.is_constant, true, *place});
}

bool Compiler::binary(const Node& node, Binary op) {
  if (!want_inputs(node, 2, 2)) return false;
  const Value &a = in(node, 0), &b = in(node, 1);
  if (a.is_float != b.is_float) return fail(node, "mixes integers and float");
  const auto dims = broadcast_dims(a.dims, b.dims);
  if (!dims) return fail(node, "the shapes " + text_of(a.dims) + " and " + text_of(b.dims) + " do not fit each other");
  const auto x = expanded(node, a, *dims), y = x ? expanded(node, b, *dims) : std::nullopt;
  if (!y) return false;
  if (!x->is_float) {
    Value out = *x;
    for (std::size_t i = 0; i < out.ints.size(); ++i) {
      const auto p = static_cast<std::uint64_t>(x->ints[i]), q = static_cast<std::uint64_t>(y->ints[i]);
      const std::int64_t s = x->ints[i], t = y->ints[i];
      if (op == Binary::div && (t == 0 || t == -1)) return fail(node, "divides an integer by " + std::to_string(t));
      if (op == Binary::add) out.ints[i] = static_cast<std::int64_t>(p + q);
      if (op == Binary::sub) out.ints[i] = static_cast<std::int64_t>(p - q);
      if (op == Binary::mul) out.ints[i] = static_cast<std::int64_t>(p * q);
      if (op == Binary::div) out.ints[i] = s / t;
      if (op == Binary::min) out.ints[i] = std::min(s, t);
      if (op == Binary::max) out.ints[i] = std::max(s, t);
    }
    return define(node, 0, std::move(out));
  }
  const auto place = room(node, *dims);
  if (!place) return false;
  const bool is_constant = x->is_constant && y->is_constant;
  emit(std::make_unique<BinaryOperation>(kernels_, op, x->place, y->place, *place), is_constant);
  return define(node, 0, {*dims, is_constant, true, *place});
}

std::optional<Compiler::Value> Compiler::moved(const Node& node, const Value& value, Dims dims,
                                               std::vector<std::uint32_t> from) {
  if (!value.is_float) {
    Value out{std::move(dims), true, false, {}};
    for (const std::uint32_t f : from) out.ints.push_back(value.ints[f]);
    return out;
  }
  const auto place = room(node, dims);
  if (!place) return std::nullopt;
  emit(std::make_unique<MoveOperation>(std::move(from), value.place, *place), value.is_constant);
  return Value{std::move(dims), value.is_constant, true, *place};
}

bool Compiler::move(const Node& node, const Value& value, Dims dims, std::vector<std::uint32_t> from,
                    std::size_t output) {
  auto made = moved(node, value, std::move(dims), std::move(from));
  return made && define(node, output, std::move(*made));
}

std::optional<Compiler::Value> Compiler::expanded(const Node& node, const Value& value, const Dims& to) {
  if (value.dims == to) return value;
  if (count_of(to) < 0) {
    fail(node, "makes the shape " + text_of(to) + ", which is too large");
    return std::nullopt;
  }
  if (static_cast<std::int64_t>(value.count()) == count_of(to)) {  // ones in front
    Value same = value;
    same.dims = to;
    return same;
  }
  return moved(node, value, to, broadcast_indices(value.dims, to));
}

bool Compiler::count_multiplications(const Node& node, std::uint64_t more) {
  multiplications_ += more;
  return multiplications_ <= kMostMultiplications ||
         fail(node, "a run would take more than " + std::to_string(kMostMultiplications) + " multiplications");
}

bool Compiler::dense(const Node& node, Weights weights, std::size_t rows, const Value& x, Dims dims) {
  if (!count_multiplications(node, std::uint64_t{rows} * weights.inputs() * weights.outputs())) return false;
  const auto place = room(node, dims);
  if (!place) return false;
  emit(std::make_unique<DenseOperation>(kernels_, std::move(weights), rows, x.place, *place), x.is_constant);
  return define(node, 0, {std::move(dims), x.is_constant, true, *place});
}

bool Compiler::add_constant(const std::string& name, const Tensor& t) {
  Node whole;  // for its words only
  whole.name = printable(name);
  whole.op = "weights";
  Value value{t.dims, true, t.is_float, {}};
  if (t.is_float) {
    const auto place = room(whole, t.dims);
    if (!place) return false;
    std::copy(t.floats.begin(), t.floats.end(), memory_.begin() + place->offset);
    value.place = *place;
  } else {
    value.ints = t.ints;
  }
  return values_.emplace(name, std::move(value)).second;
}

void Compiler::add_inputs() {
  for (const GraphPort& port : model_.inputs) {
    if (values_.contains(port.name)) continue;  // older files list weights among the inputs
    Node whole;
    whole.name = printable(port.name);
    whole.op = "input";
    if (port.type != static_cast<std::uint64_t>(ElementType::f32)) {
      fail(whole, "is of " + element_type_name(port.type) + "; float is supported");
    } else if (!port.has_shape) {
      fail(whole, "has no shape");
    } else {
      Dims dims = port.dims;
      for (std::int64_t& d : dims) d = d < 0 ? 1 : d;
      if (const auto place = room(whole, dims)) {
        values_.emplace(port.name, Value{dims, false, true, *place});
        inputs_.push_back({port.name, dims, *place});
        continue;
      }
    }
    lost_[port.name] = true;
  }
}

void Compiler::add_node(const Node& node) {
  const auto lose = [&] {
    for (const std::string& output : node.outputs) lost_[output] = true;
  };
  const auto known = operators();
  const auto found = std::find_if(known.begin(), known.end(), [&](const Operator& o) { return o.name == node.op; });
  if (found == known.end() || !(node.domain.empty() || node.domain == "ai.onnx")) {
    std::string all;
    for (const Operator& o : known) all += " " + std::string(o.name);
    const std::string op = node.domain.empty() ? node.op : node.domain + "." + node.op;
    const bool told = std::any_of(problems_.begin(), problems_.end(),
                                  [](const std::string& p) { return p.find("supported are") != std::string::npos; });
    fail(node, "operator " + op + " is not supported" + (told ? "" : "; supported are" + all));
    return lose();
  }
  for (const std::string& input : node.inputs) {
    if (input.empty() || values_.contains(input)) continue;
    if (!lost_.contains(input)) fail(node, "reads '" + printable(input) + "', which nothing before it makes");
    return lose();
  }
  if (!(this->*found->handler)(node)) lose();
}

bool Compiler::add_outputs(LoadedNetwork& out) {
  for (const GraphPort& port : model_.outputs) {
    const auto found = values_.find(port.name);
    if (found == values_.end() || !found->second.is_float) {
      if (!lost_.contains(port.name))
        out.problems.push_back("output '" + printable(port.name) + "': nothing makes it as float");
      continue;
    }
    const Value& value = found->second;
    outputs_.push_back({port.name, value.dims, value.place});
  }
  return out.problems.empty();
}

/// Leaves out what was needed while loading only. Values that are views of one place stay views.
void Compiler::move_together(Network& network) {
  std::map<std::uint32_t, std::uint32_t> count;  // by old offset
  const auto see = [&](const Place& p) { count[p.offset] = std::max(count[p.offset], p.count); };
  const auto all = [&](const std::function<void(Place&)>& each) {
    for (auto& op : operations_) op->places(each);
    for (auto* ports : {&inputs_, &outputs_})
      for (Network::Port& port : *ports) each(port.place);
  };
  all(see);
  std::map<std::uint32_t, std::uint32_t> moved_to;
  std::uint32_t size = 0;
  for (const auto& [offset, numbers] : count) {
    moved_to[offset] = size;
    size += static_cast<std::uint32_t>(Weights::padded(numbers) + 2 * kBehind);
  }
  network.memory_ = AlignedFloats(size);
  for (const auto& [offset, numbers] : count)
    std::copy_n(memory_.begin() + offset, numbers, network.memory_.data() + moved_to[offset]);
  all([&](Place& p) { p.offset = moved_to[p.offset]; });
  network.operations_ = std::move(operations_);
  network.inputs_ = std::move(inputs_);
  network.outputs_ = std::move(outputs_);
  network.multiplications_ = multiplications_;
  network.kernels_ = &kernels_;
}

LoadedNetwork Compiler::compile() {
  LoadedNetwork out;
  if (model_.opset < kFirstOpset || model_.opset > kLastOpset) {
    out.problems.push_back("opset " + std::to_string(model_.opset) + "; " + std::to_string(kFirstOpset) + " to " +
                           std::to_string(kLastOpset) + " are supported");
    return out;
  }
  for (const Tensor& t : model_.constants)
    if (!add_constant(t.name, t)) lost_[t.name] = true;
  add_inputs();
  for (const Node& node : model_.nodes) add_node(node);
  out.problems = std::move(problems_);
  if (!add_outputs(out)) return out;
  if (inputs_.empty() || outputs_.empty()) {
    out.problems.push_back(inputs_.empty() ? "it has no input" : "it has no output");
    return out;
  }
  out.network = std::make_unique<Network>();
  move_together(*out.network);
  return out;
}

LoadedNetwork Network::load(Bytes file, const NetworkOptions& options) {
  LoadedNetwork out;
  Model model;
  std::string problem;
  if (!read_model(file, model, problem)) {
    out.problems.push_back(std::move(problem));
    return out;
  }
  return Compiler(model, options.kernels ? *options.kernels : best_kernels()).compile();
}

int Network::find(const std::vector<Port>& ports, std::string_view name) {
  for (std::size_t i = 0; i < ports.size(); ++i)
    if (ports[i].name == name) return static_cast<int>(i);
  return -1;
}

void Network::run() noexcept {
  for (const auto& op : operations_) op->run(memory_.data());
  for (const Port& port : outputs_) {
    float* y = memory_.data() + port.place.offset;
    kernels_->unary(Unary::canonical, y, y, port.size(), 0, 0);
  }
}

std::vector<std::string> supported_operators() {
  std::vector<std::string> names;
  for (const Compiler::Operator& o : Compiler::operators()) names.emplace_back(o.name);
  return names;
}

}  // namespace sinew::onnx
