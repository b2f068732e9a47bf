#pragma once
#include "robots/quad/world/quad.hpp"
#include "robots/terrain/world/ground.hpp"

namespace sinew::plant {

struct TerrainOptions {
  Terrain terrain = Terrain::hills;
  double motion_radps = 0.75;  // the vehicle is meant to hold this motion of the ground
  QuadOptions quad;            // without the start, which the terrain says
};

/// How a height over ground is held. The right height is the speed over ground divided by the wanted motion.
/// Thread:  owner.
class HeightScore {
 public:
  explicit HeightScore(double motion_radps) : motion_radps_(motion_radps) {}
  /// A step of `dt_s` in the air over the terrain, at this height and speed over ground.
  void add(double height_m, double speed_mps, double dt_s);

  double seconds() const { return seconds_; }
  double least_m() const { return least_m_; }
  double mean_speed_mps() const { return seconds_ > 0 ? speed_sum_ / seconds_ : 0; }
  double mean_height_m() const { return seconds_ > 0 ? height_sum_ / seconds_ : 0; }
  /// Of the time, with the height within kMostOff of the right one.
  double share_within() const { return seconds_ > 0 ? within_s_ / seconds_ : 0; }
  /// The height's error as a share of the right height: RMS, and the largest of its mean over kMoment_s.
  double off_rms() const;
  double off_most() const { return most_; }

  static constexpr double kMostOff = 0.25, kMoment_s = 1;

 private:
  double motion_radps_;
  double seconds_ = 0, within_s_ = 0, off2_sum_ = 0, speed_sum_ = 0, height_sum_ = 0;
  double least_m_ = 1e9, smooth_ = 0, most_ = 0;
};

/// A quadrotor over hills, steps or buildings. It judges whether it flew over them without touching the ground, and at
/// the right height.
/// Thread:  owner.
class TerrainWorld final : public LoneRobot {
 public:
  /// Errors:  bad_data.
  static hal::Result<std::unique_ptr<TerrainWorld>> create(const TerrainOptions& options);
  ~TerrainWorld() override;

  void advance(std::span<const RobotCommand> commands) override;
  msg::Time now() const override;
  const Due& due() const override;
  WorldTruth ground_truth() const override;
  Scene scene(std::size_t camera) const override;
  bool still() const override;
  void add_to(JsonObject& report) const override;
  Verdict verdict() const override;
  std::string outcome() const override;

  Quad& quad();
  const HeightScore& score() const;
  /// Of the base, over the ground under it.
  double height_m() const;

 private:
  struct Impl;
  explicit TerrainWorld(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace sinew::plant
