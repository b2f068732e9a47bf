#pragma once
#include "robots/quad/world/quad.hpp"

namespace sinew::plant {

/// Quadrotors in a room. MuJoCo computes accelerations and contacts with +, -, *, / and sqrt only; the state is
/// integrated here, because its own integrator calls sin and cos of the C library.
/// Thread:  owner.
class QuadWorld final : public World {
 public:
  /// A vehicle for each of `robots`; the wind is as the first one's options say.
  /// Errors:  bad_data; bad_argument: two start in the same place.
  static hal::Result<std::unique_ptr<QuadWorld>> create(std::span<const QuadOptions> robots);
  static hal::Result<std::unique_ptr<QuadWorld>> create(const QuadOptions& options) { return create({&options, 1}); }
  ~QuadWorld() override;
  static WorldInfo info();

  /// Commands: order and unit as in vehicle.hpp; none: all 0.
  void advance(std::span<const RobotCommand> commands) override;
  msg::Time now() const override;
  std::size_t robots() const override;
  SimRobot& robot(std::size_t number) override { return quad(number); }
  Quad& quad(std::size_t number = 0);

 private:
  struct Impl;
  explicit QuadWorld(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace sinew::plant
