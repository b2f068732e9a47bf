// For any bytes: either a reason, or a message that encodes to the same bytes again.
#include <cstdlib>
#include <cstring>
#include <vector>

#include "msg/all.hpp"
#include "msg/cdr.hpp"
#include "msg/compare.hpp"

using namespace sinew::msg;

/// The first byte picks the type, the rest is the input.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const TypeInfo& type = *all_types()[data[0] % all_types().size()];
  const std::span<const std::uint8_t> in(data + 1, size - 1);
  constexpr std::uint32_t kCapacity = 256;
  // Exactly as large as the message may become, so that a sanitizer sees one byte more.
  std::vector<std::uint8_t> message(type.size + (type.has_bulk() ? kCapacity : 0));
  if (!cdr_decode(type, in, message.data(), kCapacity)) return 0;

  std::vector<std::uint8_t> out(cdr_size(type, message.data()));
  if (cdr_encode(type, message.data(), out) != in.size() || out.size() != in.size()) std::abort();
  for (const FieldInfo& f : type.fields)  // the one field that belongs to the slot, not to the sender
    if (f.name == "capacity_bytes") std::memcpy(out.data() + 4 + f.offset, in.data() + 4 + f.offset, 4);
  if (std::memcmp(out.data(), in.data(), in.size()) != 0) std::abort();
  return 0;
}
