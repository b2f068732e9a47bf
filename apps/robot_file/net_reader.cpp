#include "apps/robot_file/net_reader.hpp"

#include <algorithm>
#include <array>
#include <filesystem>

#include "rt/graph_check.hpp"

namespace sinew::app {
namespace {

namespace fs = std::filesystem;

// As net/dds/participant.hpp has them, which is not built where Cyclone DDS is missing.
constexpr std::int64_t kMostDomain = 232, kMostIndexed = 119;
constexpr std::size_t kMostNetNames = 64;

bool is_plain_name(const std::string& text) {
  return !text.empty() && text.size() <= 253 && std::all_of(text.begin(), text.end(), [](char c) {
    return c > ' ' && c <= '~' && c != '<' && c != '>' && c != '"' && c != '&' && c != '$';
  });
}

void read_net_names(TomlReader& r, std::string_view key, std::vector<std::string>& out, const std::string& allowed) {
  std::vector<rt::Located<std::string>> names;
  if (!r.read_names(key, names)) return;
  for (const auto& name : names) {
    if (!is_plain_name(name.value) || out.size() == kMostNetNames)
      r.problems().push_back({name.line, r.full(key), rt::quoted(name.value), allowed});
    else
      out.push_back(name.value);
  }
}

void read_net_security(TomlReader& r, const fs::path& folder, NetTable& net) {
  const std::array<std::pair<const char*, std::string*>, 6> files{{{"identity_ca", &net.identity_ca},
                                                                   {"certificate", &net.certificate},
                                                                   {"private_key", &net.private_key},
                                                                   {"permissions_ca", &net.permissions_ca},
                                                                   {"governance", &net.governance},
                                                                   {"permissions", &net.permissions}}};
  constexpr const char* kAllowed = "the path of a file, from this robot file's folder; all six are required";
  for (const auto& [key, path] : files) {
    r.require(key, *path, kAllowed);
    if (path->empty()) continue;
    if (fs::path(*path).is_relative()) *path = (folder / *path).string();
  }
}

}  // namespace

void read_net(TomlReader& r, RobotFile& robot) {
  NetTable net;
  net.line = r.line();
  std::int64_t number = 0;
  if (r.read("domain", number, 0, kMostDomain)) net.domain = static_cast<std::uint32_t>(number);
  read_net_names(r, "interfaces", net.interfaces, "names of interfaces or IPv4 addresses, at most 64");
  r.read("multicast", net.multicast);
  read_net_names(r, "peers", net.peers, "addresses, \"10.0.0.2\" or \"10.0.0.2:7410\", at most 64");
  if (r.read("most_on_a_machine", number, 1, kMostIndexed)) net.most_on_a_machine = static_cast<std::uint32_t>(number);
  r.read("extra", net.extra, "elements of Cyclone DDS's configuration, as below <Domain>");
  if (!net.multicast && net.peers.empty())
    r.problems().push_back({net.line, r.full("peers"), "", "addresses: without multicast nobody else is found"});
  const fs::path folder = fs::path(robot.place_of(net.line).file).parent_path();
  r.table("security", [&](TomlReader& s) { read_net_security(s, folder, net); });
  robot.net = std::move(net);
}

void add_net(RobotFile& robot, Problems& problems) {
  for (drivers::DeviceSpec& device : robot.devices.devices) {
    if (device.driver != "dds" || device.keys.contains("program")) continue;
    device.keys["program"] = {rt::ParamValue(robot.graph.robot), device.line};
    if (!robot.net)
      problems.push_back({device.line, "device." + device.name, "driver \"dds\"",
                          "a table [net] beside it: it says which network the program sinew net uses"});
  }
}

}  // namespace sinew::app
