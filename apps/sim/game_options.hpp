#pragma once
#include <memory>
#include <string>
#include <vector>

#include "hal/os.hpp"
#include "sim_hil/plant/game_feed.hpp"

namespace CLI {
class App;
}

namespace sinew::plant {

struct WorldChoice;

/// The options of sinew-sim that send what the world's referee says as packets of RoboCup's game controller.
struct GameOptions {
  std::vector<std::string> to;
  std::string teams = "1,2";
  std::string version = "19";
  std::uint16_t answers = wire::kGameAnswerPort;

  void describe(CLI::App& app);
  /// Reads them; an empty text, or what is wrong.
  std::string read(const CLI::App& app, const WorldChoice& world);
  bool any() const { return !to.empty(); }

  // Set by read().
  std::vector<hal::UdpAddress> peers;
  GameFeedOptions feed;
};

/// The feed and what it sends by.
struct GameSender {
  std::unique_ptr<hal::Radio> radio;
  std::unique_ptr<GameFeed> feed;
};
/// False after printing why.
bool open_game(const GameOptions& options, std::size_t robots, hal::Os& os, GameSender& sender);

}  // namespace sinew::plant
