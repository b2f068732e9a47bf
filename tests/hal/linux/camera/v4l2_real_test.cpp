// V4l2Camera on a device of the running kernel: SINEW_V4L2=/dev/video0 (tests/vm loads vivid for it). The unplugging
// unbinds the device from its driver, which needs root.
#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <set>

#include "v4l2_fixture.hpp"

namespace sinew::hal::v4l2_real_test {
namespace {

using ::testing::HasSubstr;
namespace fs = std::filesystem;

class V4l2CameraOnKernel : public ::testing::Test {
 protected:
  void SetUp() override {
    const char* path = std::getenv("SINEW_V4L2");
    if (!path) GTEST_SKIP() << "SINEW_V4L2 names no device";
    auto watch = FdWatch::start(system_os(), named("watch"));
    ASSERT_TRUE(watch);
    watch_ = *watch;
    spec_.path = path;
    spec_.width = 640, spec_.height = 360;
    spec_.rate_hz = 0;
    options_.first_retry = 10ms, options_.longest_retry = 100ms;
  }
  std::optional<Errc> open() {
    camera_.reset();
    auto opened = V4l2Camera::open(kernel_v4l2_port(), spec_, system_os(), watch_, options_, why_);
    if (!opened) return opened.error().code;
    camera_ = std::move(*opened);
    return std::nullopt;
  }
  /// True: a frame came within ten seconds.
  bool next() {
    return eventually([&] {
      const auto got = camera_->read(*image_);
      return got && *got;
    });
  }
  /// A file of the device in sysfs.
  std::string sysfs(const std::string& file) const {
    const std::string node = fs::canonical(spec_.path).filename();
    return fs::canonical("/sys/class/video4linux/" + node + "/device" + file);
  }

