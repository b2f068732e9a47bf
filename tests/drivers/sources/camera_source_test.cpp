// From a camera of the Linux board into the graph: the real driver code on a simulated V4L2 device.
#include "drivers/sources/camera_source.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <linux/videodev2.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <set>

#include "drivers/board/device_board.hpp"
#include "drivers/board/driver_list.hpp"
#include "hal/linux/camera/v4l2_camera.hpp"
#include "hal/linux/camera/v4l2_sim.hpp"
#include "hal/platform.hpp"
#include "hal/silent_board.hpp"
#include "rt/exec/module_rig.hpp"

namespace sinew::drivers::camera_source_test {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;

constexpr std::uint32_t kWidth = 320, kHeight = 240;

bool eventually(const std::function<bool()>& holds) {
  const hal::Time deadline = hal::system_os().now() + 10s;
  while (!holds()) {
    if (hal::system_os().now() >= deadline) return false;
    hal::system_os().sleep_until(hal::system_os().now() + 1ms);
  }
  return true;
}

/// A board whose "camera" is a V4l2Camera on a device in memory.
class CameraBoard final : public hal::EmptyBoard {
 public:
  explicit CameraBoard(hal::V4l2SimCamera pretends = {},
                       hal::CameraSpec::Memory memory = hal::CameraSpec::Memory::automatic)
      : sim(std::move(pretends)) {
    hal::CameraSpec spec;
    spec.memory = memory;
    spec.path = "/dev/video0", spec.width = kWidth, spec.height = kHeight;
    std::string why;
    auto opened = hal::V4l2Camera::open(sim, spec, hal::system_os(), nullptr, {}, why);
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

/// The driver puts pictures into the topic's own slots: the module, on its own board.
struct Lending {
  explicit Lending(hal::V4l2SimCamera pretends = {}) : board(std::move(pretends)) {}
  /// One step, a millisecond after the last.
  rt::StepStatus step() { return rig.step(hal::Time{++now * 1'000'000}, 1ms); }
  void rest() { rig.rest(hal::Time{++now * 1'000'000}); }
  /// Steps until the camera streams into so many lent slots.
  bool streams() {
    return eventually([&] {
      static_cast<void>(step());
      return board.sim.streams() && board.sim.queued() == kBuffers && is_open();
    });
  }

  /// The camera's own thread has its hands off the stream.
  bool is_open() const { return board.device->state().find("): streaming ") != std::string::npos; }

  static constexpr std::size_t kBuffers = 4;
  CameraBoard board;
  CameraSource source;
  rt::ModuleRig rig{source, {.board = &board}};
  std::int64_t now = 0;
};

TEST(CameraSourceLends, DriverFillsTheVerySlotThatSubscribersSee) {
  Lending run;
  ASSERT_TRUE(run.streams());
  std::set<const void*> slots;
  for (std::uint32_t n = 1; n <= 50; ++n) {
    run.board.deliver(n);
    ASSERT_EQ(run.step(), rt::StepStatus::ok) << n;
    const auto* image = run.rig.get<msg::Image>("raw");
    ASSERT_NE(image, nullptr);
    ASSERT_EQ(image->pixels(), run.board.sim.filled()) << "no byte was moved";
    ASSERT_EQ(image->pixels()[image->bulk_used() - 1], static_cast<std::uint8_t>(n));
    ASSERT_EQ(image->stamp, hal::Time{1'000'000} + n * 33ms);
    ASSERT_EQ(run.board.sim.queued(), Lending::kBuffers) << "another slot took its place";
    slots.insert(image);
  }
  EXPECT_GT(slots.size(), Lending::kBuffers) << "the slots of the topic go round";
  EXPECT_EQ(run.board.device->stats().frames, 50u);
  EXPECT_EQ(run.board.device->stats().lost, 0u);
  EXPECT_EQ(run.board.sim.mapped(), 0u);
  EXPECT_EQ(run.board.device->path_of_pixels(), "the driver fills the topic's slots");
}

TEST(CameraSourceLends, FramesThatMeetNoSlotAreCountedAsLost) {
  Lending run;
  ASSERT_TRUE(run.streams());
  msg::ImageBuffer picture(msg::PixelFormat::yuyv, kWidth, kHeight);
  for (std::uint32_t n = 1; n <= 6; ++n) {
    EXPECT_EQ(run.board.sim.deliver(*picture, hal::Time{1'000'000} + n * 33ms), n <= 4);
  }
  EXPECT_EQ(run.step(), rt::StepStatus::ok);
  EXPECT_EQ(run.step(), rt::StepStatus::ok);
  run.board.deliver(7);
  EXPECT_EQ(run.step(), rt::StepStatus::ok);
  EXPECT_EQ(run.rig.get<msg::Image>("raw")->frame_number, 6u);
  EXPECT_EQ(run.board.device->stats().lost, 2u);
}

TEST(CameraSourceLends, UnpluggedAndPluggedInAgainTheCameraGoesOnWithTheSameSlots) {
  Lending run;
  std::uint32_t n = 0, last = 0;
  for (int round = 0; round < 10; ++round) {
    ASSERT_TRUE(run.streams()) << run.board.device->state();
    run.board.deliver(++n);
    ASSERT_EQ(run.step(), rt::StepStatus::ok);
    ASSERT_EQ(run.rig.all<msg::Image>("raw").size(), 1u) << "nothing comes twice";
    const auto* image = run.rig.get<msg::Image>("raw");
    EXPECT_EQ(image->pixels(), run.board.sim.filled());
    EXPECT_EQ(image->pixels()[0], n);
    if (n > 1) {
      EXPECT_GT(image->frame_number, last);
    }
    last = image->frame_number;
    run.board.deliver(++n);  // filled, and never taken
    run.board.sim.unplug();
    ASSERT_EQ(run.step(), rt::StepStatus::stale);
    run.board.sim.plug_in();
  }
}

TEST(CameraSourceLends, SwitchedOffItHasAllSlotsBackAndTheCameraStops) {
  Lending run;
  for (int round = 0; round < 5; ++round) {
    ASSERT_TRUE(run.streams());
    ASSERT_TRUE(eventually([&] {
      run.rest();
      return !run.board.sim.streams() && run.board.sim.queued() == 0;
    }));
    EXPECT_TRUE(run.rig.headers("raw").empty());
  }
  run.board.sim.unplug();
  run.rest();
  run.board.sim.plug_in();
  ASSERT_TRUE(run.streams());
  run.board.deliver(1);
  EXPECT_EQ(run.step(), rt::StepStatus::ok);
}  // and that nothing is held at the end, the rig looks

TEST(CameraSourceLends, EndWhileTheCameraIsGoneGivesAllBack) {
  Lending run;
  ASSERT_TRUE(run.streams());
  run.board.sim.unplug();
}

TEST(CameraSourceLends, DriverWithoutUserPointersIsReadWithOnePass) {
  hal::V4l2SimCamera old;
  old.user_pointers = false;
  Lending run(old);
  EXPECT_EQ(run.step(), rt::StepStatus::stale);
  run.board.deliver(1);
  ASSERT_EQ(run.step(), rt::StepStatus::ok);
  EXPECT_NE(run.rig.get<msg::Image>("raw")->pixels(), run.board.sim.filled());
  EXPECT_THAT(run.board.device->path_of_pixels(),
              HasSubstr("pixels are copied once: the driver does not take memory of the caller (VIDIOC_REQBUFS: "));
}

TEST(CameraSourceLends, DriverThatRefusesTheSlotsAtTheLastMomentIsReadFromThenOn) {
  Lending run;
  ASSERT_TRUE(run.rig.configure());
  run.board.sim.refuse(VIDIOC_QBUF, EFAULT);
  EXPECT_EQ(run.step(), rt::StepStatus::stale);
  run.board.sim.refuse(VIDIOC_QBUF, 0);
  ASSERT_TRUE(eventually([&] {
    static_cast<void>(run.step());
    return run.board.sim.streams();
  }));
  ASSERT_EQ(run.board.sim.mapped(), Lending::kBuffers);
  run.board.deliver(1);
  ASSERT_TRUE(eventually([&] { return run.step() == rt::StepStatus::ok; }));
  EXPECT_EQ(run.board.device->path_of_pixels(),
            "pixels are copied once: the driver refuses the topic's memory (Bad address)");
}

TEST(CameraSourceLends, MemoryOfTheTableIsOneOfThreeWords) {
  const auto problems_of = [](const char* word) {
    DeviceSpec camera;
    camera.name = "camera", camera.driver = "v4l2";
    camera.keys["path"] = {std::string("/dev/video0"), 1};
    camera.keys["memory"] = {std::string(word), 2};
    DeviceSpecs specs;
    specs.devices.push_back(camera);
    std::string text;
    for (const auto& p : check_devices(specs, all_drivers())) text += rt::to_string(p, "robot.toml") + "\n";
    return text;
  };
  for (const char* word : {"auto", "mmap", "userptr"}) EXPECT_EQ(problems_of(word), "") << word;
  EXPECT_THAT(problems_of("dmabuf"), HasSubstr("robot.toml:2: device.camera.memory"));
  EXPECT_THAT(problems_of("dmabuf"), HasSubstr("one of \"auto\", \"mmap\", \"userptr\""));
}

TEST(CameraSourceLends, LendOrNothingIsRefusedWithTheReason) {
  CameraBoard board({}, hal::CameraSpec::Memory::lent);
  CameraSource source;
  rt::ModuleRig rig(source, {.board = &board});
  rig.image_capacity("raw", kWidth * kHeight);
  EXPECT_FALSE(rig.configure());
  ASSERT_FALSE(rig.problems().empty());
  EXPECT_EQ(
      rig.problems()[0].allowed,
      "device 'camera': /dev/video0 ('Simulated Camera'): the driver wants 153600 bytes for a picture, the topic's "
      "images have 76800; memory = \"userptr\" cannot be had");
}

TEST(CameraSource, FramesBecomeMessagesInTheirOrder) {
  CameraBoard board;
  CameraSource source;
  rt::ModuleRig rig(source, {.board = &board});
  EXPECT_EQ(rig.step({1'000'000}, 1ms), rt::StepStatus::stale) << "nothing was delivered";
  ASSERT_TRUE(eventually([&] { return board.sim.streams(); }));
  board.deliver(1), board.deliver(2);
  EXPECT_EQ(rig.step({2'000'000}, 1ms), rt::StepStatus::ok);
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
  EXPECT_EQ(rig.step({1'000'000}, 1ms), rt::StepStatus::stale) << "nothing was delivered";
  ASSERT_TRUE(eventually([&] { return board.sim.streams(); }));
  board.deliver(1);
  ASSERT_EQ(rig.step({2'000'000}, 1ms), rt::StepStatus::ok);
  EXPECT_EQ(rig.all<msg::Image>("raw")[0]->stamp, hal::Time{1'000'000} + 33ms - 12'500us);
}

TEST(CameraSource, CameraThatIsGoneIsStaleAndComesBack) {
  CameraBoard board;
  CameraSource source;
  rt::ModuleRig rig(source, {.board = &board});
  board.sim.unplug();
  EXPECT_EQ(rig.step({1'000'000}, 1ms), rt::StepStatus::stale);
  EXPECT_EQ(rig.step({2'000'000}, 1ms), rt::StepStatus::stale);
  board.sim.plug_in();
  ASSERT_TRUE(eventually([&] {
    static_cast<void>(rig.step({3'000'000}, 1ms));
    return board.device->stats().reopens == 1 && board.sim.streams();
  }));
  board.deliver(3);
  EXPECT_EQ(rig.step({3'000'000}, 1ms), rt::StepStatus::ok);
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

/// A camera as configured with nothing asked for.
struct Ranges {
  explicit Ranges(const std::function<void(hal::V4l2SimCamera&)>& change) : board(changed(change)) {
    EXPECT_TRUE(rig.configure());
  }
  static hal::V4l2SimCamera changed(const std::function<void(hal::V4l2SimCamera&)>& change) {
    hal::V4l2SimCamera camera;
    change(camera);
    return camera;
  }
  static hal::V4l2SimCamera::Control& control(hal::V4l2SimCamera& camera, std::uint32_t id) {
    const auto at = std::find_if(camera.controls.begin(), camera.controls.end(), [id](auto& c) { return c.id == id; });
    EXPECT_NE(at, camera.controls.end());
    return *at;
  }
  CameraBoard board;
  CameraSource source;
  rt::ModuleRig rig{source, {.board = &board}};
};

TEST(CameraSourceRanges, AreThoseOfTheDevicesControls) {
  Ranges of([](auto&) {});
  const std::string gain = "a number from 0 to 100, or -1: control 'gain' of device 'camera'";
  const std::string exposure =
      "a number from 100 to 5e+05 us, or 0: control 'exposure_time_absolute' of device 'camera'";
  EXPECT_EQ(of.rig.refusal("gain", 101.0), gain);
  EXPECT_EQ(of.rig.refusal("gain", -0.5), gain);
  EXPECT_EQ(of.rig.refusal("exposure_us", 99.0), exposure);
  EXPECT_EQ(of.rig.refusal("exposure_us", 500001.0), exposure);
  for (const double taken : {-1.0, 0.0, 100.0}) EXPECT_EQ(of.rig.refusal("gain", taken), "");
  for (const double taken : {0.0, 100.0, 500000.0}) EXPECT_EQ(of.rig.refusal("exposure_us", taken), "");
}

TEST(CameraSourceRanges, EveryValueThatIsAcceptedReachesTheDevice) {
  Ranges of([](auto&) {});
  std::int64_t ms = 1;
  for (const double gain : {0.0, 100.0, 33.4}) {
    of.rig.set("gain", gain);
    static_cast<void>(of.rig.step({ms++ * 1'000'000}, 1ms));
    EXPECT_TRUE(eventually([&] { return of.board.sim.control("Gain") == std::lround(gain); })) << gain;
  }
  for (const double us : {100.0, 500000.0, 149.0}) {
    of.rig.set("exposure_us", us);
    static_cast<void>(of.rig.step({ms++ * 1'000'000}, 1ms));
    EXPECT_TRUE(eventually([&] { return of.board.sim.control("Exposure Time, Absolute") == std::lround(us / 100); }))
        << us;
  }
  EXPECT_EQ(of.board.device->trouble().find("control"), std::string::npos) << of.board.device->trouble();
}

TEST(CameraSourceRanges, CameraWithoutAControlLeavesNothingToSetAndSaysWhatItHas) {
  Ranges of([](hal::V4l2SimCamera& c) { c.controls = {Ranges::control(c, V4L2_CID_EXPOSURE_AUTO)}; });
  EXPECT_EQ(of.rig.refusal("gain", 33.0),
            "only -1: device 'camera' has no such control; it has: auto_exposure 0 to 3, is 3");
  EXPECT_EQ(of.rig.refusal("exposure_us", 4000.0),
            "only 0: device 'camera' has no such control; it has: auto_exposure 0 to 3, is 3");
  EXPECT_EQ(of.rig.refusal("gain", -1.0), "");
  Ranges none([](hal::V4l2SimCamera& c) { c.controls.clear(); });
  EXPECT_EQ(none.rig.refusal("gain", 33.0), "only -1: device 'camera' has no such control; it has: no controls at all");
}

TEST(CameraSourceRanges, ControlThatIsReadOnlyLeavesNothingToSet) {
  Ranges of([](hal::V4l2SimCamera& c) { Ranges::control(c, V4L2_CID_GAIN).flags = V4L2_CTRL_FLAG_READ_ONLY; });
  EXPECT_EQ(of.rig.refusal("gain", 33.0), "only -1: control 'gain' of device 'camera' is read only");
}

TEST(CameraSourceRanges, CameraThatAlwaysExposesByItselfLeavesNothingToSet) {
  Ranges fixed(
      [](hal::V4l2SimCamera& c) { Ranges::control(c, V4L2_CID_EXPOSURE_AUTO).flags = V4L2_CTRL_FLAG_READ_ONLY; });
  EXPECT_THAT(fixed.rig.refusal("exposure_us", 4000.0),
              HasSubstr("only 0: device 'camera' always chooses it by itself: auto_exposure 0 to 3, is 3, read only"));
  Ranges without([](hal::V4l2SimCamera& c) { Ranges::control(c, V4L2_CID_EXPOSURE_AUTO).max = 0; });
  EXPECT_THAT(without.rig.refusal("exposure_us", 4000.0), HasSubstr("auto_exposure 0 to 0"));
}

TEST(CameraSourceRanges, WhatTheRobotFileSaysIsRefusedInTheSameWords) {
  hal::V4l2SimCamera without;
  without.controls.erase(without.controls.begin());
  CameraBoard board(without);
  CameraSource source;
  rt::ModuleRig rig(source, {.board = &board});
  rig.set("exposure_us", 600000.0);
  rig.set("gain", 33.0);
  const hal::Status configured = rig.configure();
  ASSERT_FALSE(configured);
  EXPECT_EQ(configured.error().code, hal::Errc::bad_argument);
  ASSERT_EQ(rig.problems().size(), 2u) << "both at once";
  EXPECT_EQ(rt::to_string(rig.problems()[0], "r.toml"),
            "r.toml: module.module.params.exposure_us: 6e+05: a number from 100 to 5e+05 us, or 0: control "
            "'exposure_time_absolute' of device 'camera'");
  EXPECT_THAT(rt::to_string(rig.problems()[1], "r.toml"), HasSubstr("params.gain: 33: only -1: device 'camera' has"));
  EXPECT_EQ(board.sim.control("Exposure Time, Absolute"), 156) << "nothing was asked of the device";
}

TEST(CameraSourceRanges, ARecordedRunIsConfiguredAgainWithoutItsCamera) {
  hal::SilentBoard board;
  CameraSource source;
  rt::ModuleRig rig(source, {.board = &board});
  rig.set("exposure_us", 4000.0);
  rig.set("gain", 33.0);
  ASSERT_TRUE(rig.configure()) << rig.problems()[0].allowed;
  EXPECT_EQ(rig.refusal("gain", 1e6), "") << "what the declaration takes";
  EXPECT_EQ(rig.refusal("exposure_us", 1e6), "");
  EXPECT_EQ(rig.step({1'000'000}, 1ms), rt::StepStatus::stale);
}

TEST(CameraSourceRanges, OfTheFirstOpeningStayWhenAnotherCameraComesBackAndTheDeviceComplains) {
  Ranges of([](auto&) {});
  of.board.sim.unplug();
  ASSERT_EQ(of.rig.step({1'000'000}, 1ms), rt::StepStatus::stale);
  of.board.sim.set_range("Gain", 0, 50);
  of.board.sim.plug_in();
  ASSERT_TRUE(eventually([&] {
    static_cast<void>(of.rig.step({2'000'000}, 1ms));
    return of.board.device->stats().reopens == 1;
  }));
  EXPECT_EQ(of.rig.refusal("gain", 60.0), "");
  of.rig.set("gain", 60.0);
  static_cast<void>(of.rig.step({3'000'000}, 1ms));
  EXPECT_TRUE(eventually([&] {
    return of.board.device->trouble().find("control gain = 60.000000 is not allowed: gain 0 to 50") !=
           std::string::npos;
  })) << of.board.device->trouble();
  EXPECT_EQ(of.board.sim.control("Gain"), 20) << "it stays as it was";
  of.rig.set("gain", 40.0);
  static_cast<void>(of.rig.step({4'000'000}, 1ms));
  EXPECT_TRUE(eventually([&] {  // of anything else it may complain: no frames are delivered here
    return of.board.sim.control("Gain") == 40 && of.board.device->trouble().find("control") == std::string::npos;
  })) << of.board.device->trouble();
}

}  // namespace
}  // namespace sinew::drivers::camera_source_test
