#include "policy/onnx/model.hpp"

#include <algorithm>
#include <array>

namespace sinew::onnx {
namespace {

using Type = PbField::Type;

constexpr std::size_t kMostNames = 256, kMostAttributes = 64;  // of a node

struct ModelReader {
  Model& model;
  std::string& problem;

  bool fail(std::string why) {
    if (problem.empty()) problem = std::move(why);
    return false;
  }
  bool cut_off(std::string_view what) {
    return fail("no ONNX file, or a damaged one: " + std::string(what) + " cannot be read");
  }

  bool file(Bytes bytes);
  bool opset(Bytes bytes);
  bool graph(Bytes bytes);
  bool node(Bytes bytes);
  bool attribute(Bytes bytes, const Node& node, Attribute& out);
  bool tensor(Bytes bytes, const std::string& of, Tensor& out);
  bool raw(Bytes bytes, std::uint64_t type, Tensor& out);
  bool port(Bytes bytes, GraphPort& out);
  bool port_type(Bytes bytes, GraphPort& out);
  bool shape(Bytes bytes, GraphPort& out);
};

std::string text(const PbField& f) { return std::string(f.text()); }

/// Appends one number, or a packed run of them.
bool add_integers(const PbField& f, std::vector<std::int64_t>& out) {
  if (f.type == Type::varint) {
    out.push_back(f.integer());
    return true;
  }
  if (f.type != Type::bytes) return false;
  PbReader packed(f.bytes);
  std::uint64_t value = 0;
  while (!packed.at_end() && packed.next_varint(value)) out.push_back(static_cast<std::int64_t>(value));
  return packed.ok();
}

float float_at(Bytes bytes, std::size_t at) {
  std::uint32_t bits = 0;
  for (std::size_t i = 0; i < 4; ++i) bits |= std::uint32_t{bytes[at + i]} << (8 * i);
  return std::bit_cast<float>(bits);
}
std::uint64_t word_at(Bytes bytes, std::size_t at, std::size_t size) {
  std::uint64_t bits = 0;
  for (std::size_t i = 0; i < size; ++i) bits |= std::uint64_t{bytes[at + i]} << (8 * i);
  return bits;
}

bool add_floats(const PbField& f, std::vector<float>& out) {
  if (f.type == Type::fixed32) {
    out.push_back(f.as_float());
    return true;
  }
  if (f.type != Type::bytes || f.bytes.size() % 4 != 0) return false;
  for (std::size_t at = 0; at < f.bytes.size(); at += 4) out.push_back(float_at(f.bytes, at));
  return true;
}
bool add_doubles(const PbField& f, std::vector<float>& out) {
  if (f.type == Type::fixed64) {
    out.push_back(static_cast<float>(std::bit_cast<double>(f.number_value)));
    return true;
  }
  if (f.type != Type::bytes || f.bytes.size() % 8 != 0) return false;
  for (std::size_t at = 0; at < f.bytes.size(); at += 8)
    out.push_back(static_cast<float>(std::bit_cast<double>(word_at(f.bytes, at, 8))));
  return true;
}

bool ModelReader::file(Bytes bytes) {
  PbReader reader(bytes);
  PbField f;
  bool has_graph = false;
  while (reader.next(f)) {
    if (f.number == 2 && f.type == Type::bytes) model.producer = printable(f.text());
    if (f.number == 8 && f.type == Type::bytes && !opset(f.bytes)) return false;
    if (f.number == 25) return fail("it has functions of its own, which are not supported: export it without them");
    if (f.number != 7 || f.type != Type::bytes) continue;
    if (has_graph) return cut_off("its graph");
    has_graph = true;
    if (!graph(f.bytes)) return false;
  }
  if (!reader.ok() || !has_graph) return cut_off("the file");
  if (model.opset == 0) return cut_off("its opset");
  return true;
}

bool ModelReader::opset(Bytes bytes) {
  PbReader reader(bytes);
  PbField f;
  std::string domain;
  std::int64_t version = 0;
  while (reader.next(f)) {
    if (f.number == 1 && f.type == Type::bytes) domain = text(f);
    if (f.number == 2 && f.type == Type::varint) version = f.integer();
  }
  if (domain.empty() || domain == "ai.onnx") model.opset = version;
  return reader.ok() || cut_off("its opset");
}

bool ModelReader::graph(Bytes bytes) {
  PbReader reader(bytes);
  PbField f;
  while (reader.next(f)) {
    if (f.number == 15) return fail("it has sparse weights, which are not supported");
    if (f.type != Type::bytes) continue;
    if (f.number == 1 && !node(f.bytes)) return false;
    if (f.number == 5 && !tensor(f.bytes, "a weight", model.constants.emplace_back())) return false;
    if (f.number == 11 && !port(f.bytes, model.inputs.emplace_back())) return false;
    if (f.number == 12 && !port(f.bytes, model.outputs.emplace_back())) return false;
    if (model.constants.size() > kMostNodes || model.inputs.size() > kMostNodes || model.outputs.size() > kMostNodes)
      return fail("it has more than " + std::to_string(kMostNodes) + " weights, inputs or outputs");
  }
  return reader.ok() || cut_off("its graph");
}

bool ModelReader::node(Bytes bytes) {
  if (model.nodes.size() == kMostNodes) return fail("it has more than " + std::to_string(kMostNodes) + " nodes");
  Node& n = model.nodes.emplace_back();
  n.index = model.nodes.size() - 1;
  PbReader reader(bytes);
  PbField f;
  std::vector<Bytes> attributes;  // their problems are told with the node's name
  while (reader.next(f)) {
    if (f.type != Type::bytes) continue;
    if (f.number == 1) n.inputs.push_back(text(f));
    if (f.number == 2) n.outputs.push_back(text(f));
    if (f.number == 3) n.name = printable(f.text());
    if (f.number == 4) n.op = printable(f.text());
    if (f.number == 7) n.domain = printable(f.text());
    if (f.number == 5) attributes.push_back(f.bytes);
    if (n.inputs.size() > kMostNames || n.outputs.size() > kMostNames || attributes.size() > kMostAttributes)
      return fail(n.title() + " has more inputs, outputs or attributes than " + std::to_string(kMostNames));
  }
  if (!reader.ok()) return cut_off(n.title());
  for (const Bytes a : attributes)
    if (!attribute(a, n, n.attributes.emplace_back())) return false;
  return true;
}

bool ModelReader::attribute(Bytes bytes, const Node& node, Attribute& out) {
  PbReader reader(bytes);
  PbField f;
  bool good = true;
  while (good && reader.next(f)) {
    const bool is_bytes = f.type == Type::bytes;
    if (f.number == 1 && is_bytes) out.name = printable(f.text());
    if (f.number == 2 && f.type == Type::fixed32) out.f = f.as_float(), out.has_float = true;
    if (f.number == 3 && f.type == Type::varint) out.i = f.integer(), out.has_int = true;
    if (f.number == 4 && is_bytes) out.s = printable(f.text());
    if (f.number == 5 && is_bytes) {
      out.has_tensor = true;
      if (!tensor(f.bytes, node.title(), out.t)) return false;
    }
    if (f.number == 6) out.has_graph = true;
    if (f.number == 7) good = add_floats(f, out.floats);
    if (f.number == 8) good = add_integers(f, out.ints);
    if (f.number == 9 && is_bytes) out.strings.push_back(printable(f.text()));
    good &= out.strings.size() <= kMostNames;
  }
  return (good && reader.ok()) || cut_off(node.title());
}

bool ModelReader::tensor(Bytes bytes, const std::string& of, Tensor& out) {
  PbReader reader(bytes);
  PbField f;
  std::uint64_t type = 0;
  bool good = true, has_raw = false, outside = false;
  Bytes raw_data;
  std::vector<float> floats, doubles;
  std::vector<std::int64_t> i32, i64;
  while (good && reader.next(f)) {
    if (f.number == 1) good = add_integers(f, out.dims) && out.dims.size() <= kMostRank;
    if (f.number == 2 && f.type == Type::varint) type = f.number_value;
    if (f.number == 4) good = add_floats(f, floats);
    if (f.number == 5) good = add_integers(f, i32);
    if (f.number == 7) good = add_integers(f, i64);
    if (f.number == 8 && f.type == Type::bytes) out.name = text(f);
    if (f.number == 9 && f.type == Type::bytes) raw_data = f.bytes, has_raw = true;
    if (f.number == 10) good = add_doubles(f, doubles);
    if (f.number == 13 || (f.number == 14 && f.number_value == 1)) outside = true;
  }
  const std::string name = out.name.empty() ? of : "weight '" + printable(out.name) + "'";
  if (!good || !reader.ok()) return cut_off(name);
  if (outside) return fail(name + " is in another file (external data): export the network as one file");
  const auto known = static_cast<ElementType>(type);
  constexpr std::array kKnown{ElementType::f32, ElementType::i32, ElementType::i64, ElementType::boolean,
                              ElementType::f64};
  if (type > 255 || std::find(kKnown.begin(), kKnown.end(), known) == kKnown.end())
    return fail(name + " is of " + element_type_name(type) + "; float and, for shapes, int32 and int64 are supported");
  out.is_float = known == ElementType::f32 || known == ElementType::f64;
  if (has_raw) {
    if (!raw(raw_data, type, out)) return cut_off(name);
  } else if (out.is_float) {
    out.floats = std::move(known == ElementType::f32 ? floats : doubles);
  } else {
    out.ints = std::move(known == ElementType::i64 ? i64 : i32);
    if (known != ElementType::i64)
      for (std::int64_t& v : out.ints) v = static_cast<std::int32_t>(static_cast<std::uint64_t>(v));
  }
  const std::int64_t count = count_of(out.dims);
  if (count < 0) return fail(name + " has more than " + std::to_string(kMostElements) + " elements");
  const std::size_t held = out.is_float ? out.floats.size() : out.ints.size();
  return held == static_cast<std::size_t>(count) ||
         fail(name + " has " + std::to_string(held) + " numbers, its shape " + text_of(out.dims) + " says " +
              std::to_string(count));
}

bool ModelReader::raw(Bytes bytes, std::uint64_t type, Tensor& out) {
  std::size_t size = 4;
  if (static_cast<ElementType>(type) == ElementType::boolean) size = 1;
  if (static_cast<ElementType>(type) == ElementType::i64 || static_cast<ElementType>(type) == ElementType::f64)
    size = 8;
  if (bytes.size() % size != 0) return false;
  const std::size_t count = bytes.size() / size;
  if (out.is_float) out.floats.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint64_t word = word_at(bytes, i * size, size);
    if (out.is_float)
      out.floats.push_back(size == 4 ? std::bit_cast<float>(static_cast<std::uint32_t>(word))
                                     : static_cast<float>(std::bit_cast<double>(word)));
    else
      out.ints.push_back(size == 4 ? std::int64_t{static_cast<std::int32_t>(static_cast<std::uint32_t>(word))}
                                   : static_cast<std::int64_t>(word));
  }
  return true;
}

bool ModelReader::port(Bytes bytes, GraphPort& out) {
  PbReader reader(bytes);
  PbField f;
  while (reader.next(f)) {
    if (f.type != Type::bytes) continue;
    if (f.number == 1) out.name = text(f);
    if (f.number == 2 && !port_type(f.bytes, out)) return false;
  }
  return reader.ok() || cut_off("input or output '" + printable(out.name) + "'");
}

bool ModelReader::port_type(Bytes bytes, GraphPort& out) {
  PbReader reader(bytes);
  PbField f;
  while (reader.next(f)) {
    if (f.number != 1 || f.type != Type::bytes) continue;  // a sequence, a map: has no element type then
    PbReader of_tensor(f.bytes);
    PbField t;
    while (of_tensor.next(t)) {
      if (t.number == 1 && t.type == Type::varint) out.type = t.number_value;
      if (t.number == 2 && t.type == Type::bytes && !shape(t.bytes, out)) return false;
    }
    if (!of_tensor.ok()) return cut_off("a type");
  }
  return reader.ok() || cut_off("a type");
}

bool ModelReader::shape(Bytes bytes, GraphPort& out) {
  out.has_shape = true;
  PbReader reader(bytes);
  PbField f;
  while (reader.next(f)) {
    if (f.number != 1 || f.type != Type::bytes) continue;
    PbReader dimension(f.bytes);
    PbField d;
    std::int64_t size = -1;
    while (dimension.next(d))
      if (d.number == 1 && d.type == Type::varint) size = d.integer() > 0 ? d.integer() : -1;
    if (!dimension.ok()) return cut_off("a shape");
    if (out.dims.size() == kMostRank)
      return fail("'" + printable(out.name) + "' has more than " + std::to_string(kMostRank) + " dimensions");
    out.dims.push_back(size);
  }
  return reader.ok() || cut_off("a shape");
}

}  // namespace