  CameraSpec spec_;
  V4l2CameraOptions options_;
  std::shared_ptr<FdWatch> watch_;
  std::unique_ptr<V4l2Camera> camera_;
  std::string why_;
  msg::ImageBuffer image_;
};

TEST_F(V4l2CameraOnKernel, GivesFramesInEveryFormatThatImagesHave) {
  for (const auto format :
       {msg::PixelFormat::yuyv, msg::PixelFormat::mono8, msg::PixelFormat::rgb8, msg::PixelFormat::bgr8}) {
    spec_.format = format;
    ASSERT_EQ(open(), std::nullopt) << why_;
    ASSERT_TRUE(next()) << camera_->state();
    EXPECT_EQ(image_->format, format);
    EXPECT_EQ(image_->width, 640u);
    EXPECT_EQ(image_->height, 360u);
    const auto* first = image_->pixels();
    const auto* end = first + image_->bulk_used();
    EXPECT_NE(std::adjacent_find(first, end, std::not_equal_to<>()), end) << "a picture, not one grey";
  }
}

TEST_F(V4l2CameraOnKernel, NumbersAndStampsRiseAndGapsAreCountedAsLost) {
  ASSERT_EQ(open(), std::nullopt) << why_;
  // vivid's end of frame is most of a period ahead of the time; its start of exposure is honest.
  if (camera_->find("timestamp_source")) spec_.controls["timestamp_source"] = 1;
  const Time opened = system_os().now();
  ASSERT_EQ(open(), std::nullopt) << why_;
  std::uint64_t gaps = 0;
  std::uint32_t number = 0;
  Time stamp;
  for (int i = 0; i < 20; ++i) {
    ASSERT_TRUE(next()) << camera_->state();
    if (i > 0) {
      ASSERT_GT(image_->frame_number, number);
      ASSERT_GT(image_->stamp, stamp);
      gaps += image_->frame_number - number - 1;
    }
    number = image_->frame_number, stamp = image_->stamp;
    EXPECT_GT(stamp, opened) << "on the clock of this system";
    EXPECT_LE(stamp, system_os().now());
  }
  EXPECT_EQ(camera_->stats().frames, 20u);
  EXPECT_EQ(camera_->stats().lost, gaps);
  EXPECT_EQ(camera_->stats().unstamped, 0u);
}

TEST_F(V4l2CameraOnKernel, RateOfTheListIsTakenAndAnotherRefusedWithTheList) {
  spec_.rate_hz = 9999;
  EXPECT_EQ(open(), Errc::bad_argument);
  const auto at = why_.find("is not offered; it has ");
  ASSERT_NE(at, std::string::npos) << why_;
  spec_.rate_hz = std::strtod(why_.c_str() + at + 23, nullptr);
  ASSERT_EQ(open(), std::nullopt) << why_;
  EXPECT_NEAR(camera_->picture().rate_hz, spec_.rate_hz, spec_.rate_hz * 0.01);
  ASSERT_TRUE(next()) << camera_->state();
}

TEST_F(V4l2CameraOnKernel, SizeThatItHasNotIsRefused) {
  spec_.width = 641, spec_.height = 361;
  EXPECT_EQ(open(), Errc::bad_argument);
  EXPECT_THAT(why_, HasSubstr("641x361"));
}

TEST_F(V4l2CameraOnKernel, SecondStreamOfTheSameDeviceIsBusy) {
  ASSERT_EQ(open(), std::nullopt) << why_;
  std::string why;
  const auto second = V4l2Camera::open(kernel_v4l2_port(), spec_, system_os(), watch_, options_, why);
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().code, Errc::busy) << why;
  EXPECT_THAT(why, HasSubstr("another program uses"));
}

TEST_F(V4l2CameraOnKernel, ControlReachesTheDriver) {
  ASSERT_EQ(open(), std::nullopt) << why_;
  std::size_t at = 0;  // the first number that can be set: vivid's brightness
  while (at < camera_->controls().size() && (camera_->controls()[at].read_only || camera_->controls()[at].max < 100))
    ++at;
  ASSERT_LT(at, camera_->controls().size()) << camera_->list();
  const CameraControl was = camera_->controls()[at];
  const double wanted = was.value == was.min ? was.max : was.min;
  ASSERT_TRUE(camera_->request(at, wanted));
  V4l2Port& port = kernel_v4l2_port();
  const int fd = port.open(spec_.path);
  ASSERT_GE(fd, 0);
  EXPECT_TRUE(eventually([&] { return V4l2Controls::enumerate(port, fd).list()[at].value == wanted; })) << was.name;
  port.close(fd);
  EXPECT_TRUE(camera_->request(at, was.value));
  EXPECT_TRUE(next());
}

TEST_F(V4l2CameraOnKernel, IsFoundByItsBus) {
  ASSERT_EQ(open(), std::nullopt) << why_;
  spec_.path = camera_->identity().bus_info;
  ASSERT_EQ(open(), std::nullopt) << why_;
  EXPECT_TRUE(next());
}

/// Lends the camera images whose pixels lie as those of a topic's slots do, and takes them filled.
class V4l2LendingOnKernel : public V4l2CameraOnKernel {
 protected:
  static constexpr std::size_t kImages = 8;
  static constexpr std::uint32_t kRoom = 640 * 360 * 3;
  static constexpr std::uint8_t kUntouched = 0xA5;
  void TearDown() override {
    if (!camera_) return;
    camera_->stop_lending();
    while (camera_->take_back()) --lent_;
    EXPECT_EQ(lent_, 0u);
  }
  bool begin() {
    if (open() != std::nullopt) return false;
    const auto begun = camera_->begin_lending(kRoom, why_);
    return begun.has_value();
  }
  /// A filled one within ten seconds; it is lent again in the next call.
  msg::Image* take() {
    msg::Image* image = nullptr;
    eventually([&] {
      for (auto& mine : images_) {
        if (lent_ == spec_.buffers || out_.contains(&*mine)) continue;
        std::fill_n(mine->pixels(), kRoom, kUntouched);
        if (!camera_->lend(*mine)) break;
        out_.insert(&*mine), ++lent_;
      }
      const auto got = camera_->take_filled();
      image = got ? *got : nullptr;
      return image != nullptr;
    });
    if (image) {
      EXPECT_EQ(out_.erase(image), 1u) << "not one that was lent";
      --lent_;
    }
    return image;
  }

