#include "net/dds/config_xml.hpp"

#include <algorithm>
#include <string_view>

namespace sinew::net {
namespace {

/// As an attribute's value, or as text.
std::string escaped(std::string_view text) {
  std::string out;
  for (const char c : text) {
    if (c == '&')
      out += "&amp;";
    else if (c == '<')
      out += "&lt;";
    else if (c == '>')
      out += "&gt;";
    else if (c == '"')
      out += "&quot;";
    else if (c == '$')
      out += "\\$";  // Cyclone puts the environment's variables in
    else
      out += c;
  }
  return out;
}

std::string element(std::string_view name, std::string_view text) {
  return "<" + std::string(name) + ">" + std::string(text) + "</" + std::string(name) + ">";
}

bool is_address(std::string_view text) { return text.find_first_not_of("0123456789.") == std::string_view::npos; }

std::string general(const ParticipantOptions& o) {
  std::string interfaces;
  for (const std::string& one : o.interfaces)
    interfaces += "<NetworkInterface " + std::string(is_address(one) ? "address" : "name") + "=\"" + escaped(one) +
                  "\"" + (o.multicast ? "" : " multicast=\"false\"") + "/>";
  if (interfaces.empty() && !o.multicast) interfaces = "<NetworkInterface autodetermine=\"true\" multicast=\"false\"/>";
  return element("General", (interfaces.empty() ? "" : element("Interfaces", interfaces)) +
                                element("AllowMulticast", o.multicast ? "true" : "false"));
}

/// 5 s: how long two robots may take to find each other again after one of them was out of range; Cyclone's own 30 s
/// are half a battery of some.
constexpr std::string_view kAnnounceEvery = "5 s";

std::string discovery(const ParticipantOptions& o) {
  // A participant that others look for by unicast has to listen on a port that they can know.
  const bool indexed = !o.multicast || !o.peers.empty();
  std::string peers;
  for (const std::string& peer : o.peers) peers += "<Peer address=\"" + escaped(peer) + "\"/>";
  std::string text = element("ExternalDomainId", std::to_string(o.domain));
  text += element("ParticipantIndex", indexed ? "auto" : "none");
  // Cyclone 0.10 does not use the last index, so that the greatest index is also how many there are.
  if (indexed) text += element("MaxAutoParticipantIndex", std::to_string(o.most_on_a_machine));
  text += element("SPDPInterval", kAnnounceEvery);
  if (!peers.empty()) text += element("Peers", peers);
  return element("Discovery", text);
}

std::string library(std::string_view what) {
  return "<Library initFunction=\"init_" + std::string(what) + "\" finalizeFunction=\"finalize_" + std::string(what) +
         "\" path=\"dds_security_" +
         (what == "authentication"   ? "auth"
          : what == "access_control" ? "ac"
                                     : "crypto") +
         "\"/>";
}

std::string security(const DdsSecurity& s) {
  if (!s.used()) return {};
  const auto file = [](std::string_view name, const std::string& path) {
    return element(name, "file:" + escaped(path));
  };
  const std::string authentication = library("authentication") + file("IdentityCA", s.identity_ca) +
                                     file("IdentityCertificate", s.certificate) + file("PrivateKey", s.private_key);
  const std::string access = library("access_control") + file("PermissionsCA", s.permissions_ca) +
                             file("Governance", s.governance) + file("Permissions", s.permissions);
  return element("Security", element("Authentication", authentication) + element("AccessControl", access) +
                                 element("Cryptographic", library("crypto")));
}

}  // namespace

std::string problem_of(const ParticipantOptions& o) {
  if (o.domain > ParticipantOptions::kMostDomain)
    return "domain " + std::to_string(o.domain) + ": from 0 to " + std::to_string(ParticipantOptions::kMostDomain);
  if (o.most_on_a_machine < 1 || o.most_on_a_machine > ParticipantOptions::kMostIndexed)
    return "participants on a machine: from 1 to " + std::to_string(ParticipantOptions::kMostIndexed);
  const auto odd = [](const std::string& text) {
    return text.empty() || std::any_of(text.begin(), text.end(), [](unsigned char c) { return c < 0x20; });
  };
  for (const std::string& name : o.interfaces)
    if (odd(name)) return "an interface without a name, or with control characters in it";
  for (const std::string& peer : o.peers)
    if (odd(peer)) return "a peer without an address, or with control characters in it";
  const DdsSecurity& s = o.security;
  if (s.used())
    for (const auto& [what, path] : {std::pair{"identity_ca", &s.identity_ca},
                                     {"certificate", &s.certificate},
                                     {"private_key", &s.private_key},
                                     {"permissions_ca", &s.permissions_ca},
                                     {"governance", &s.governance},
                                     {"permissions", &s.permissions}})
      if (odd(*path)) return std::string("security: ") + what + " is missing: it needs all six files";
  return {};
}

std::string config_xml(const ParticipantOptions& o) {
  return "<CycloneDDS><Domain Id=\"any\">" + general(o) + discovery(o) +
         element("Tracing", element("Verbosity", "warning") + element("OutputFile", "stderr")) + security(o.security) +
         o.extra + "</Domain></CycloneDDS>";
}

}  // namespace sinew::net
