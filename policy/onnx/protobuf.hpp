#pragma once
// The wire format of protocol buffers, as far as a reader needs it.
#include <bit>
#include <cstdint>
#include <span>
#include <string_view>

namespace sinew::onnx {

using Bytes = std::span<const std::uint8_t>;

/// One field of a protobuf message. Which of the values counts, the wire type says.
struct PbField {
  std::uint32_t number = 0;
  enum class Type : std::uint8_t { varint = 0, fixed64 = 1, bytes = 2, fixed32 = 5 } type = Type::varint;
  std::uint64_t number_value = 0;  // varint, fixed64, fixed32
  Bytes bytes{};                   // a string, a message, packed numbers

  std::int64_t integer() const { return static_cast<std::int64_t>(number_value); }
  float as_float() const { return std::bit_cast<float>(static_cast<std::uint32_t>(number_value)); }
  std::string_view text() const { return {reinterpret_cast<const char*>(bytes.data()), bytes.size()}; }
};

/// Walks over the fields of one message. Never reads outside of its bytes, whatever they are.
/// Thread:  any.   RT: yes.
/// Source:  https://protobuf.dev/programming-guides/encoding/
class PbReader {
 public:
  explicit PbReader(Bytes message) : rest_(message) {}
  /// False: the end, or bytes that are no protobuf; ok() tells which.
  bool next(PbField& field);
  /// A number of a packed field without keys.
  bool next_varint(std::uint64_t& value);
  bool ok() const { return ok_; }
  bool at_end() const { return rest_.empty(); }

 private:
  bool fixed(std::size_t bytes, std::uint64_t& value);
  bool fail() { return ok_ = false; }

  Bytes rest_;
  bool ok_ = true;
};

}  // namespace sinew::onnx
