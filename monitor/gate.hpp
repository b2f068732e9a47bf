#pragma once
#include <chrono>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "monitor/http/server.hpp"

namespace sinew::monitor {

/// Who may ask for what. Reading: whoever reaches the address by a name of ours (a page of another site does not, also
/// not by a name of its own that leads here). Writing: who has the token.
/// Thread:  one.
class Gate {
 public:
  struct Options {
    std::vector<std::string> hosts{};  // names by which a browser may call us, with port ("127.0.0.1:8080")
    std::string token{};
    bool commands = true;  // false: none, since the address can be reached from outside and nothing is encrypted
  };
  explicit Gate(Options options) : options_(std::move(options)) {}

  /// Why not, and the status of HTTP that says so.
  struct Refusal {
    int status;
    std::string why;
  };
  /// Nothing: it may read. Else 400 without Host, 403 by a wrong one or from a page of another site.
  std::optional<Refusal> refuses(const Request& request) const;
  /// Nothing: it may write, too ("Authorization: Bearer TOKEN"). Else 401, 403, or 429 after kMostWrong wrong tokens
  /// of one peer within kWrongFor.
  std::optional<Refusal> refuses_command(const Request& request);
  /// The same for a token that came in another way, from `peer`.
  std::optional<Refusal> refuses_token(std::string_view token, const std::string& peer);
  /// Whether this is our token, which is nobody else's business.
  bool is_our_token(std::string_view token) const;
  bool takes_commands() const { return options_.commands; }

  static constexpr unsigned kMostWrong = 10;
  static constexpr std::chrono::seconds kWrongFor{60};
  static constexpr std::size_t kMostPeers = 1024;  // that are remembered

 private:
  using Clock = std::chrono::steady_clock;
  struct Wrong {
    unsigned count = 0;
    Clock::time_point first{};
  };
  const Options options_;
  std::map<std::string, Wrong> wrong_;  // by peer
};

/// Of the header "Authorization: Bearer TOKEN"; empty: there is none.
std::string_view bearer_token(const Request& request);

/// 32 random bytes as 64 hex digits. Errors: empty when the system has none.
std::string new_token();

/// Whether both are equal; takes the same time wherever they differ.
bool equal_in_constant_time(std::string_view a, std::string_view b);

}  // namespace sinew::monitor
