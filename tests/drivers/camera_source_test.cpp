// From a camera of the Linux board into the graph: the real driver code on a simulated V4L2 device.
#include "drivers/camera_source.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "hal/linux/os.hpp"
#include "hal/linux/v4l2_camera.hpp"
#include "hal/linux/v4l2_sim.hpp"
#include "rt/module_rig.hpp"

namespace sinew::drivers {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;

constexpr std::uint32_t kWidth = 320, kHeight = 240;

/// A board whose "camera" is a V4l2Camera on a device in memory.
class CameraBoard final : public hal::EmptyBoard {
 public:
  explicit CameraBoard(hal::V4l2SimCamera pretends = {}) : sim(std::move(pretends)) {
    hal::CameraSpec spec;
    spec.path = "/dev/video0", spec.width = kWidth, spec.height = kHeight;
    std::string why;
    auto opened = hal::V4l2Camera::open(sim, spec, hal::linux_os(), nullptr, {}, why);
    EXPECT_TRUE(opened) << why;
    if (opened) device = std::move(*opened);
  }
  hal::Result<hal::Camera*> camera(std::string_view name) override {
    if (name != "camera") return hal::Error{hal::Errc::not_found, "camera"};
    return static_cast<hal::Camera*>(device.get());
  }
  void deliver(std::uint32_t number) {
    msg::ImageBuffer picture(msg::PixelFormat::yuyv, kWidth, kHeight);
    std::fill_n(picture->pixels(), picture->bulk_used(), static_cast<std::uint8_t>(number));
    EXPECT_TRUE(sim.deliver(*picture, hal::Time{1'000'000} + number * 33ms));
  }
  hal::V4l2Sim sim;
  std::unique_ptr<hal::V4l2Camera> device;
};

bool eventually(const std::function<bool()>& holds) {
  const hal::Time deadline = hal::linux_os().now() + 10s;
  while (!holds()) {
    if (hal::linux_os().now() >= deadline) return false;
    hal::linux_os().sleep_until(hal::linux_os().now() + 1ms);
  }
  return true;
}

TEST(CameraSource, FramesBecomeMessagesInTheirOrder) {
  CameraBoard board;
  CameraSource source;
  rt::ModuleRig rig(source, {.board = &board});
  EXPECT_EQ(rig.step({1'000'000}, 1ms), rt::Status::stale) << "nothing was delivered";
  board.deliver(1), board.deliver(2);
  EXPECT_EQ(rig.step({2'000'000}, 1ms), rt::Status::ok);
  const auto all = rig.all<msg::Image>("raw");
  ASSERT_EQ(all.size(), 2u);
  EXPECT_EQ(all[0]->pixels()[0], 1);
  EXPECT_EQ(all[1]->pixels()[all[1]->bulk_used() - 1], 2);
  EXPECT_EQ(all[1]->stamp, hal::Time{1'000'000} + 2 * 33ms);
}

TEST(CameraSource, StampsAreShiftedByTheCalibratedOffset) {
  CameraBoard board;
  CameraSource source;
  rt::ModuleRig rig(source, {.board = &board});
  rig.set("time_offset_ms", -12.5);
  board.deliver(1);
  ASSERT_EQ(rig.step({2'000'000}, 1ms), rt::Status::ok);
  EXPECT_EQ(rig.all<msg::Image>("raw")[0]->stamp, hal::Time{1'000'000} + 33ms - 12'500us);
}

TEST(CameraSource, CameraThatIsGoneIsStaleAndComesBack) {
  CameraBoard board;
  CameraSource source;
  rt::ModuleRig rig(source, {.board = &board});
  board.sim.unplug();
  EXPECT_EQ(rig.step({1'000'000}, 1ms), rt::Status::stale);
  EXPECT_EQ(rig.step({2'000'000}, 1ms), rt::Status::stale);
  board.sim.plug_in();
  ASSERT_TRUE(eventually([&] { return board.device->stats().reopens == 1; }));
  board.deliver(3);
  EXPECT_EQ(rig.step({3'000'000}, 1ms), rt::Status::ok);
}

TEST(CameraSource, ExposureAndGainReachTheDevice) {
  CameraBoard board;
  CameraSource source;
  rt::ModuleRig rig(source, {.board = &board});
  rig.set("exposure_us", 4000.0);
  rig.set("gain", 33.0);
  static_cast<void>(rig.step({1'000'000}, 1ms));
  EXPECT_TRUE(eventually([&] {
    return board.sim.control("Exposure Time, Absolute") == 40 && board.sim.control("Auto Exposure") == 1 &&
           board.sim.control("Gain") == 33;
  }));
  rig.set("exposure_us", 7000.0);
  static_cast<void>(rig.step({2'000'000}, 1ms));
  EXPECT_TRUE(eventually([&] { return board.sim.control("Exposure Time, Absolute") == 70; }));
}

TEST(CameraSource, ParametersLeftAloneLeaveTheCameraAlone) {
  CameraBoard board;
  CameraSource source;
  rt::ModuleRig rig(source, {.board = &board});
  static_cast<void>(rig.step({1'000'000}, 1ms));
  EXPECT_EQ(board.sim.control("Auto Exposure"), 3);
  EXPECT_EQ(board.sim.control("Gain"), 20);
}

TEST(CameraSource, GainOfACameraWithoutOneIsRefusedWithWhatItHas) {
  hal::V4l2SimCamera without;
  without.controls.erase(without.controls.begin());
  CameraBoard board(without);
  CameraSource source;
  rt::ModuleRig rig(source, {.board = &board});
  rig.set("gain", 33.0);
  const hal::Status configured = rig.configure();
  ASSERT_FALSE(configured);
  EXPECT_EQ(configured.error().code, hal::Errc::not_supported);
  ASSERT_FALSE(rig.problems().empty());
  EXPECT_THAT(rig.problems()[0].allowed,
              HasSubstr("param 'gain': the camera has no such control; it has: auto_exposure"));
}

TEST(CameraSource, GainOutsideOfTheDevicesRangeIsRefusedWithTheRange) {
  CameraBoard board;
  CameraSource source;
  rt::ModuleRig rig(source, {.board = &board});
  rig.set("gain", 200.0);
  ASSERT_FALSE(rig.configure());
  ASSERT_FALSE(rig.problems().empty());
  EXPECT_THAT(rig.problems()[0].allowed, HasSubstr("param 'gain': the camera allows gain 0 to 100"));
}

}  // namespace
}  // namespace sinew::drivers
