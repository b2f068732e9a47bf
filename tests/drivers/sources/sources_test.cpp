// Sources with a device that delivers, is silent, or breaks.
#include <gtest/gtest.h>

#include "drivers/sources/sensor_source.hpp"
#include "rt/exec/module_rig.hpp"

namespace sinew::drivers::sources_test {
namespace {

using namespace std::chrono_literals;

/// An IMU with `waiting` samples, after which it answers with `then`.
class FakeImu final : public hal::EmptyBoard, public hal::Imu {
 public:
  hal::Result<hal::Device*> open_sensor(hal::SensorKind kind, std::string_view name) override {
    if (kind != hal::SensorKind::imu || name != "imu") return hal::Error{hal::Errc::not_found, "imu"};
    return static_cast<hal::Imu*>(this);
  }
  hal::Time ready_at() const noexcept override { return {}; }
  void set_wake(hal::Wake*) noexcept override {}
  hal::Result<bool> read(msg::ImuSample& out) noexcept override {
    ++reads;
    if (waiting == 0) return then;
    --waiting;
    out.stamp = {++stamp};
    return true;
  }
  int waiting = 0, reads = 0;
  std::int64_t stamp = 0;
  hal::Result<bool> then = false;
};

TEST(SensorSource, EverySampleBecomesAMessageInItsOrder) {
  FakeImu imu;
  ImuSource source;
  rt::ModuleRig rig(source, {.board = &imu});
  imu.waiting = 3;
  EXPECT_EQ(rig.step({1'000'000}, 1ms), rt::StepStatus::ok);
  const auto all = rig.all<msg::ImuSample>("raw");
  ASSERT_EQ(all.size(), 3u);
  EXPECT_EQ(all[0]->stamp.ns, 1);
  EXPECT_EQ(all[2]->stamp.ns, 3);
}

TEST(SensorSource, SilentDeviceIsStale) {
  FakeImu imu;
  ImuSource source;
  rt::ModuleRig rig(source, {.board = &imu});
  EXPECT_EQ(rig.step({1'000'000}, 1ms), rt::StepStatus::stale);
  EXPECT_EQ(imu.reads, 1);
}

TEST(SensorSource, DeviceThatOnlyFailsIsReadOnceACycle) {
  FakeImu imu;
  imu.then = hal::Error{hal::Errc::bad_data, "broken"};
  ImuSource source;
  rt::ModuleRig rig(source, {.board = &imu});
  EXPECT_EQ(rig.step({1'000'000}, 1ms), rt::StepStatus::stale);
  EXPECT_EQ(imu.reads, 1) << "collect() is bounded, whatever the device says";
}

TEST(SensorSource, DeviceThatIsNotThereIsNamed) {
  FakeImu imu;
  ImuSource source;
  rt::ModuleRig rig(source, {.board = &imu});
  rig.set("device", std::string("imu7"));
  EXPECT_FALSE(rig.configure());
}

/// Hears `waiting` datagrams.
class FakeRadio final : public hal::EmptyBoard, public hal::Radio {
 public:
  hal::Result<hal::Radio*> radio(std::string_view name) override {
    if (name != "radio") return hal::Error{hal::Errc::not_found, "radio"};
    return this;
  }
  hal::Time ready_at() const noexcept override { return {}; }
  void set_wake(hal::Wake*) noexcept override {}
  hal::Result<bool> read(msg::Datagram& out) noexcept override {
    if (waiting == 0) return false;
    --waiting;
    out.size = 1, out.data[0] = ++heard;
    return true;
  }
  hal::Status send(std::span<const std::uint8_t>) noexcept override { return {}; }
  hal::RadioStats stats() const noexcept override { return {}; }
  int waiting = 0;
  std::uint8_t heard = 0;
};

TEST(RadioSource, EveryDatagramBecomesAMessageAndAFloodIsLeftToTheDevice) {
  FakeRadio radio;
  RadioSource source;
  rt::ModuleRig rig(source, {.board = &radio});
  EXPECT_EQ(rig.step({1'000'000}, 1ms), rt::StepStatus::stale) << "nobody is heard";
  radio.waiting = 1000;
  EXPECT_EQ(rig.step({2'000'000}, 1ms), rt::StepStatus::ok);
  const auto all = rig.all<msg::Datagram>("raw");
  ASSERT_EQ(all.size(), 20u);
  for (std::size_t i = 0; i < all.size(); ++i) EXPECT_EQ(all[i]->bytes()[0], i + 1);
  EXPECT_GE(radio.waiting, 979);
}

TEST(RadioSource, ARadioThatIsNotThereIsNamed) {
  FakeRadio radio;
  RadioSource source;
  rt::ModuleRig rig(source, {.board = &radio});
  rig.set("device", std::string("air"));
  EXPECT_FALSE(rig.configure());
}

}  // namespace
}  // namespace sinew::drivers::sources_test
