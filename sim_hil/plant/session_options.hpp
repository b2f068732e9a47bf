#pragma once
#include <optional>

#include "sim_hil/plant/game_feed.hpp"
#include "sim_hil/plant/wire_devices.hpp"
#include "sim_hil/protocol.hpp"
#include "sim_hil/worlds/world.hpp"

namespace sinew::plant {

inline constexpr hal::Duration kExchange{1'000'000};  // from one with the runtimes to the next

/// Takes down what each picture of a run depends on, so that all of them can be drawn again.
/// Thread:  the session's.
class SceneSink {
 public:
  virtual ~SceneSink() = default;
  /// A camera of a robot takes its picture of this number now. `scene` is good until it returns.
  virtual void picture(std::size_t robot, std::size_t camera, std::uint32_t number, hal::Time at,
                       const Scene& scene) = 0;
};

struct SessionOptions {
  WorldChoice world;                  // the camera draws its room
  std::optional<std::uint64_t> seed;  // instead of the one that the runtime asks for
  std::optional<sim_hil::Mode> only;  // refuse the other mode
  double duration_s = 0;              // plant time until the plant ends the run; 0: the runtime ends it
  std::vector<Fault> faults;          // docs/faults.md; each of one robot
  double relink_s = 5;                // free-running, by a listener: how long the world waits for another runtime
  int fifo_priority = 85;             // of the physics thread, free-running: above the robot's threads, like a device
  SceneSink* scenes = nullptr;        // null: nobody takes them down. Not owned
  WireDevices* wire = nullptr;        // parts of the world at the wire, besides; free-running, one robot. Not owned
  GameFeed* game = nullptr;           // what the world's referee says, as packets of a game controller. Not owned
};

}  // namespace sinew::plant
