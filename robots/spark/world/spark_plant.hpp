#pragma once
#include <functional>
#include <memory>
#include <string>

#include "hal/stream.hpp"
#include "robots/spark/devices.hpp"
#include "sim_hil/worlds/world.hpp"

namespace sinew::plant {

/// The server that a robot plays in, and its team there.
struct SparkServer {
  std::function<hal::Result<std::unique_ptr<hal::Stream>>()> connect;
  std::string team;
};

/// A server of SimSpark as the world of one robot: our time goes on with its cycles, in lockstep by (syn). 4 ms after a
/// cycle's percepts the joints' targets go out as speeds; the percepts of the next cycle are there at its end. No truth
/// is known here: the report is made of what the robot's own sensors say, its place of the landmarks that it saw.
/// Thread:  owner; advance() waits for the server, once in 20 ms.
class SparkPlant final : public LoneRobot {
 public:
  static WorldInfo info();
  /// Connects, takes a body and a number, beams, and waits until the robot stands there.
  /// Errors:  bad_argument (a body that is not of the class of Nao), those of the connection, bad_data (its
  ///          messages are none); `why` has it in words.
  static hal::Result<std::unique_ptr<SparkPlant>> create(const WorldChoice& choice, const SparkServer& server,
                                                         std::string& why);
  ~SparkPlant() override;

  /// Targets of joints, limb after limb (kKidLimbJoints), rad; NaN: stand still. Once the server is gone nothing is due
  /// any more, and the verdict says so.
  void advance(std::span<const RobotCommand> commands) override;
  msg::Time now() const override;

  const Due& due() const override;
  WorldTruth ground_truth() const override;
  Scene scene(std::size_t camera) const override;
  bool still() const override;
  std::uint32_t news() const override;
  void add_to(JsonObject& report) const override;
  Verdict verdict() const override;
  std::string outcome() const override;

 private:
  struct Impl;
  explicit SparkPlant(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

/// The world "simspark" in this server. The type in the list of worlds has none, and makes nothing.
std::shared_ptr<const WorldType> spark_world_in(const WorldType& type, SparkServer server);

}  // namespace sinew::plant
