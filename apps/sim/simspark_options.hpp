#pragma once
#include <string>

#include "sim_hil/simspark/server.hpp"

namespace CLI {
class App;
}

namespace sinew::plant {

/// What only --serve simspark has a use for.
struct SimsparkOptions {
  static constexpr const char* kListen = "tcp:127.0.0.1:3100";
  static constexpr const char* kWorld = "soccer";

  std::string monitor_listen = "tcp:127.0.0.1:3200";  // "none": no monitors
  std::size_t players = 2, agents = 1;
  bool sync = false, exact_beam = false;
  double kick_off_s = 0, half_s = 300, patience_s = 10;

  void describe(CLI::App& app);
  /// The first of these options that was given; null: none.
  static const char* given(const CLI::App& app);
  /// Of "simspark:3101" the place to listen; "simspark" alone: kListen. Empty: it is neither.
  static std::string listen_of(const std::string& serve);

  simspark::ServerOptions server() const;
};

}  // namespace sinew::plant
