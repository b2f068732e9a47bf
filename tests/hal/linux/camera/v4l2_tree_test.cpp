// The real camera driver on pictures from a V4l2Source over a cable, as from another process.
#include "hal/linux/camera/v4l2_tree_port.hpp"

#include <linux/videodev2.h>
#include <unistd.h>

#include <filesystem>

#include "hal/linux/camera/v4l2_source.hpp"
#include "hal/linux/socket.hpp"
#include "v4l2_fixture.hpp"

namespace sinew::hal::v4l2_tree_test {
namespace {

using ::testing::HasSubstr;
namespace fs = std::filesystem;

class V4l2Tree : public ::testing::Test {
 protected:
  V4l2Tree() {
    std::string name = fs::temp_directory_path() / "sinew-XXXXXX";
    root_ = mkdtemp(name.data());
    auto watch = FdWatch::start(system_os(), named("watch"));
    EXPECT_TRUE(watch);
    if (watch) watch_ = *watch;
    made_.root = root_;
    made_.width = 64, made_.height = 48;
    spec_.path = "/dev/video0", spec_.width = 64, spec_.height = 48;
    options_.first_retry = 1ms, options_.longest_retry = 5ms, options_.look_every = 5ms;
    options_.restart_after = 1h;
    port_ = std::make_unique<V4l2TreePort>(system_os(), root_);
    plug_in();
  }
  ~V4l2Tree() override {
    camera_.reset();
    source_.reset();
    fs::remove_all(root_);
  }
  void plug_in() {
    auto source = V4l2Source::open(system_os(), made_, named("video"), why_);
    ASSERT_TRUE(source) << why_;
    source_ = std::move(*source);
  }
  std::optional<Errc> open() {
    auto opened = V4l2Camera::open(*port_, spec_, system_os(), watch_, options_, why_);
    if (!opened) return opened.error().code;
    camera_ = std::move(*opened);
    // The start has a way to go.
    EXPECT_TRUE(eventually([&] { return source_->streams(); }));
    return std::nullopt;
  }
  static std::uint8_t pixel(std::uint32_t number, std::size_t at) {
    return static_cast<std::uint8_t>(number * 31 + at * 7);
  }
  static Time middle(std::uint32_t number) { return Time{5'000'000'000} + number * 33'333us; }
  /// The sensor takes a picture.
  void take(std::uint32_t number) {
    const auto canvas = source_->canvas();
    for (std::size_t i = 0; i < canvas.size(); ++i) canvas[i] = pixel(number, i);
    source_->deliver(middle(number), number);
  }
  bool read() {
    return eventually([&] {
      const auto got = camera_->read(*image_);
      return got && *got;
    });
  }
  bool has_pixels_of(std::uint32_t number) const {
    for (std::size_t i = 0; i < image_->bulk_used(); ++i)
      if (image_->pixels()[i] != pixel(number, i)) return false;
    return true;
  }

  std::string root_, why_;
  std::shared_ptr<FdWatch> watch_;
  V4l2SourceSpec made_;
  CameraSpec spec_;
  V4l2CameraOptions options_;
  std::unique_ptr<V4l2TreePort> port_;
  std::unique_ptr<V4l2Source> source_;
  std::unique_ptr<V4l2Camera> camera_;
  msg::ImageBuffer image_{msg::PixelFormat::yuyv, 320, 240};
};

TEST_F(V4l2Tree, PicturesComeWithTheirPixelsAndTheMiddleOfTheirExposure) {
  ASSERT_EQ(open(), std::nullopt) << why_;
  for (std::uint32_t number = 1; number < 40; ++number) {
    take(number);
    ASSERT_TRUE(read()) << number;
    ASSERT_TRUE(has_pixels_of(number)) << number;
    EXPECT_EQ(image_->width, 64u);
    EXPECT_EQ(image_->exposure_ns, 8'000'000);
    EXPECT_LE(std::abs((image_->stamp - middle(number)).count()), 1000) << "V4L2 counts microseconds";
  }
  EXPECT_EQ(camera_->stats().lost, 0u);
  EXPECT_EQ(source_->lost(), 0u);
  EXPECT_EQ(source_->sent(), 39u);
}

TEST_F(V4l2Tree, StampStaysTheMiddleWhateverTheExposureIsSetTo) {
  spec_.controls = {{"exposure_time_absolute", 200}};
  ASSERT_EQ(open(), std::nullopt) << why_;
  take(1);
  ASSERT_TRUE(read());
  EXPECT_EQ(image_->exposure_ns, 20'000'000);
  EXPECT_LE(std::abs((image_->stamp - middle(1)).count()), 1000);
}

TEST_F(V4l2Tree, WhatTheSensorDoesNotGiveIsRefusedWithWhatItGives) {
  spec_.width = 640, spec_.height = 480;
  EXPECT_EQ(open(), Errc::bad_argument);
  EXPECT_THAT(why_, HasSubstr("it has 64x48"));
  spec_.width = 64, spec_.height = 48, spec_.format = msg::PixelFormat::rgb8;
  EXPECT_EQ(open(), Errc::not_supported);
  EXPECT_THAT(why_, HasSubstr("YUYV"));
  spec_.format = msg::PixelFormat::yuyv, spec_.controls = {{"zoom", 3}};
  EXPECT_EQ(open(), Errc::bad_argument);
  EXPECT_THAT(why_, HasSubstr("gain"));
}

TEST_F(V4l2Tree, IsFoundByItsStableNameItsBusAndItsCard) {
  for (const char* name : {"usb-Sinew_Plant_Camera-video-index0", "usb-Sinew_Plant_Camera", "sim:plant-1",
                           "Plant Camera", "/dev/v4l/by-id/usb-Sinew_Plant_Camera-video-index0"}) {
    spec_.path = name;
    EXPECT_EQ(open(), std::nullopt) << name << ": " << why_;
    camera_.reset();
    EXPECT_TRUE(eventually([&] { return !source_->streams(); }));
  }
}

TEST_F(V4l2Tree, NodesAreListedByTheirNumbers) {
  made_.number = 10, made_.by_id = "other";
  auto other = V4l2Source::open(system_os(), made_, named("video"), why_);
  ASSERT_TRUE(other) << why_;
  EXPECT_EQ(port_->nodes(), (std::vector<std::string>{"/dev/video0", "/dev/video10"}));
  spec_.path = "/dev/video7";
  EXPECT_EQ(open(), Errc::not_found);
  EXPECT_THAT(why_, HasSubstr("there is /dev/video0 'Plant Camera' at sim:plant-1; /dev/video10"));
}

TEST_F(V4l2Tree, PicturesThatFindNoQueuedBufferAreMissingInTheNumbers) {
  ASSERT_EQ(open(), std::nullopt) << why_;
  for (std::uint32_t number = 1; number <= 20; ++number) {  // nobody reads
    take(number);
    EXPECT_TRUE(eventually([&] { return source_->sent() + source_->lost() == number; }));
  }
  take(21);  // whatever was read, the driver knows of all
  for (std::uint32_t i = 0; i < 4; ++i) ASSERT_TRUE(read());
  std::uint32_t next = 22;
  ASSERT_TRUE(eventually([&] {
    take(next++);
    const auto got = camera_->read(*image_);
    return got && *got;
  }));
  EXPECT_GE(camera_->stats().lost, 16u);
  EXPECT_GT(image_->frame_number, 19u);
}

TEST_F(V4l2Tree, PicturesForWhichThereWasNoPlaceAreMissingInTheNumbers) {
  ASSERT_EQ(open(), std::nullopt) << why_;
  take(1);
  ASSERT_TRUE(read());
  take(8);  // 2 to 7 were exposed while the world had no canvas for them
  ASSERT_TRUE(read());
  EXPECT_TRUE(has_pixels_of(8));
  EXPECT_EQ(image_->frame_number, 7u);
  EXPECT_EQ(camera_->stats().lost, 6u);
}

TEST_F(V4l2Tree, ASecondProgramReadsBusyUntilTheFirstOneEnds) {
  ASSERT_EQ(open(), std::nullopt) << why_;
  V4l2TreePort another(system_os(), root_);
  EXPECT_EQ(V4l2Camera::open(another, spec_, system_os(), watch_, options_, why_).error().code, Errc::busy);
  EXPECT_THAT(why_, HasSubstr("another program uses the device"));
  camera_.reset();
  ASSERT_TRUE(eventually([&] { return !source_->streams(); }));
  EXPECT_TRUE(V4l2Camera::open(another, spec_, system_os(), watch_, options_, why_)) << why_;
}

TEST_F(V4l2Tree, OfTwoThatOpenAtOnceTheFirstToAskGetsTheBuffers) {
  V4l2TreePort another(system_os(), root_);
  const int late = another.open("/dev/video0");  // nobody has claimed it yet
  ASSERT_GE(late, 0);
  v4l2_format format{};
  format.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  ASSERT_EQ(another.ioctl(late, VIDIOC_S_FMT, &format), 0);
  ASSERT_EQ(open(), std::nullopt) << why_;
  v4l2_requestbuffers wanted{};
  wanted.count = 4, wanted.type = V4L2_BUF_TYPE_VIDEO_CAPTURE, wanted.memory = V4L2_MEMORY_MMAP;
  EXPECT_EQ(another.ioctl(late, VIDIOC_REQBUFS, &wanted), -EBUSY);
  another.close(late);
  take(1);
  EXPECT_TRUE(read()) << "the first one did not notice";
}

TEST_F(V4l2Tree, PulledPlugIsSurvivedAndFramesGoOnWithHigherNumbers) {
  ASSERT_EQ(open(), std::nullopt) << why_;
  for (std::uint32_t number = 1; number <= 3; ++number) {
    take(number);
    ASSERT_TRUE(read());
  }
  EXPECT_EQ(image_->frame_number, 2u);
  source_->set_plugged(false);
  EXPECT_TRUE(eventually([&] {
    const auto got = camera_->read(*image_);
    return !got && got.error().code == Errc::closed;
  }));
  EXPECT_TRUE(eventually([&] { return camera_->state().find("gone") != std::string::npos; })) << camera_->state();
  EXPECT_TRUE(port_->nodes().empty());
  source_->set_plugged(true);
  ASSERT_TRUE(eventually([&] { return source_->streams(); })) << camera_->state();
  take(90);
  ASSERT_TRUE(read());
  EXPECT_TRUE(has_pixels_of(90));
  EXPECT_GT(image_->frame_number, 2u);
}

TEST_F(V4l2Tree, AProcessThatEndsIsADeviceThatIsUnplugged) {
  ASSERT_EQ(open(), std::nullopt) << why_;
  source_.reset();
  EXPECT_TRUE(eventually([&] { return !camera_->read(*image_); })) << "closed";
  EXPECT_TRUE(eventually([&] { return camera_->state().find("gone") != std::string::npos; })) << camera_->state();
  plug_in();
  ASSERT_TRUE(eventually([&] { return source_->streams(); }));
  take(1);
  EXPECT_TRUE(read());
}

TEST_F(V4l2Tree, NothingThereIsSaidAsForARealDevice) {
  source_.reset();
  EXPECT_EQ(open(), Errc::not_found);
  EXPECT_THAT(why_, HasSubstr("/dev/video0: there is no such device; no camera is there"));
}

TEST_F(V4l2Tree, WhoeverElseListensThereIsNoCamera) {
  source_.reset();
  auto listener = listen_stream("unix:" + root_ + "/dev/video0");
  ASSERT_TRUE(listener);
  auto thread = system_os().start_thread(named("stranger"), [&] {
    auto line = (*listener)->accept(10s);
    ASSERT_TRUE(line);
    const std::array<std::byte, 200> nonsense{};
    static_cast<void>((*line)->write(nonsense));
    auto second = (*listener)->accept(100ms);  // it looks around once more
  });
  EXPECT_EQ(open(), Errc::closed) << why_;
}

TEST_F(V4l2Tree, ABreachOfTheLanguageEndsThatLineOnly) {
  ASSERT_EQ(open(), std::nullopt) << why_;
  auto line = connect_stream("unix:" + root_ + "/dev/video0", 1s);
  ASSERT_TRUE(line);
  (*line)->set_patience(10s);
  const CableMessage rude{CableWord::give_back, 3, 0, 0};  // of a slot that it never had
  ASSERT_TRUE((*line)->write(std::as_bytes(std::span(&rude, 1))));
  std::array<std::byte, 4096> rest;
  EXPECT_TRUE(eventually([&] { return !(*line)->read(rest); }));
  take(1);
  EXPECT_TRUE(read());
}

}  // namespace
}  // namespace sinew::hal::v4l2_tree_test
