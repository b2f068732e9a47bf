// A beam on a hinge that falls to one side unless its motor holds it: the smallest world with a verdict.
#include <cstdio>

#include "math/elementary.hpp"
#include "math/random.hpp"
#include "robots/seesaw/devices.hpp"
#include "sim_hil/worlds/json_object.hpp"
#include "sim_hil/worlds/world.hpp"

namespace sinew::robots {

plant::WorldType describe_world_of_seesaw();

}  // namespace sinew::robots

namespace sinew::plant {
namespace {

constexpr double kStep_s = 1e-9 * kStepNs;
constexpr double kFall_radps2 = 4;    // per rad: its centre of mass is above the hinge
constexpr double kMotor_radps2 = 12;  // at full command
constexpr double kStop_rad = 0.3;     // where the beam lies on the ground
constexpr double kLevel_rad = 0.02, kSettle_s = 2, kMostTilt_deg = 2;
constexpr double kGyro_radps = 0.01, kAccel_mps2 = 0.1;  // noise, at most

class SeesawWorld final : public LoneRobot {
 public:
  SeesawWorld(std::uint64_t seed, double push_radps2) : random_(seed), push_radps2_(push_radps2) {
    pitch_rad_ = random_.uniform(0, 1) < 0.5 ? -kStop_rad : kStop_rad;
  }

  void advance(std::span<const RobotCommand> commands) override {
    const RobotCommand command = commands[0];
    const bool driven = !command.empty();
    const bool pushed = steps_ / kPushSteps % 2 == 1;
    double a_radps2 = kFall_radps2 * pitch_rad_ + (pushed ? push_radps2_ : 0);
    if (driven) a_radps2 += kMotor_radps2 * command[0];
    rate_radps_ += a_radps2 * kStep_s;
    pitch_rad_ += rate_radps_ * kStep_s;
    if (math::fabs(pitch_rad_) > kStop_rad) {
      pitch_rad_ = pitch_rad_ > 0 ? kStop_rad : -kStop_rad;
      rate_radps_ = 0;
    }
    still_ = !driven && rate_radps_ == 0;
    judge();
    ++steps_;
    due_.imu = steps_ % kImuSteps == 0;
    if (due_.imu) {
      msg::ImuSample& imu = due_.imu_sample;
      imu.stamp = now();
      imu.gyro_radps = {noise(kGyro_radps), rate_radps_ + noise(kGyro_radps), noise(kGyro_radps)};
      const auto turn = math::sincos(pitch_rad_);
      imu.accel_mps2 = {-kGravity * turn.sin + noise(kAccel_mps2), noise(kAccel_mps2),
                        kGravity * turn.cos + noise(kAccel_mps2)};
    }
    due_.truth = steps_ % kTruthSteps == 0;
  }
  const Due& due() const override { return due_; }
  msg::Time now() const override { return {static_cast<std::int64_t>(steps_) * kStepNs}; }
  WorldTruth ground_truth() const override {
    WorldTruth truth;
    const auto half = math::sincos(pitch_rad_ / 2);
    truth.q_world_base = {half.cos, 0, half.sin, 0};
    truth.gyro_radps = {0, rate_radps_, 0};
    return truth;
  }
  Scene scene(std::size_t /*camera*/) const override { return {}; }
  bool still() const override { return still_; }

  void add_to(JsonObject& report) const override { report.number("pitch_rad", pitch_rad_); }
  Verdict verdict() const override {
    Verdict verdict;
    const double tilt_deg = rms_rad() * 180 / math::kPi;
    verdict.measures = {{"level_s", "level after", "s", level_s_},
                        {"tilt_rms_deg", "tilt once level", "deg RMS", tilt_deg, kMostTilt_deg}};
    verdict.good = level_ && tilt_deg < kMostTilt_deg;
    if (!level_)
      verdict.outcome = "never got level";
    else
      verdict.outcome = verdict.good ? "kept the level" : "did not keep the level";
    return verdict;
  }
  std::string outcome() const override { return verdict().outcome; }

 private:
  static constexpr std::uint64_t kPushSteps = 8000;  // 2 s without, 2 s with

  double noise(double most) { return random_.uniform(-most, most); }
  double rms_rad() const { return judged_s_ > 0 ? math::sqrt(sum2_ / judged_s_) : 0; }
  void judge() {
    const double time_s = msg::seconds(now());
    if (!level_) {
      within_s_ = math::fabs(pitch_rad_) < kLevel_rad ? within_s_ + kStep_s : 0;
      level_ = within_s_ > 0.2;
      level_s_ = time_s;
    } else if (time_s > level_s_ + kSettle_s) {
      sum2_ += pitch_rad_ * pitch_rad_ * kStep_s;
      judged_s_ += kStep_s;
    }
  }

  math::Random random_;
  const double push_radps2_;
  double pitch_rad_ = 0, rate_radps_ = 0;
  std::uint64_t steps_ = 0;
  bool level_ = false, still_ = true;
  double within_s_ = 0, level_s_ = 0, sum2_ = 0, judged_s_ = 0;
  Due due_;
};

}  // namespace
}  // namespace sinew::plant

sinew::plant::WorldType sinew::robots::describe_world_of_seesaw() {
  using namespace plant;
  WorldType type;
  type.info = {"seesaw", kSeesawDevices, kSeesawWorldOptions};
  type.title = "a beam on a hinge that must be kept level";
  type.create = [info = type.info](const WorldChoice& choice,
                                   std::uint64_t seed) -> hal::Result<std::unique_ptr<World>> {
    const double push_radps2 = info.value(choice.values_of(0), "push_radps2").value();
    return std::unique_ptr<World>(std::make_unique<SeesawWorld>(seed, push_radps2));
  };
  return type;
}
