#pragma once
#include <string>

#include "sim_hil/usarsim/game.hpp"

namespace CLI {
class App;
}

namespace sinew::plant {

/// What --serve usarsim lets its user choose.
struct UsarsimOptions {
  std::string image_listen = "tcp:127.0.0.1:5003", image_type = "good", sonar = "together";
  bool right_hand = false, legacy_images = false;

  static constexpr const char* kListen = "tcp:127.0.0.1:3000";  // unless --listen says otherwise
  static constexpr const char* kWorld = "air_robot";            // unless --world does

  void describe(CLI::App& app);
  /// The first of its options that was given; null: none was.
  static const char* given(const CLI::App& app);
  usarsim::Options door(std::uint32_t width, std::uint32_t height) const;
};

}  // namespace sinew::plant
