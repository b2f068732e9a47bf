#include "monitor/gate.hpp"

#include <fmt/format.h>
#include <sys/random.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <utility>

namespace sinew::monitor {
namespace {

std::string lower(std::string_view text) {
  std::string out(text);
  for (char& c : out) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return out;
}

}  // namespace

std::optional<Gate::Refusal> Gate::refuses(const Request& request) const {
  const std::string host = lower(request.host);
  if (host.empty()) return Refusal{400, "a request needs the header Host"};
  if (std::find(options_.hosts.begin(), options_.hosts.end(), host) == options_.hosts.end())
    return Refusal{403, fmt::format("this monitor is not called '{}'; --host NAME adds a name", request.host)};
  if (!request.origin.empty()) {
    const std::string origin = lower(request.origin);
    if (origin != "http://" + host && origin != "https://" + host)
      return Refusal{403, fmt::format("pages of {} may not ask this monitor", request.origin)};
  }
  return std::nullopt;
}

std::string_view bearer_token(const Request& request) {
  constexpr std::string_view kScheme = "Bearer ";
  const std::string_view given = request.authorization;
  return given.starts_with(kScheme) ? given.substr(kScheme.size()) : std::string_view();
}

bool Gate::is_our_token(std::string_view token) const { return equal_in_constant_time(token, options_.token); }

std::optional<Gate::Refusal> Gate::refuses_command(const Request& request) {
  if (options_.commands && request.authorization.empty())
    return Refusal{401, "a command needs the header Authorization: Bearer TOKEN"};
  return refuses_token(bearer_token(request), request.peer);
}

std::optional<Gate::Refusal> Gate::refuses_token(std::string_view token, const std::string& peer) {
  if (!options_.commands)
    return Refusal{403, "no commands from here: this address can be reached from outside and has no TLS (--tls)"};
  const auto now = Clock::now();
  std::erase_if(wrong_, [&](const auto& entry) { return now - entry.second.first > kWrongFor; });
  const auto known = wrong_.find(peer);
  const bool is_new = known == wrong_.end();
  if (is_new ? wrong_.size() >= kMostPeers : known->second.count >= kMostWrong)
    return Refusal{429, "too many wrong tokens; try again in a minute"};
  if (equal_in_constant_time(token, options_.token)) return std::nullopt;
  Wrong& wrong = wrong_[peer];
  if (wrong.count++ == 0) wrong.first = now;
  return Refusal{401, "wrong token"};
}

std::string new_token() {
  std::array<unsigned char, 32> bytes;
  if (getrandom(bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size())) return {};
  std::string text;
  for (const unsigned char b : bytes) text += fmt::format("{:02x}", b);
  return text;
}

bool equal_in_constant_time(std::string_view a, std::string_view b) {
  unsigned difference = a.size() == b.size() ? 0 : 1;
  for (std::size_t i = 0; i < b.size(); ++i)
    difference |= static_cast<unsigned char>(b[i]) ^ (i < a.size() ? static_cast<unsigned char>(a[i]) : 0u);
  return difference == 0 && !b.empty();
}

}  // namespace sinew::monitor
