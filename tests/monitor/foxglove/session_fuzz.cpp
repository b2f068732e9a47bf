// Whatever a client sends: the session goes on or ends, keeps what it holds within its bounds, and what it sends is
// JSON.
#include <cstdlib>

#include "fake_robot.hpp"

using namespace sinew;
using namespace sinew::foxglove;

/// Messages: one byte (bit 0: binary; bit 1: has the token, of the first), two bytes little-endian with the length, the
/// message.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const auto robot = std::make_shared<FakeRobot>("quad");
  robot->facts_.recorded_ns = {1, 2};
  robot->replies["params"] = R"({"ok":true,"params":[{"module":"m","param":"p","type":"number","value":1}]})";
  Rig rig({.sdk = true, .may_command = (data[0] & 2) != 0, .all_robots = (data[0] & 4) != 0});
  rig.session->follow({robot});
  rig.all();
  for (std::size_t at = 0; at + 3 <= size;) {
    const bool binary = (data[at] & 1) != 0;
    const std::size_t length = std::min<std::size_t>(data[at + 1] + 256u * data[at + 2], size - at - 3);
    const std::span<const std::byte> message(reinterpret_cast<const std::byte*>(data + at + 3), length);
    at += 3 + length;
    const bool goes_on = rig.session->receive(binary, message);
    robot->publish(0, "small");
    robot->picture(10);
    rig.session->tick();
    for (const Received& r : rig.all())
      if (!r.binary && !r.json().is_object()) std::abort();
    if (!goes_on) break;
  }
  rig.session.reset();
  for (const auto& [channel, inboxes] : robot->inboxes)
    if (!inboxes.empty()) std::abort();
  return 0;
}
