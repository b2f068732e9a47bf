#include "drivers/device_place.hpp"

#include <algorithm>

namespace sinew::drivers {
namespace {

constexpr std::string_view kGroups = "239.65.82.";  // wire/dronecan_udp.hpp
constexpr std::string_view kById = "/dev/v4l/by-id/", kFirst = "-video-index0";

std::string without_zeros(std::string_view number) {
  const std::size_t first = std::min(number.find_first_not_of('0'), number.size() - (number.empty() ? 0 : 1));
  return std::string(number.substr(first));
}

std::string place_of_group(std::string_view address) {
  const std::size_t colon = address.find(':');
  std::string_view number = address.substr(0, colon);
  if (number.starts_with(kGroups)) number.remove_prefix(kGroups.size());
  const std::string interface(colon == std::string_view::npos ? "lo" : address.substr(colon + 1));
  return without_zeros(number) + (interface == "lo" ? "" : ":" + interface);
}

std::string place_of_served(std::string_view address) {
  const std::size_t slash = std::min(address.rfind('/'), address.size());
  const std::string_view peer = address.substr(0, slash);
  const std::size_t colon = std::min(peer.rfind(':'), peer.size());
  std::string host(peer.substr(0, colon));
  if (host.size() > 2 && host.front() == '[' && host.back() == ']') host = host.substr(1, host.size() - 2);
  // Host names ignore case (RFC 4343).
  std::transform(host.begin(), host.end(), host.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  if (host == "127.0.0.1" || host == "::1") host = "localhost";
  const std::string port = colon < peer.size() ? without_zeros(peer.substr(colon + 1)) : "";
  return host + ':' + port + std::string(address.substr(slash));
}

}  // namespace

std::string place_of_path(std::string_view path) {
  std::string place;
  const bool absolute = path.starts_with('/');
  while (!path.empty()) {
    const std::size_t end = std::min(path.find('/'), path.size());
    const std::string_view part = path.substr(0, end);
    path.remove_prefix(std::min(end + 1, path.size()));
    if (part.empty() || part == ".") continue;
    if (absolute || !place.empty()) place += '/';
    place += part;
  }
  return place.empty() && absolute ? "/" : place;
}

std::string place_under(std::string place, std::string_view root) {
  const std::string folder = place_of_path(root);
  return folder == "/" ? place : place + " under " + folder;
}

std::string place_of_camera(std::string_view path) {
  if (!path.starts_with('/')) {  // the name below by-id, a bus or a name: only the first may have the ending
    if (path.ends_with(kFirst)) path.remove_suffix(kFirst.size());
    return std::string(path);
  }
  const std::string place = place_of_path(path);
  return place.starts_with(kById) ? place_of_camera(std::string_view(place).substr(kById.size())) : place;
}

std::string place_of_bus(std::string_view transport, std::string_view address) {
  if (transport == "udp") return place_of_group(address);
  if (transport == "socketcand") return place_of_served(address);
  return std::string(address);
}

}  // namespace sinew::drivers