  std::vector<msg::ImageBuffer> images_ = [] {
    std::vector<msg::ImageBuffer> all;
    for (std::size_t i = 0; i < kImages; ++i) all.emplace_back(kRoom);
    return all;
  }();
  std::set<const msg::Image*> out_;
  std::size_t lent_ = 0;
};

TEST_F(V4l2LendingOnKernel, KernelFillsTheReadersMemoryInEveryFormat) {
  for (const auto format :
       {msg::PixelFormat::yuyv, msg::PixelFormat::mono8, msg::PixelFormat::rgb8, msg::PixelFormat::bgr8}) {
    spec_.format = format;
    ASSERT_TRUE(begin()) << why_;
    EXPECT_EQ(camera_->path_of_pixels(), "the driver fills the topic's slots");
    std::uint32_t number = 0;
    std::set<const msg::Image*> seen;
    for (int i = 0; i < 20; ++i) {
      const msg::Image* image = take();
      ASSERT_NE(image, nullptr) << camera_->state();
      ASSERT_EQ(image->format, format);
      ASSERT_EQ(image->bulk_used(), 640u * 360 * msg::bytes_per_pixel(format));
      const auto* end = image->pixels() + image->bulk_used();
      ASSERT_LT(std::count(image->pixels(), end, kUntouched), image->bulk_used() / 4) << "the kernel wrote it";
      ASSERT_NE(std::adjacent_find(image->pixels(), end, std::not_equal_to<>()), end);
      if (image->capacity_bytes > image->bulk_used()) {
        ASSERT_EQ(*end, kUntouched) << "and nothing beyond";
      }
      if (i > 0) {
        ASSERT_GT(image->frame_number, number);
      }
      number = image->frame_number;
      seen.insert(image);
    }
    EXPECT_GT(seen.size(), 1u);
    EXPECT_EQ(camera_->stats().corrupted, 0u);
    camera_->stop_lending();
    while (camera_->take_back()) --lent_;
    out_.clear();
  }
}

TEST_F(V4l2LendingOnKernel, StreamEndsWhenItIsAskedForAndBeginsAnew) {
  ASSERT_TRUE(begin()) << why_;
  for (int round = 0; round < 3; ++round) {
    ASSERT_NE(take(), nullptr) << camera_->state();
    ASSERT_TRUE(eventually([&] {
      while (camera_->take_back()) --lent_;
      return lent_ == 0;
    })) << camera_->state();
    out_.clear();
  }
}

TEST_F(V4l2LendingOnKernel, UnboundAndBoundAgainItFillsTheSameMemory) {
  ASSERT_TRUE(begin()) << why_;
  const std::string driver = sysfs("/driver"), device = fs::path(sysfs("")).filename();
  ASSERT_NE(take(), nullptr);
  ASSERT_TRUE(std::ofstream(driver + "/unbind") << device << std::flush);
  EXPECT_TRUE(eventually([&] {
    const auto got = camera_->take_filled();
    if (got && *got) out_.erase(*got), --lent_;
    return !got && got.error().code == Errc::closed && camera_->stats().tries > 0;
  })) << camera_->state();
  ASSERT_TRUE(std::ofstream(driver + "/bind") << device << std::flush);
  ASSERT_TRUE(eventually([&] { return camera_->stats().reopens == 1; })) << camera_->state();
  ASSERT_NE(take(), nullptr) << camera_->state();
}

TEST_F(V4l2CameraOnKernel, UnbindingClosesItAndBindingBringsItBack) {
  const std::string driver = sysfs("/driver"), device = fs::path(sysfs("")).filename();
  ASSERT_EQ(open(), std::nullopt) << why_;
  ASSERT_TRUE(next());
  const std::uint32_t number = image_->frame_number;
  ASSERT_TRUE(std::ofstream(driver + "/unbind") << device << std::flush) << driver << "/unbind " << device;
  EXPECT_TRUE(eventually([&] {
    const auto got = camera_->read(*image_);
    return !got && got.error().code == Errc::closed && camera_->stats().tries > 0;
  })) << camera_->state();
  EXPECT_THAT(camera_->state(), HasSubstr("gone: No such device"));
  ASSERT_TRUE(std::ofstream(driver + "/bind") << device << std::flush) << driver << "/bind " << device;
  ASSERT_TRUE(next()) << camera_->state();
  EXPECT_EQ(camera_->stats().reopens, 1u);
  EXPECT_GT(image_->frame_number, number + 1);
}

}  // namespace
}  // namespace sinew::hal::v4l2_real_test
