// For any bytes: no frame of a team, or a frame that is written to the same bytes again.
#include "wire/team_frame.hpp"

#include <cstdlib>
#include <cstring>
#include <vector>

using namespace sinew;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  wire::TeamReader frame;
  if (frame.open({data, size})) {
    if (frame.next() || frame.echoes() != 0 || frame.messages() != 0) std::abort();  // nothing of it is used
    return 0;
  }
  std::vector<std::uint8_t> out(size);
  wire::TeamWriter again(out, frame.head());
  for (std::size_t i = 0; i < frame.echoes(); ++i)
    if (!again.add(frame.echo(i))) std::abort();
  std::size_t messages = 0;
  while (const auto message = frame.next()) {
    ++messages;
    if (message->cdr.data() < data || message->cdr.data() + message->cdr.size() > data + size) std::abort();
    if (!again.add(*message)) std::abort();
  }
  if (messages != frame.messages() || again.finish().size() != size) std::abort();
  if (std::memcmp(out.data(), data, size) != 0) std::abort();
  return 0;
}
