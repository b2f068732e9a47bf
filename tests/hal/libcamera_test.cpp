// LibcameraCamera: what it says without cameras, and with SINEW_LIBCAMERA=1 the frames of the first one that is there
// (tests/vm loads vimc for it).
#include "hal/linux/libcamera/libcamera_camera.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <functional>

#include "hal/linux/os.hpp"
#include "msg/image_buffer.hpp"

namespace sinew::hal {
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
  const auto camera = open_libcamera_camera(spec_of("no such camera"), linux_os(), why);
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
    auto opened = open_libcamera_camera(spec_, linux_os(), why_);
    if (!opened) return opened.error().code;
    camera_ = std::move(*opened);
    return std::nullopt;
  }
  bool next() {
    const Time deadline = linux_os().now() + 20s;
    while (linux_os().now() < deadline) {
      const auto got = camera_->read(*image_);
      if (got && *got) return true;
      linux_os().sleep_until(linux_os().now() + 1ms);
    }
    return false;
  }
  CameraSpec spec_;
  std::unique_ptr<LibcameraCamera> camera_;
  std::string why_;
  msg::ImageBuffer image_;
};

TEST_F(LibcameraOnKernel, FramesComeWithRisingNumbersAndStampsOfThisSystem) {
  const Time opened = linux_os().now();
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
    EXPECT_LE(stamp, linux_os().now());
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
  const auto second = open_libcamera_camera(spec_, linux_os(), why);
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().code, Errc::busy) << why;
}

}  // namespace
}  // namespace sinew::hal
