// For any text: either a reason, or a message that survives to_json() and back.
#include <cstdlib>
#include <vector>

#include "msg/all.hpp"
#include "msg/compare.hpp"
#include "msg/json.hpp"

using namespace sinew::msg;

/// The first byte picks the type, the rest is the text.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const TypeInfo& type = *all_types()[data[0] % all_types().size()];
  constexpr std::uint32_t kCapacity = 256;
  std::vector<std::uint8_t> message(type.size + (type.has_bulk() ? kCapacity : 0)), again = message;
  const std::string_view text(reinterpret_cast<const char*>(data + 1), size - 1);
  if (const auto error = from_json(type, text, message.data(), kCapacity)) {
    if (error->what.empty() || error->at > text.size()) std::abort();
    return 0;
  }
  std::string written;
  to_json(type, message.data(), written, {.bulk = JsonOptions::Bulk::base64});
  if (from_json(type, written, again.data(), kCapacity)) std::abort();
  if (!equal(type, message.data(), again.data())) std::abort();
  return 0;
}
