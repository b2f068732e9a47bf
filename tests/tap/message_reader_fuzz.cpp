// Whatever message comes in as JSON: either a reason, or a message that survives msg::to_json() and back.
#include "tap/message_reader.hpp"

#include <cstdlib>
#include <vector>

#include "msg/all.hpp"
#include "msg/compare.hpp"
#include "msg/json.hpp"

using namespace sinew;

/// The first byte picks the type, the rest is the text.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const msg::TypeInfo& type = *msg::all_types()[data[0] % msg::all_types().size()];
  const auto json = nlohmann::ordered_json::parse(data + 1, data + size, nullptr, false);
  if (type.has_bulk() || json.is_discarded()) return 0;
  std::vector<std::uint64_t> message(type.size / 8 + 1), again = message;
  if (const auto wrong = tap::read_message(type, json, message.data())) {
    if (wrong->empty()) std::abort();
    return 0;
  }
  std::string written;
  msg::to_json(type, message.data(), written);
  if (tap::read_message(type, nlohmann::ordered_json::parse(written), again.data())) std::abort();
  if (!msg::equal(type, message.data(), again.data())) std::abort();
  return 0;
}
