// LibcameraCamera: its texts without cameras, and with SINEW_LIBCAMERA=1 the frames of the first camera (tests/vm loads
// vimc for it).
#include "hal/linux/libcamera/libcamera_camera.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>

#include "drivers/sources/camera_source.hpp"
#include "hal/platform.hpp"
#include "msg/image_buffer.hpp"
#include "rt/exec/module_rig.hpp"

namespace sinew::hal::libcamera_test {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;

CameraSpec spec_of(const std::string& name) {
  CameraSpec spec;
  spec.path = name;
  spec.width = 480, spec.height = 360;  // vimc's pipeline makes multiples of 6 only
  spec.format = msg::PixelFormat::rgb8;
  spec.rate_hz = 0;
  return spec;
}

TEST(LibcameraCamera, UnknownNameIsAnErrorThatSaysWhatThereIs) {
  std::string why;
  const auto camera = open_libcamera_camera(spec_of("no such camera"), system_os(), why);
  ASSERT_FALSE(camera);
  EXPECT_EQ(camera.error().code, Errc::not_found);
  EXPECT_THAT(why, HasSubstr("no camera 'no such camera' for libcamera: it sees "));
}

class LibcameraOnKernel : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!std::getenv("SINEW_LIBCAMERA")) GTEST_SKIP() << "SINEW_LIBCAMERA is not set";
    const auto names = libcamera_names();
    ASSERT_FALSE(names.empty()) << "libcamera sees no camera";
    spec_ = spec_of(names.front());
  }
  std::optional<Errc> open() {
    camera_.reset();
    auto opened = open_libcamera_camera(spec_, system_os(), why_);
    if (!opened) return opened.error().code;
    camera_ = std::move(*opened);
    return std::nullopt;
  }
  bool next() {
    const Time deadline = system_os().now() + 20s;
    while (system_os().now() < deadline) {
      const auto got = camera_->read(*image_);
      if (got && *got) return true;
      system_os().sleep_until(system_os().now() + 1ms);
    }
    return false;
  }
  CameraSpec spec_;
  std::unique_ptr<LibcameraCamera> camera_;
  std::string why_;
  msg::ImageBuffer image_;
};

TEST_F(LibcameraOnKernel, FramesComeWithRisingNumbersAndStampsOfThisSystem) {
  const Time opened = system_os().now();
  ASSERT_EQ(open(), std::nullopt) << why_;
  std::uint64_t gaps = 0;
  std::uint32_t number = 0;
  Time stamp;
  for (int i = 0; i < 20; ++i) {
    ASSERT_TRUE(next()) << camera_->state();
    EXPECT_EQ(image_->format, msg::PixelFormat::rgb8);
    EXPECT_EQ(image_->bulk_used(), 480u * 360 * 3);
    if (i > 0) {
      ASSERT_GT(image_->frame_number, number);
      ASSERT_GT(image_->stamp, stamp);
      gaps += image_->frame_number - number - 1;
    }
    number = image_->frame_number, stamp = image_->stamp;
    EXPECT_GT(stamp, opened);
    EXPECT_LE(stamp, system_os().now());
    const auto* first = image_->pixels();
    const auto* end = first + image_->bulk_used();
    EXPECT_NE(std::adjacent_find(first, end, std::not_equal_to<>()), end) << "a picture, not one grey";
  }
  EXPECT_EQ(camera_->stats().lost, gaps);
  EXPECT_EQ(camera_->stats().unstamped, 0u);
  EXPECT_THAT(camera_->state(), HasSubstr("streaming 480x360"));
}

TEST_F(LibcameraOnKernel, SizeThatItCannotGiveIsRefusedWithWhatItHas) {
  spec_.width = 481;
  EXPECT_EQ(open(), Errc::bad_argument);
  EXPECT_THAT(why_, HasSubstr("asked for 481x360 rgb8 (BGR888 to libcamera), the camera gives 480x360-"));
}

TEST_F(LibcameraOnKernel, UnknownControlIsRefusedWithThoseThatThereAre) {
  spec_.controls = {{"Brigtness", 1}};
  EXPECT_EQ(open(), Errc::bad_argument);
  EXPECT_THAT(why_, HasSubstr("control Brigtness is not known; the camera has: "));
}

TEST_F(LibcameraOnKernel, ControlIsTakenWhileFramesGoOn) {
  ASSERT_EQ(open(), std::nullopt) << why_;
  ASSERT_FALSE(camera_->controls().empty());
  ASSERT_TRUE(camera_->request(0, camera_->controls()[0].max));
  for (int i = 0; i < 5; ++i) ASSERT_TRUE(next()) << camera_->state();
  EXPECT_EQ(camera_->stats().reopens, 0u);
}

TEST_F(LibcameraOnKernel, IsOpenedAgainAndAgain) {
  for (int i = 0; i < 3; ++i) {
    ASSERT_EQ(open(), std::nullopt) << why_;
    ASSERT_TRUE(next()) << camera_->state();
  }
}

TEST_F(LibcameraOnKernel, SecondOneOfTheSameCameraIsBusy) {
  ASSERT_EQ(open(), std::nullopt) << why_;
  std::string why;
  const auto second = open_libcamera_camera(spec_, system_os(), why);
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().code, Errc::busy) << why;
}

/// A board with this one camera.
class CameraBoard final : public EmptyBoard {
 public:
  explicit CameraBoard(Camera& device) : device_(device) {}
  Result<Camera*> camera(std::string_view) override { return &device_; }

 private:
  Camera& device_;
};

TEST_F(LibcameraOnKernel, FramesGoThroughAGraphAndAreWhatTheSlotHolds) {
  ASSERT_EQ(open(), std::nullopt) << why_;
  CameraBoard board(*camera_);
  drivers::CameraSource source;
  rt::ModuleRig rig(source, {.board = &board});
  std::uint32_t messages = 0, newest = 0;
  const Time deadline = system_os().now() + 20s;
  while (messages < 10 && system_os().now() < deadline) {
    system_os().sleep_until(system_os().now() + 5ms);
    if (rig.step(system_os().now(), 5ms) != rt::StepStatus::ok) continue;
    for (const msg::Image* image : rig.all<msg::Image>("raw")) {
      EXPECT_EQ(image->bulk_used(), 480u * 360 * 3);
      if (messages++ > 0) {
        EXPECT_GT(image->frame_number, newest);
      }
      newest = image->frame_number;
    }
  }
  EXPECT_GE(messages, 10u) << camera_->state();
}

// Last, because the driver stays away: libcamera 0.0.3 ends a process in which vimc is bound again. Root only.
TEST_F(LibcameraOnKernel, VanishedCameraIsClosedAndSaidAndDoesNotEndTheProcess) {
  const std::string vimc = "/sys/bus/platform/drivers/vimc/";
  if (!std::filesystem::exists(vimc + "vimc.0")) GTEST_SKIP() << "the camera is not vimc's";
  ASSERT_EQ(open(), std::nullopt) << why_;
  ASSERT_TRUE(next());
  ASSERT_TRUE(std::ofstream(vimc + "unbind") << "vimc.0" << std::flush);
  const auto said = [&] {
    const auto got = camera_->read(*image_);
    return !got && got.error().code == Errc::closed &&
           camera_->state().find("gone; the device left") != std::string::npos;
  };
  bool was = false;
  const Time deadline = system_os().now() + 30s;
  while (!(was = said()) && system_os().now() < deadline) system_os().sleep_until(system_os().now() + 1ms);
  EXPECT_TRUE(was) << camera_->state();
  camera_.reset();
}

}  // namespace
}  // namespace sinew::hal::libcamera_test
