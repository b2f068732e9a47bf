#include "drivers/board/radio_driver.hpp"

#include <algorithm>

namespace sinew::drivers {
namespace {

constexpr std::string_view kGroupIs = "a multicast address and a port, \"239.72.1.1:4580\"";
constexpr std::string_view kPeersAre = "addresses and ports with commas between them, \"10.0.0.2:4580, 10.0.0.3:4580\"";

/// Nothing: one of them is no address of a peer.
std::optional<std::vector<hal::UdpAddress>> peers_of(std::string_view text) {
  std::vector<hal::UdpAddress> peers;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find(','), text.size());
    std::string_view one = text.substr(0, end);
    while (one.starts_with(' ')) one.remove_prefix(1);
    while (one.ends_with(' ')) one.remove_suffix(1);
    const auto peer = hal::udp_address(one);
    if (!peer || peer->is_multicast() || peer->ipv4 == 0) return std::nullopt;
    peers.push_back(*peer);
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return peers;
}

DeviceOpener open_radio(const hal::RadioSpec& spec) {
  return [spec](DeviceContext& context, std::string& why) -> hal::Result<OpenedDevice> {
    auto radio = context.connectors.radio(spec, why);
    if (!radio) return radio.error();
    OpenedDevice device;
    device.radio = radio->get();
    device.report = dynamic_cast<const hal::SelfReport*>(radio->get());
    device.owner = std::shared_ptr<hal::Radio>(std::move(*radio));
    return device;
  };
}

DeviceOpener read_udp(DeviceKeys& keys, const DeviceSpecs&) {
  hal::RadioSpec spec;
  std::string group = to_text(spec.group), peers;
  if (keys.read("group", group, kGroupIs, {.doc = "whoever is on this network with the same group hears it"})) {
    const auto address = hal::udp_address(group);
    if (address && address->is_multicast())
      spec.group = *address;
    else
      keys.problem("group", kGroupIs);
  }
  keys.read("interface", spec.interface, "the name of an interface, \"wlan0\"",
            {.doc = "of the group", .otherwise = "by the route to the group, else the first that is up, else lo"});
  keys.read_integer("ttl", spec.ttl, 1, 255, {.doc = "of the group: how many networks a datagram reaches"});
  if (keys.read("peers", peers, kPeersAre,
                {.doc = "in place of the group where there is no multicast", .otherwise = "none: the group"})) {
    const auto all = peers_of(peers);
    if (all && !all->empty())
      spec.peers = *all;
    else
      keys.problem("peers", kPeersAre);
    for (const std::string_view key : {"group", "interface", "ttl"})
      if (keys.has(key)) keys.problem(key, "no such key beside peers");
  }
  if (keys.read_integer("port", spec.port, 1, 65535, {.doc = "with peers: where this radio listens, and sends from"}) &&
      !keys.has("peers"))
    keys.problem("port", "no such key without peers");
  if (keys.has("peers"))
    keys.claim("port", "UDP port " + std::to_string(spec.port));
  else
    keys.claim("group", "radio " + to_text(spec.group) + (spec.interface.empty() ? "" : " on " + spec.interface));
  return open_radio(spec);
}

DeviceOpener read_dds(DeviceKeys& keys, const DeviceSpecs&) {
  hal::RadioSpec spec;
  spec.net = "robot";  // the reader of robot files puts the robot's name in
  keys.read("program", spec.net, "the name of a robot",
            {.doc = "whose `sinew net` it is", .otherwise = "this robot's name"});
  keys.claim("program", "sinew net of " + spec.net);
  return open_radio(spec);
}

}  // namespace

DriverKind udp_radio_driver() { return {"udp", "radio", read_udp}; }
DriverKind dds_radio_driver() { return {"dds", "radio", read_dds}; }

}  // namespace sinew::drivers
