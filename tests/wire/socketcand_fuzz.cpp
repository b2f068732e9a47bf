// For any bytes: elements that are refused, or frames that are written and read again as the same.
#include "wire/socketcand.hpp"

#include <cstdlib>

#include "wire/can_check.hpp"

using namespace sinew;

namespace {

void again(const msg::CanFrame& frame, std::size_t (*write)(const msg::CanFrame&, std::span<char>) noexcept) {
  std::array<char, wire::kSocketcandMax> text{};
  const std::size_t size = write(frame, text);
  if (size < 4) std::abort();
  wire::SocketcandMessage back;
  if (!wire::socketcand_parse({text.data() + 1, size - 2}, back)) std::abort();
  if (back.frame.id != frame.id || back.frame.flags != frame.flags || back.frame.size != frame.size) std::abort();
  if (back.frame.data != frame.data) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  wire::SocketcandSplitter splitter;
  for (std::size_t i = 0; i < size; ++i) {
    if (!splitter.push(static_cast<char>(data[i]))) continue;
    wire::SocketcandMessage message;
    if (!wire::socketcand_parse(splitter.element(), message)) continue;
    if (message.kind == wire::SocketcandKind::frame) again(message.frame, wire::socketcand_frame);
    if (message.kind == wire::SocketcandKind::send) again(message.frame, wire::socketcand_send);
  }
  return 0;
}
