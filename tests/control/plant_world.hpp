#pragma once
// The plant as the world of a test flight: applies the delays of its sensors.
#include <deque>
#include <memory>

#include "robots/quad/world/quad_world.hpp"
#include "test_world.hpp"

namespace sinew::control::test {

class PlantWorld final : public TestWorld {
 public:
  explicit PlantWorld(const plant::QuadOptions& options) {
    p_base_camera = math::Vec3(plant::kCameraPBase);
    q_base_optical = math::Quat(plant::kCameraQBaseOptical);
    if (auto world = plant::QuadWorld::create(options)) world_ = std::move(*world);
  }
  bool good() const { return world_ != nullptr; }
  const plant::FlightSummary& summary() const { return world_->quad().summary(); }
  const plant::Quad& quad() const { return world_->quad(); }

  Truth truth() const override {
    const plant::TruthState t = world_->quad().truth();
    return {math::Vec3(t.p_world_m), math::Vec3(t.v_world_mps), math::Quat(t.q_world_base), math::Vec3(t.gyro_radps)};
  }
  Samples step(const std::array<double, 4>& command) override {
    const plant::Due& due = world_->step(command);
    if (due.range) ranges_.push_back(due.range_sample);
    if (due.baro) baros_.push_back(due.baro_sample);
    Samples s;
    s.now = world_->now();
    if (due.imu) s.imu = due.imu_sample;
    take(ranges_, s.now.ns - plant::kRangeDelayNs, s.range);
    take(baros_, s.now.ns - plant::kBaroDelayNs, s.baro);
    return s;
  }

 private:
  template <class M>
  static void take(std::deque<M>& waiting, std::int64_t until_ns, std::optional<M>& out) {
    if (waiting.empty() || waiting.front().stamp.ns > until_ns) return;
    out = waiting.front();
    waiting.pop_front();
  }
  std::unique_ptr<plant::QuadWorld> world_;
  std::deque<msg::RangeSample> ranges_;
  std::deque<msg::BaroSample> baros_;
};

}  // namespace sinew::control::test
