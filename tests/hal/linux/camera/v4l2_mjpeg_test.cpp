// Cameras that have a size or a rate as MJPEG only: V4l2Camera on a simulated device.
#include <linux/videodev2.h>

#include "jpeg_fixture.hpp"
#include "v4l2_fixture.hpp"

namespace sinew::hal::v4l2_mjpeg_test {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

class V4l2Mjpeg : public V4l2Test {
 protected:
  V4l2Mjpeg() {  // which the default camera has as MJPG only
    spec_.width = 1280, spec_.height = 720, spec_.format = msg::PixelFormat::rgb8;
  }
  bool deliver_jpeg(std::uint32_t number) {
    return sim_.deliver_jpeg(jpeg_of(spec_.width, spec_.height, TJSAMP_422, number), stamp(number));
  }
  /// Whether the red at the left edge is the picture's, or near it.
  bool shows(std::uint32_t number) const {
    const Rgb c = colour_at(0, 0, number);
    switch (image_->format) {
      case msg::PixelFormat::rgb8:
        return close(image_->pixels()[0], c.r) && close(image_->pixels()[2], c.b);
      case msg::PixelFormat::bgr8:
        return close(image_->pixels()[2], c.r) && close(image_->pixels()[0], c.b);
      default:
        return close(image_->pixels()[0], ycc_of(c).y);
    }
  }
};

TEST_F(V4l2Mjpeg, IsNotOfferedAsYuyvWhichWouldTakeTwoPasses) {
  spec_.format = msg::PixelFormat::yuyv;
  EXPECT_EQ(open(), Errc::bad_argument);
  EXPECT_THAT(why_,
              HasSubstr("1280x720 yuyv is not offered; it has 640x480, 320x240; it has this as MJPEG, which gives "
                        "mono8, rgb8 or bgr8"));
}

TEST_F(V4l2Mjpeg, IsDecodedIntoEveryFormatThatTakesOnePass) {
  for (const auto format : {msg::PixelFormat::mono8, msg::PixelFormat::rgb8, msg::PixelFormat::bgr8}) {
    spec_.format = format;
    ASSERT_EQ(open(), std::nullopt) << why_;
    EXPECT_TRUE(camera_->picture().is_jpeg);
    for (std::uint32_t n = 1; n <= 3; ++n) {
      ASSERT_TRUE(deliver_jpeg(n));
      ASSERT_TRUE(read());
      EXPECT_EQ(image_->format, format);
      EXPECT_EQ(image_->width, 1280u);
      EXPECT_EQ(image_->stride, 1280 * msg::bytes_per_pixel(format));
      EXPECT_EQ(image_->frame_number, n - 1);
      EXPECT_EQ(image_->stamp, stamp(n));
      EXPECT_TRUE(shows(n));
    }
    EXPECT_EQ(sim_.queued(), spec_.buffers);
  }
}

TEST_F(V4l2Mjpeg, IsTakenOnlyWhereTheDeviceHasNoPixelsOfThatSizeAndRate) {
  V4l2SimCamera usb;
  usb.offers = {{V4L2_PIX_FMT_MJPEG, "Motion-JPEG", {{640, 480}}, {60, 30}},
                {V4L2_PIX_FMT_YUYV, "YUYV 4:2:2", {{640, 480}}, {15}}};
  V4l2Sim sim(usb);
  spec_.width = 640, spec_.height = 480;
  const auto jpeg_at = [&](double rate_hz, msg::PixelFormat format) {
    spec_.rate_hz = rate_hz, spec_.format = format;
    const auto session = V4l2Session::open(sim, spec_, why_);
    EXPECT_TRUE(session) << why_;
    return session && (*session)->picture().is_jpeg;
  };
  EXPECT_FALSE(jpeg_at(15, msg::PixelFormat::yuyv));
  EXPECT_FALSE(jpeg_at(0, msg::PixelFormat::yuyv)) << "whatever it does: then no work";
  EXPECT_TRUE(jpeg_at(60, msg::PixelFormat::mono8));
  EXPECT_TRUE(jpeg_at(30, msg::PixelFormat::rgb8)) << "which it has in no other way";
  spec_.rate_hz = 120;
  spec_.format = msg::PixelFormat::yuyv;
  EXPECT_FALSE(V4l2Session::open(sim, spec_, why_));
  EXPECT_THAT(why_, HasSubstr("640x480 yuyv at 120 frames/s is not offered; it has 15 frames/s"));
}

TEST_F(V4l2Mjpeg, BrokenPictureIsALostFrameAndTheNextOneComes) {
  ASSERT_EQ(open(), std::nullopt) << why_;
  auto half = jpeg_of(1280, 720, TJSAMP_422);
  half.resize(half.size() / 2);
  ASSERT_TRUE(sim_.deliver_jpeg(half, stamp(0)));
  auto got = camera_->read(*image_);
  ASSERT_FALSE(got);
  EXPECT_EQ(got.error().code, Errc::bad_data);
  ASSERT_TRUE(sim_.deliver_jpeg(jpeg_of(640, 480, TJSAMP_422), stamp(1))) << "of another size";
  EXPECT_FALSE(camera_->read(*image_));
  const std::vector<std::uint8_t> garbage(1000, 0x5A);
  ASSERT_TRUE(sim_.deliver_jpeg(garbage, stamp(2)));
  EXPECT_FALSE(camera_->read(*image_));
  ASSERT_TRUE(deliver_jpeg(3));
  ASSERT_TRUE(read());
  EXPECT_TRUE(shows(3));
  EXPECT_EQ(image_->frame_number, 3u);
  EXPECT_EQ(camera_->stats().corrupted, 3u);
  EXPECT_EQ(camera_->stats().frames, 1u);
  EXPECT_THAT(camera_->state(), HasSubstr("3 corrupted"));
  EXPECT_EQ(sim_.queued(), spec_.buffers);
}

TEST_F(V4l2Mjpeg, CameraThatStreamsForLongIsWell) {
  ASSERT_EQ(open(), std::nullopt) << why_;
  const auto jpeg = jpeg_of(spec_.width, spec_.height, TJSAMP_422, 1);
  std::uint32_t n = 0;
  for (const Time end = system_os().now() + 1500ms; system_os().now() < end;) {  // longer than what is worth saying
    ASSERT_TRUE(sim_.deliver_jpeg(jpeg, stamp(++n)));
    ASSERT_TRUE(read());
  }
  EXPECT_THAT(camera_->trouble(), Not(HasSubstr("faulty"))) << "each of its " << n << " pictures was good";
  EXPECT_THAT(camera_->state(), Not(HasSubstr("faulty")));
}

TEST_F(V4l2Mjpeg, CameraThatComesBackIsDecodedAgain) {
  ASSERT_EQ(open(), std::nullopt) << why_;
  for (std::uint32_t round = 1; round <= 3; ++round) {
    ASSERT_TRUE(deliver_jpeg(round));
    ASSERT_TRUE(read());
    sim_.unplug();
    EXPECT_FALSE(camera_->read(*image_));
    sim_.plug_in();
    ASSERT_TRUE(eventually([&] { return camera_->stats().reopens == round; }));
  }
}

TEST_F(V4l2Mjpeg, CannotGoIntoLentMemoryAndSaysSo) {
  ASSERT_EQ(open(), std::nullopt) << why_;
  const auto begun = camera_->begin_lending(1280 * 720 * 3, why_);
  ASSERT_FALSE(begun);
  EXPECT_EQ(begun.error().code, Errc::not_supported);
  EXPECT_THAT(why_, HasSubstr("the camera has this picture as MJPEG only, which is decoded"));
  ASSERT_TRUE(deliver_jpeg(1));
  EXPECT_TRUE(read());
}

}  // namespace
}  // namespace sinew::hal::v4l2_mjpeg_test
