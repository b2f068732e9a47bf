#pragma once
// Writes ONNX files by hand, field by field: no library stands between the tests and the format.
#include <bit>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

namespace sinew::onnx::test {

using Dims = std::vector<std::int64_t>;
using Names = std::vector<std::string>;

/// A protobuf message that grows.
class PbWriter {
 public:
  PbWriter& integer(std::uint32_t field, std::int64_t value) {
    key(field, 0);
    varint(static_cast<std::uint64_t>(value));
    return *this;
  }
  PbWriter& number(std::uint32_t field, float value) {
    key(field, 5);
    word(std::bit_cast<std::uint32_t>(value));
    return *this;
  }
  PbWriter& text(std::uint32_t field, std::string_view bytes) {
    key(field, 2);
    varint(bytes.size());
    out_ += bytes;
    return *this;
  }
  PbWriter& message(std::uint32_t field, const PbWriter& inner) { return text(field, inner.out_); }
  void word(std::uint32_t bits) {
    for (int i = 0; i < 4; ++i) out_ += static_cast<char>(bits >> (8 * i) & 0xFF);
  }
  void long_word(std::uint64_t bits) {
    word(static_cast<std::uint32_t>(bits));
    word(static_cast<std::uint32_t>(bits >> 32));
  }
  const std::string& bytes() const { return out_; }

 private:
  void key(std::uint32_t field, std::uint32_t type) { varint(std::uint64_t{field} << 3 | type); }
  void varint(std::uint64_t value) {
    for (; value >= 0x80; value >>= 7) out_ += static_cast<char>((value & 0x7F) | 0x80);
    out_ += static_cast<char>(value);
  }
  std::string out_;
};

inline PbWriter tensor(const Dims& dims, const std::vector<float>& values) {
  PbWriter t, raw;
  for (const std::int64_t d : dims) t.integer(1, d);
  for (const float v : values) raw.word(std::bit_cast<std::uint32_t>(v));
  t.integer(2, 1).text(9, raw.bytes());
  return t;
}
inline PbWriter tensor(const Dims& dims, const std::vector<std::int64_t>& values) {
  PbWriter t, raw;
  for (const std::int64_t d : dims) t.integer(1, d);
  for (const std::int64_t v : values) raw.long_word(static_cast<std::uint64_t>(v));
  t.integer(2, 7).text(9, raw.bytes());
  return t;
}

using AttributeValue =
    std::variant<std::int64_t, float, std::string, std::vector<std::int64_t>, std::vector<float>, Names,
                 PbWriter>;  // the last: a tensor
using Attributes = std::vector<std::pair<std::string, AttributeValue>>;

class ModelWriter {
 public:
  explicit ModelWriter(std::int64_t opset = 17) : opset_(opset) {}

  ModelWriter& input(const std::string& name, const Dims& dims) {
    graph_.message(11, port(name, dims));
    inputs.push_back({name, dims});
    return *this;
  }
  ModelWriter& output(const std::string& name, const Dims& dims) {
    graph_.message(12, port(name, dims));
    outputs.push_back(name);
    return *this;
  }
  ModelWriter& weight(const std::string& name, const Dims& dims, const std::vector<float>& values) {
    PbWriter t = tensor(dims, values);
    graph_.message(5, t.text(8, name));
    return *this;
  }
  ModelWriter& integers(const std::string& name, const Dims& dims, const std::vector<std::int64_t>& values) {
    PbWriter t = tensor(dims, values);
    graph_.message(5, t.text(8, name));
    return *this;
  }
  ModelWriter& raw_weight(const PbWriter& t) {
    graph_.message(5, t);
    return *this;
  }
  ModelWriter& node(const std::string& op, const Names& in, const Names& out, const Attributes& attributes = {},
                    const std::string& name = {}, const std::string& domain = {}) {
    PbWriter n;
    for (const auto& i : in) n.text(1, i);
    for (const auto& o : out) n.text(2, o);
    n.text(3, name.empty() ? "/" + op + "_" + std::to_string(nodes_++) : name).text(4, op);
    if (!domain.empty()) n.text(7, domain);
    for (const auto& [key, value] : attributes) n.message(5, attribute(key, value));
    graph_.message(1, n);
    return *this;
  }
  std::string bytes() const {
    PbWriter file, opset, graph = graph_;
    opset.text(1, "").integer(2, opset_);
    graph.text(2, "network");
    file.integer(1, 8).text(2, "sinew tests").message(7, graph).message(8, opset);
    return file.bytes();
  }

  std::vector<std::pair<std::string, Dims>> inputs;  // -1 in dims: "batch"
  Names outputs;

 private:
  static PbWriter port(const std::string& name, const Dims& dims) {
    PbWriter shape;
    for (const std::int64_t d : dims) {
      PbWriter dimension;
      if (d < 0)
        dimension.text(2, "batch");
      else
        dimension.integer(1, d);
      shape.message(1, dimension);
    }
    PbWriter of_tensor, type, p;
    of_tensor.integer(1, 1).message(2, shape);
    type.message(1, of_tensor);
    p.text(1, name).message(2, type);
    return p;
  }
  static PbWriter attribute(const std::string& name, const AttributeValue& value) {
    PbWriter a;
    a.text(1, name);
    if (const auto* i = std::get_if<std::int64_t>(&value)) a.integer(3, *i).integer(20, 2);
    if (const auto* f = std::get_if<float>(&value)) a.number(2, *f).integer(20, 1);
    if (const auto* s = std::get_if<std::string>(&value)) a.text(4, *s).integer(20, 3);
    if (const auto* t = std::get_if<PbWriter>(&value)) a.message(5, *t).integer(20, 4);
    if (const auto* fs = std::get_if<std::vector<float>>(&value)) {
      for (const float v : *fs) a.number(7, v);
      a.integer(20, 6);
    }
    if (const auto* is = std::get_if<std::vector<std::int64_t>>(&value)) {
      for (const std::int64_t v : *is) a.integer(8, v);
      a.integer(20, 7);
    }
    if (const auto* ss = std::get_if<Names>(&value)) {
      for (const auto& v : *ss) a.text(9, v);
      a.integer(20, 8);
    }
    return a;
  }

  std::int64_t opset_;
  int nodes_ = 0;
  PbWriter graph_;
};

}  // namespace sinew::onnx::test