std::string element_type_name(std::uint64_t type) {
  constexpr std::array<const char*, 17> kNames{"no type", "float",  "uint8",   "int8",    "uint16",  "int16",
                                               "int32",   "int64",  "string",  "bool",    "float16", "double",
                                               "uint32",  "uint64", "complex", "complex", "bfloat16"};
  return type < kNames.size() ? kNames[static_cast<std::size_t>(type)] : "type " + std::to_string(type);
}

const Attribute* Node::find(std::string_view attribute) const {
  for (const Attribute& a : attributes)
    if (a.name == attribute) return &a;
  return nullptr;
}

std::string Node::title() const {
  if (!name.empty()) return "node '" + name + "' (" + op + ")";
  std::string text = "node " + std::to_string(index + 1) + " (" + op;
  if (!outputs.empty()) text += ", makes '" + printable(outputs[0]) + "'";
  return text + ")";
}

std::string printable(std::string_view name) {
  std::string out(name.substr(0, 100));
  for (char& c : out)
    if (c < ' ' || c > '~') c = '?';
  return out;
}

std::string text_of(const Dims& dims) {
  std::string text = "[";
  for (const std::int64_t d : dims)
    text += (text.size() > 1 ? ", " : "") + (d < 0 ? std::string("?") : std::to_string(d));
  return text + "]";
}

std::int64_t count_of(const Dims& dims) {
  std::int64_t count = 1;
  for (const std::int64_t d : dims) {
    if (d < 0 || d > kMostElements) return -1;
    count *= d;
    if (count > kMostElements) return -1;
  }
  return count;
}

bool read_model(Bytes file, Model& model, std::string& problem) {
  problem.clear();
  model = {};
  if (file.size() > kMostFileBytes) {
    problem =
        "it has " + std::to_string(file.size()) + " bytes; at most " + std::to_string(kMostFileBytes) + " are read";
    return false;
  }
  ModelReader reader{model, problem};
  return reader.file(file);
}

}  // namespace sinew::onnx
