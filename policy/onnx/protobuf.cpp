#include "policy/onnx/protobuf.hpp"

namespace sinew::onnx {

bool PbReader::next_varint(std::uint64_t& value) {
  value = 0;
  for (unsigned shift = 0; shift < 64; shift += 7) {
    if (rest_.empty()) return fail();
    const std::uint8_t byte = rest_[0];
    rest_ = rest_.subspan(1);
    value |= std::uint64_t{byte & 0x7Fu} << shift;
    if ((byte & 0x80u) == 0) return true;
  }
  return fail();
}

bool PbReader::fixed(std::size_t bytes, std::uint64_t& value) {
  if (rest_.size() < bytes) return fail();
  value = 0;
  for (std::size_t i = 0; i < bytes; ++i) value |= std::uint64_t{rest_[i]} << (8 * i);
  rest_ = rest_.subspan(bytes);
  return true;
}

bool PbReader::next(PbField& field) {
  if (rest_.empty() || !ok_) return false;
  std::uint64_t key = 0;
  if (!next_varint(key)) return false;
  field.number = static_cast<std::uint32_t>(key >> 3);
  field.bytes = {};
  if (key >> 3 == 0 || key >> 3 > 0x1FFFFFFF) return fail();
  switch (key & 7) {
    case 0:
      field.type = PbField::Type::varint;
      return next_varint(field.number_value);
    case 1:
      field.type = PbField::Type::fixed64;
      return fixed(8, field.number_value);
    case 2: {
      field.type = PbField::Type::bytes;
      std::uint64_t size = 0;
      if (!next_varint(size)) return false;
      if (size > rest_.size()) return fail();
      field.bytes = rest_.first(static_cast<std::size_t>(size));
      rest_ = rest_.subspan(static_cast<std::size_t>(size));
      return true;
    }
    case 5:
      field.type = PbField::Type::fixed32;
      return fixed(4, field.number_value);
    default:
      return fail();
  }
}

}  // namespace sinew::onnx
