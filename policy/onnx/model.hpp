#pragma once
// What an ONNX file says, as plain data: the part of the format that networks for inference use.
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "policy/onnx/protobuf.hpp"

namespace sinew::onnx {

using Dims = std::vector<std::int64_t>;

inline constexpr std::size_t kMostFileBytes = 32 << 20;
inline constexpr std::size_t kMostNodes = 4096, kMostRank = 6;
inline constexpr std::int64_t kMostElements = 8 << 20;  // of one tensor

/// Element types of the format that this reader knows; others are refused by their name.
enum class ElementType : std::uint8_t { none = 0, f32 = 1, i32 = 6, i64 = 7, boolean = 9, f64 = 11 };
std::string element_type_name(std::uint64_t type);

/// Numbers in row-major order: `floats` of type f32 or f64, else `ints`.
struct Tensor {
  std::string name{};
  Dims dims{};
  bool is_float = true;
  std::vector<float> floats{};
  std::vector<std::int64_t> ints{};
};

struct Attribute {
  std::string name{};
  bool has_float = false, has_int = false, has_tensor = false, has_graph = false;
  float f = 0;
  std::int64_t i = 0;
  std::string s{};
  Tensor t{};
  std::vector<float> floats{};
  std::vector<std::int64_t> ints{};
  std::vector<std::string> strings{};
};

struct Node {
  std::string name{}, op{}, domain{};
  std::vector<std::string> inputs{}, outputs{};  // names of values; an empty input is left out
  std::vector<Attribute> attributes{};
  std::size_t index = 0;  // in the file

  const Attribute* find(std::string_view attribute) const;
  /// For people: "node '/actor/0/Gemm' (Gemm)", and by its place and what it makes when it has no name.
  std::string title() const;
};

/// An input or output of the graph.
struct GraphPort {
  std::string name{};
  std::uint64_t type = 0;  // as ElementType
  bool has_shape = false;
  Dims dims{};  // -1: has a name ("batch") or nothing in place of a number
};

struct Model {
  std::int64_t opset = 0;  // of the domain ai.onnx
  std::string producer{};
  std::vector<Node> nodes{};
  std::vector<Tensor> constants{};
  std::vector<GraphPort> inputs{}, outputs{};
};

/// Names out of files may be anything: printable, at most 100 characters.
std::string printable(std::string_view name);
std::string text_of(const Dims& dims);
/// -1: more than kMostElements, or a size below 0.
std::int64_t count_of(const Dims& dims);

/// Reads a file. Takes memory in proportion to its size, and no recursion.
/// Thread:  any.   RT: no.
/// Errors:  false, with `problem` in words: no ONNX file, cut off, weights outside of the file, more than the limits.
/// Source:  https://github.com/onnx/onnx/blob/main/onnx/onnx.proto
bool read_model(Bytes file, Model& model, std::string& problem);

}  // namespace sinew::onnx
