#pragma once
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "hal/os.hpp"
#include "hal/stream.hpp"
#include "sim_hil/door_clients.hpp"
#include "sim_hil/usarsim/image_session.hpp"
#include "sim_hil/usarsim/session.hpp"

namespace sinew::usarsim {

/// The sockets around the sessions, and the place's clock: real time, or faster where `rate` says so.
/// Thread:  owner: run() is the loop; nothing in it waits but for the clock.
class Server {
 public:
  static constexpr std::size_t kMostClients = 64, kMostImageClients = 16;
  static constexpr hal::Duration kTick = std::chrono::milliseconds(5);
  static constexpr int kMostLateTicks = 20;  // a tick that is later than this starts the clock anew

  struct Doors {
    std::unique_ptr<hal::Listener> text, images;             // images: null without a renderer
    std::function<std::string(const hal::Stream&)> address;  // of a client, without its port
  };
  Server(hal::Os& os, Game& game, Doors doors, Painter* painter);

  /// Until `stop` says so, or the duration of plant time is over; 0: none. Returns how often the clock had to start
  /// anew.
  std::uint64_t run(double duration_s, const std::function<bool()>& stop);
  /// One tick without waiting: for tests.
  void tick();
  /// Ends all connections.
  void close() { clients_.clear(), image_clients_.clear(); }

 private:
  void serve_pictures();

  hal::Os& os_;
  Game& game_;
  Doors doors_;
  std::vector<sim_hil::DoorClient<Session>> clients_;
  std::vector<sim_hil::DoorClient<ImageSession>> image_clients_;
  std::unique_ptr<PictureMaker> pictures_;
  ImageSession* shown_ = nullptr;  // whose picture is being made
  std::size_t turn_ = 0;           // whose picture is next
  std::uint64_t number_ = 0;
};

}  // namespace sinew::usarsim
