#include "sim_hil/board/plant_connection.hpp"

#include <algorithm>

namespace sinew::sim_hil {
namespace {

using hal::Errc;
using hal::Error;
using hal::Result;
using hal::Status;

constexpr Duration kTurn = std::chrono::milliseconds(100);

std::string title(const DeviceInfo& d) { return std::string(to_string(d.kind)) + " '" + d.name + "'"; }

const DeviceInfo* find(const Welcome& w, const DeviceInfo& wanted) {
  const auto it = std::find_if(w.devices.begin(), w.devices.end(),
                               [&](const auto& d) { return d.kind == wanted.kind && d.name == wanted.name; });
  return it == w.devices.end() ? nullptr : &*it;
}

std::string changed(const DeviceInfo& a, const DeviceInfo& b) {
  const auto from_to = [](const char* what, auto x, auto y) {
    return std::string(what) + " " + std::to_string(x) + " instead of " + std::to_string(y);
  };
  if (a.channels != b.channels) return from_to("channels", b.channels, a.channels);
  if (a.width != b.width) return from_to("width", b.width, a.width);
  if (a.height != b.height) return from_to("height", b.height, a.height);
  if (a.format != b.format) return "another pixel format";
  if (a.period != b.period) return from_to("period in ns", b.period.count(), a.period.count());
  if (a.slots != b.slots || a.slots_offset != b.slots_offset || a.slot_bytes != b.slot_bytes)
    return "its frames come another way";
  return {};
}

}  // namespace

std::string difference(const Welcome& before, const Welcome& now) {
  for (const DeviceInfo& d : before.devices) {
    const DeviceInfo* there = find(now, d);
    if (!there) return "no " + title(d);
    if (const std::string what = changed(d, *there); !what.empty()) return title(d) + ": " + what;
  }
  for (std::size_t i = 0; i < now.devices.size(); ++i)  // ids are places
    if (i >= before.devices.size() || before.devices[i].name != now.devices[i].name)
      return title(now.devices[i]) + " is new or in another place";
  return {};
}

Status PlantConnection::shake_hands(const Hello& hello, std::string& why) {
  why.clear();
  static_cast<void>(out.add(Type::hello, 0, Time{}, hello));  // the first message always fits
  auto ok = flush();
  Message message;
  if (ok) ok = receive(message);
  if (ok) ok = adopt(message, why);
  if (ok) return ok;
  if (why.empty()) why = describe_failure(ok.error(), "no Welcome from the plant");
  static_cast<void>(out.add_text(Type::bye, Time{}, why));
  static_cast<void>(flush());  // the peer may be gone already, and needs no reason then
  stream->shutdown();
  return ok;
}

Status PlantConnection::adopt(const Message& message, std::string& why) {
  const Header& h = message.header;
  if (h.type == Type::bye) {
    why = "plant refused: " + decode_text(message.payload);
    return Error{Errc::closed, "plant refused the connection"};
  }
  if (h.type != Type::welcome) return Error{Errc::bad_data, "the plant's first message must be Welcome"};
  if (auto ok = decode(h, message.payload, welcome); !ok) {
    if (welcome.version != kVersion)
      why = "plant speaks version " + std::to_string(welcome.version) + " of the simulator protocol, this runtime " +
            std::to_string(kVersion);
    return ok;
  }
  auto handed = stream->take_memory(hal::Stream::MemoryAccess::copied);  // each frame is read once, into its message
  if (welcome.shared_bytes == 0) return {};
  if (!handed) return handed.error();
  if ((*handed)->size() < welcome.shared_bytes)
    return Error{Errc::bad_data, "shared memory is smaller than the plant says", std::int64_t((*handed)->size())};
  memory = std::move(*handed);
  return {};
}

Status PlantConnection::receive(Message& message) {
  for (;;) {
    auto next = in.next(message);
    if (!next) return next.error();
    if (*next) return {};
    auto n = read(in.space());
    if (!n) return n.error();
    in.filled(*n);
  }
}

void PlantConnection::wait_for(Duration longest, const Silence* asked) {
  silence = asked && asked->go_on ? asked : nullptr;
  patience = longest;
  stream->set_patience(silence ? std::min(kTurn, longest) : longest);
}

Result<std::size_t> PlantConnection::read(std::span<std::byte> into) {
  for (Duration silent{0};;) {
    auto n = stream->read(into);
    const bool waits = !n && n.error().code == Errc::timeout && silence;
    if (!waits) {
      if (n && silent.count() > 0) silence->over(silent);
      return n;
    }
    silent += kTurn;
    if (!silence->go_on(silent)) return Error{Errc::timeout, "waiting was given up"};
    if (patience.count() > 0 && silent >= patience) return n;
  }
}

Status PlantConnection::flush() {
  auto sent = stream->write(out.pending());
  out.clear();
  return sent;
}

}  // namespace sinew::sim_hil
