// V4l2Camera on a simulated device: formats, frames, stamps, controls. Its faults: v4l2_camera_fault_test.cpp.
#include <linux/videodev2.h>

#include "v4l2_fixture.hpp"

namespace sinew::hal::v4l2_camera_test {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

/// The same tests on another simulated camera than the default one.
template <class Change>
V4l2SimCamera camera_with(Change change) {
  V4l2SimCamera camera;
  change(camera);
  return camera;
}
class V4l2CameraOnSim : public V4l2Test {
 protected:
  /// A session on another device; only what was agreed and why not.
  Result<std::unique_ptr<V4l2Session>> on(V4l2Sim& sim) { return V4l2Session::open(sim, spec_, why_); }
};

TEST_F(V4l2CameraOnSim, FrameComesWithItsPixelsNumberAndStamp) {
  ASSERT_EQ(open(), std::nullopt) << why_;
  EXPECT_FALSE(read()) << "nothing was sent yet";
  ASSERT_TRUE(deliver(0));
  ASSERT_TRUE(read());
  EXPECT_TRUE(same_pixels(0));
  EXPECT_EQ(image_->frame_number, 0u);
  EXPECT_EQ(image_->format, msg::PixelFormat::yuyv);
  EXPECT_EQ(image_->stride, 640u);
  ASSERT_TRUE(deliver(1));
  ASSERT_TRUE(read());
  EXPECT_TRUE(same_pixels(1));
  EXPECT_EQ(image_->frame_number, 1u);
  EXPECT_FALSE(read());
  EXPECT_EQ(camera_->stats().frames, 2u);
  EXPECT_EQ(camera_->stats().lost, 0u);
}

TEST_F(V4l2CameraOnSim, EveryBufferGoesBackToTheDriver) {
  ASSERT_EQ(open(), std::nullopt) << why_;
  for (std::uint32_t i = 0; i < 40; ++i) {
    ASSERT_EQ(sim_.queued(), spec_.buffers);
    ASSERT_TRUE(deliver(i)) << i;
    ASSERT_TRUE(read()) << i;
  }
}

TEST_F(V4l2CameraOnSim, PaddingBehindRowsIsLeftBehind) {
  V4l2Sim padded(camera_with([](V4l2SimCamera& c) { c.padding_bytes = 64; }));
  auto opened = V4l2Camera::open(padded, spec_, system_os(), watch_, options_, why_);
  ASSERT_TRUE(opened) << why_;
  EXPECT_EQ((*opened)->picture().bytes_per_line, 320u * 2 + 64);
  ASSERT_TRUE(padded.deliver(*picture(5), stamp(5)));
  const auto got = (*opened)->read(*image_);
  ASSERT_TRUE(got && *got);
  EXPECT_EQ(image_->stride, 640u);
  EXPECT_TRUE(same_pixels(5));
}

TEST_F(V4l2CameraOnSim, WakesWhoeverWaitsWhenAFrameComes) {
  ASSERT_EQ(open(), std::nullopt) << why_;
  WakeCounter wakes;
  camera_->set_wake(&wakes);
  EXPECT_FALSE(read());
  EXPECT_EQ(camera_->ready_at(), kNever);
  const auto before = wakes.count();
  ASSERT_TRUE(deliver(0));
  EXPECT_TRUE(eventually([&] { return wakes.count() > before; }));
  EXPECT_NE(camera_->ready_at(), kNever);
  EXPECT_TRUE(read());
  EXPECT_NE(camera_->ready_at(), kNever) << "another may be there";
  EXPECT_FALSE(read());
  EXPECT_EQ(camera_->ready_at(), kNever);
  camera_->set_wake(nullptr);
}

TEST_F(V4l2CameraOnSim, AllFramesThatWaitAreReadOldestFirst) {
  ASSERT_EQ(open(), std::nullopt) << why_;
  for (std::uint32_t i = 0; i < 3; ++i) ASSERT_TRUE(deliver(i));
  for (std::uint32_t i = 0; i < 3; ++i) {
    ASSERT_TRUE(read());
    EXPECT_EQ(image_->frame_number, i);
  }
  EXPECT_FALSE(read());
}

TEST_F(V4l2CameraOnSim, FramesThatFindNoBufferAreCountedAsLost) {
  ASSERT_EQ(open(), std::nullopt) << why_;
  for (std::uint32_t i = 0; i < 4; ++i) ASSERT_TRUE(deliver(i));
  EXPECT_FALSE(deliver(4));
  EXPECT_FALSE(deliver(5));
  for (std::uint32_t i = 0; i < 4; ++i) ASSERT_TRUE(read());
  ASSERT_TRUE(deliver(6));
  ASSERT_TRUE(read());
  EXPECT_EQ(image_->frame_number, 6u);
  EXPECT_EQ(camera_->stats().lost, 2u);
  EXPECT_THAT(camera_->state(), HasSubstr("2 frames lost"));
}

TEST_F(V4l2CameraOnSim, FrameThatDoesNotFitTheTopicIsDroppedAndSaid) {
  ASSERT_EQ(open(), std::nullopt) << why_;
  msg::ImageBuffer small(100);
  ASSERT_TRUE(deliver(0));
  const auto got = camera_->read(*small);
  ASSERT_FALSE(got);
  EXPECT_EQ(got.error().code, Errc::bad_argument);
  EXPECT_EQ(camera_->stats().too_large, 1u);
  EXPECT_THAT(camera_->state(), HasSubstr("1 too large for the topic"));
  EXPECT_EQ(sim_.queued(), spec_.buffers);
  ASSERT_TRUE(deliver(1));
  EXPECT_TRUE(read()) << "the next one that fits is read";
}

// ---- stamps

TEST_F(V4l2CameraOnSim, StampIsTheMiddleOfAKnownExposure) {
  spec_.controls = {{"auto_exposure", 1}, {"exposure_time_absolute", 100}};  // manual, 10 ms
  ASSERT_EQ(open(), std::nullopt) << why_;
  ASSERT_TRUE(deliver(3));
  ASSERT_TRUE(read());
  EXPECT_EQ(image_->exposure_ns, 10'000'000);
  EXPECT_EQ(image_->stamp, stamp(3) + 5ms) << "this driver stamps the start of the exposure";
}

TEST_F(V4l2CameraOnSim, StampOfTheEndOfAFrameGoesBackByHalfTheExposure) {
  V4l2Sim end(camera_with(
      [](V4l2SimCamera& c) { c.stamp_flags = V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC | V4L2_BUF_FLAG_TSTAMP_SRC_EOF; }));
  spec_.controls = {{"auto_exposure", 1}, {"exposure_time_absolute", 100}};
  auto opened = V4l2Camera::open(end, spec_, system_os(), watch_, options_, why_);
  ASSERT_TRUE(opened) << why_;
  ASSERT_TRUE(end.deliver(*picture(3), stamp(3)));
  const auto got = (*opened)->read(*image_);
  ASSERT_TRUE(got && *got);
  EXPECT_EQ(image_->stamp, stamp(3) - 5ms);
}

TEST_F(V4l2CameraOnSim, StampStaysTheDriversWhereTheExposureIsAutomatic) {
  ASSERT_EQ(open(), std::nullopt) << why_;
  ASSERT_TRUE(deliver(3));
  ASSERT_TRUE(read());
  EXPECT_EQ(image_->exposure_ns, 0) << "0: not known";
  EXPECT_EQ(image_->stamp, stamp(3));
}

TEST_F(V4l2CameraOnSim, FrameWithoutAMonotonicStampGetsTheTimeOfReading) {
  V4l2Sim unstamped(camera_with([](V4l2SimCamera& c) { c.stamp_flags = V4L2_BUF_FLAG_TIMESTAMP_UNKNOWN; }));
  auto opened = V4l2Camera::open(unstamped, spec_, system_os(), watch_, options_, why_);
  ASSERT_TRUE(opened) << why_;
  const Time before = system_os().now();
  ASSERT_TRUE(unstamped.deliver(*picture(0), Time{5}));
  const auto got = (*opened)->read(*image_);
  ASSERT_TRUE(got && *got);
  EXPECT_GE(image_->stamp, before);
  EXPECT_LE(image_->stamp, system_os().now());
  EXPECT_EQ((*opened)->stats().unstamped, 1u);
  EXPECT_THAT((*opened)->state(), HasSubstr("1 without a usable stamp of the driver"));
}

TEST_F(V4l2CameraOnSim, StampOfTheFutureIsReplacedByTheTimeOfReading) {
  ASSERT_EQ(open(), std::nullopt) << why_;
  ASSERT_TRUE(sim_.deliver(*picture(0), system_os().now() + 1h));
  ASSERT_TRUE(read());
  EXPECT_LE(image_->stamp, system_os().now());
  EXPECT_EQ(camera_->stats().unstamped, 1u);
}

// ---- formats

TEST_F(V4l2CameraOnSim, FormatThatImagesCannotHaveIsRefusedWithWhatThereIs) {
  spec_.format = msg::PixelFormat::rgb8;
  EXPECT_EQ(open(), Errc::not_supported);
  EXPECT_EQ(why_,
            "/dev/video0 ('Simulated Camera'): rgb8 is not offered; the device has: YUYV (YUYV 4:2:2): 640x480 at 30, "
            "15 frames/s, 320x240 at 30, 15 frames/s; MJPG (Motion-JPEG): 1280x720 at 30 frames/s");
}

TEST_F(V4l2CameraOnSim, SizeThatIsNotListedIsRefusedWithTheList) {
  spec_.width = 800, spec_.height = 600;
  EXPECT_EQ(open(), Errc::bad_argument);
  EXPECT_EQ(why_, "/dev/video0 ('Simulated Camera'): 800x600 yuyv is not offered; it has 640x480, 320x240");
}

TEST_F(V4l2CameraOnSim, SizeLargerThanAnyImageIsRefusedBeforeTheDeviceIsAsked) {
  spec_.width = 1920, spec_.height = 1080;
  EXPECT_EQ(open(), Errc::bad_argument);
  EXPECT_THAT(why_, HasSubstr("1x1 to 1280x960; asked was 1920x1080 yuyv"));
}

TEST_F(V4l2CameraOnSim, RateThatIsNotListedIsRefusedWithTheList) {
  spec_.rate_hz = 25;
  EXPECT_EQ(open(), Errc::bad_argument);
  EXPECT_EQ(why_,
            "/dev/video0 ('Simulated Camera'): 320x240 yuyv at 25 frames/s is not offered; it has 30, 15 frames/s");
}

TEST_F(V4l2CameraOnSim, RateIsSetAndZeroLeavesItAsItIs) {
  spec_.rate_hz = 15;
  ASSERT_EQ(open(), std::nullopt) << why_;
  EXPECT_EQ(camera_->picture().rate_hz, 15);
  spec_.rate_hz = 0;
  ASSERT_EQ(open(), std::nullopt) << why_;
  EXPECT_EQ(camera_->picture().rate_hz, 30);
}

TEST_F(V4l2CameraOnSim, SizesInStepsAreHeldTo) {
  V4l2Sim steps(camera_with([](V4l2SimCamera& c) {
    c.offers = {{v4l2_code(msg::PixelFormat::mono8), "8-bit Greyscale", {{160, 120}, {640, 480}}, {1, 60}, true}};
  }));
  spec_.format = msg::PixelFormat::mono8;
  spec_.width = 322, spec_.rate_hz = 47.5;
  auto fits = on(steps);
  ASSERT_TRUE(fits) << why_;
  EXPECT_NEAR((*fits)->picture().rate_hz, 47.5, 0.01);
  spec_.width = 321;
  const auto odd = on(steps);
  ASSERT_FALSE(odd);
  EXPECT_THAT(why_, HasSubstr("321x240 mono8 is not offered; it has 160x120 to 640x480 in steps of 2x2"));
  spec_.width = 320, spec_.rate_hz = 61;
  ASSERT_FALSE(on(steps));
  EXPECT_THAT(why_, HasSubstr("61 frames/s is not offered; it has 1 to 60 frames/s"));
}

TEST_F(V4l2CameraOnSim, DeviceThatListsNothingAndGivesAnotherSizeIsRefused) {
  V4l2Sim silent(camera_with([](V4l2SimCamera& c) { c.lists_sizes = false; }));
  spec_.width = 322;
  const auto opened = on(silent);
  ASSERT_FALSE(opened);
  EXPECT_EQ(opened.error().code, Errc::bad_argument);
  EXPECT_THAT(why_, HasSubstr("asked for 322x240 YUYV, the device gives 320x240 YUYV"));
}

TEST_F(V4l2CameraOnSim, NodesThatAreNoCamerasAreRefused) {
  V4l2Sim metadata(camera_with([](V4l2SimCamera& c) { c.capabilities = V4L2_CAP_META_CAPTURE | V4L2_CAP_STREAMING; }));
  EXPECT_FALSE(on(metadata));
  EXPECT_THAT(why_, HasSubstr("is no capture device (a camera's second node has only its metadata)"));
  V4l2Sim planes(
      camera_with([](V4l2SimCamera& c) { c.capabilities = V4L2_CAP_VIDEO_CAPTURE_MPLANE | V4L2_CAP_STREAMING; }));
  EXPECT_FALSE(on(planes));
  EXPECT_THAT(why_, HasSubstr("several planes only"));
  V4l2Sim read_only(camera_with([](V4l2SimCamera& c) { c.capabilities = V4L2_CAP_VIDEO_CAPTURE; }));
  EXPECT_FALSE(on(read_only));
  EXPECT_THAT(why_, HasSubstr("cannot stream into mapped buffers"));
}

TEST_F(V4l2CameraOnSim, FewerThanTwoBuffersAreRefused) {
  spec_.buffers = 1;
  EXPECT_EQ(open(), Errc::bad_argument);
  EXPECT_THAT(why_, HasSubstr("buffers = 1: 2 to 32 are allowed"));
}

// ---- names

TEST_F(V4l2CameraOnSim, IsFoundByPathByIdBusAndCard) {
  for (const char* name :
       {"/dev/video0", "usb-Sinew_Simulated_Camera", "usb-Sinew_Simulated_Camera-video-index0", "usb-sim-1.2",
        "Simulated Camera", "/dev/v4l/by-id/usb-Sinew_Simulated_Camera-video-index0"}) {
    spec_.path = name;
    EXPECT_EQ(open(), std::nullopt) << name << ": " << why_;
  }
}

TEST_F(V4l2CameraOnSim, UnknownNameIsAnErrorThatSaysWhatThereIs) {
  spec_.path = "usb-9.9";
  EXPECT_EQ(open(), Errc::not_found);
  EXPECT_EQ(why_, "no camera 'usb-9.9': there is /dev/video0 'Simulated Camera' at usb-sim-1.2");
}

// ---- controls

TEST_F(V4l2CameraOnSim, ControlsAreSetByNameBeforeTheFirstFrame) {
  spec_.controls = {{"gain", 42}, {"auto_exposure", 1}, {"exposure_time_absolute", 50}};
  ASSERT_EQ(open(), std::nullopt) << why_;
  EXPECT_EQ(sim_.control("Gain"), 42);
  EXPECT_EQ(sim_.control("Auto Exposure"), 1);
  EXPECT_EQ(sim_.control("Exposure Time, Absolute"), 50);
}

TEST_F(V4l2CameraOnSim, EveryWrongControlIsNamedWithWhatIsAllowed) {
  spec_.controls = {{"gian", 42}, {"exposure_time_absolute", 0}};
  EXPECT_EQ(open(), Errc::bad_argument);
  EXPECT_EQ(
      why_,
      "/dev/video0 ('Simulated Camera'): control exposure_time_absolute = 0.000000 is not allowed: "
      "exposure_time_absolute 1 to 5000, is 156; control gian is not known; the device has: gain 0 to 100, is 20; "
      "auto_exposure 0 to 3, is 3; exposure_time_absolute 1 to 5000, is 156");
}

TEST_F(V4l2CameraOnSim, ControlIsChangedWhileFramesGoOn) {
  spec_.controls = {{"auto_exposure", 1}};
  ASSERT_EQ(open(), std::nullopt) << why_;
  const auto exposure = camera_->exposure();
  ASSERT_TRUE(exposure);
  EXPECT_EQ(exposure->unit, Duration(100us));
  ASSERT_TRUE(camera_->request(exposure->control, 40));
  ASSERT_TRUE(eventually([&] { return sim_.control("Exposure Time, Absolute") == 40; }));
  std::uint32_t number = 0;
  EXPECT_TRUE(eventually([&] { return deliver(number++) && read() && image_->exposure_ns == 4'000'000; }))
      << "stamps follow the exposure";
}

TEST_F(V4l2CameraOnSim, RequestOutsideOfTheRangeChangesNothing) {
  ASSERT_EQ(open(), std::nullopt) << why_;
  const auto gain = camera_->find("gain");
  ASSERT_TRUE(gain);
  for (const double wrong : {-1.0, 101.0, std::numeric_limits<double>::quiet_NaN()})
    EXPECT_FALSE(camera_->request(*gain, wrong));
  EXPECT_FALSE(camera_->request(99, 1));
  EXPECT_FALSE(camera_->find("gian"));
  ASSERT_TRUE(camera_->request(*gain, 77));
  EXPECT_TRUE(eventually([&] { return sim_.control("Gain") == 77; })) << "and not what was asked before";
  EXPECT_THAT(camera_->trouble(), Not(HasSubstr("gain"))) << "who asks is told; the camera is well";
}

TEST_F(V4l2CameraOnSim, RequestHitsAStepAlsoWhereTheLargestValueIsNone) {
  V4l2Sim sim(camera_with([](V4l2SimCamera& c) {
    c.controls = {{V4L2_CID_GAIN, V4L2_CTRL_TYPE_INTEGER, "Gain", 0, 255, 10, 20}};
  }));
  const auto opened = V4l2Camera::open(sim, spec_, system_os(), watch_, options_, why_);
  ASSERT_TRUE(opened) << why_;
  V4l2Camera& camera = **opened;
  for (const auto& [asked, set] : {std::pair{255.0, 250}, {34.0, 30}, {36.0, 40}, {249.0, 250}}) {
    ASSERT_TRUE(camera.request(*camera.gain(), asked));
    EXPECT_TRUE(eventually([&, set = set] { return sim.control("Gain") == set; })) << asked << camera.trouble();
  }
  EXPECT_THAT(camera.trouble(), Not(HasSubstr("gain")));
}

TEST_F(V4l2CameraOnSim, RangesAreThoseOfTheRateThatItWasBroughtTo) {
  V4l2Sim sensor(camera_with([](V4l2SimCamera& c) { c.exposure_in_period = true; }));
  spec_.rate_hz = 15;
  const auto opened = on(sensor);
  ASSERT_TRUE(opened) << why_;
  EXPECT_EQ((*opened)->controls().list().back().max, 666);
  spec_.rate_hz = 30, spec_.controls = {{"exposure_time_absolute", 400}};
  V4l2Sim faster(camera_with([](V4l2SimCamera& c) { c.exposure_in_period = true; }));
  EXPECT_FALSE(on(faster));
  EXPECT_THAT(why_, HasSubstr("exposure_time_absolute 1 to 333"));
}

TEST_F(V4l2CameraOnSim, CameraThatComesBackAndDoesNotAllowWhatWasSetStaysClosedAndSaysSo) {
  ASSERT_EQ(open(), std::nullopt) << why_;
  ASSERT_TRUE(camera_->request(*camera_->gain(), 80));
  ASSERT_TRUE(eventually([&] { return sim_.control("Gain") == 80; }));
  sim_.unplug();
  EXPECT_FALSE(read());
  sim_.set_range("Gain", 0, 50);
  sim_.plug_in();
  EXPECT_TRUE(eventually([&] {
    return camera_->trouble().find("control gain = 80.000000 is not allowed: gain 0 to 50") != std::string::npos;
  })) << camera_->trouble();
  EXPECT_EQ(camera_->stats().reopens, 0u);
  ASSERT_TRUE(camera_->request(*camera_->gain(), 50)) << "set to what this one takes, it is opened";
  EXPECT_TRUE(eventually([&] { return camera_->stats().reopens == 1 && sim_.control("Gain") == 50; }));
}

TEST_F(V4l2CameraOnSim, WhatItRefusedDoesNotKeepItClosedWhenItComesBack) {
  ASSERT_EQ(open(), std::nullopt) << why_;
  ASSERT_TRUE(camera_->request(*camera_->gain(), 80));
  ASSERT_TRUE(eventually([&] { return sim_.control("Gain") == 80; }));
  sim_.refuse(VIDIOC_S_EXT_CTRLS, ERANGE);
  ASSERT_TRUE(camera_->request(*camera_->gain(), 95));
  ASSERT_TRUE(eventually([&] { return camera_->trouble().find("the device refused gain") != std::string::npos; }));
  sim_.refuse(VIDIOC_S_EXT_CTRLS, 0);
  sim_.unplug();
  EXPECT_FALSE(read());
  sim_.plug_in();
  EXPECT_TRUE(eventually([&] { return camera_->stats().reopens == 1; })) << camera_->trouble();
  EXPECT_EQ(sim_.control("Gain"), 80) << "what it took last";
}

TEST_F(V4l2CameraOnSim, RefusalOfAControlIsSaidAndFramesGoOn) {
  ASSERT_EQ(open(), std::nullopt) << why_;
  sim_.refuse(VIDIOC_S_EXT_CTRLS, EBUSY);
  ASSERT_TRUE(camera_->request(*camera_->find("gain"), 30));
  EXPECT_TRUE(eventually([&] { return camera_->state().find("the device refused gain") != std::string::npos; }));
  ASSERT_TRUE(deliver(0));
  EXPECT_TRUE(read());
}

}  // namespace
}  // namespace sinew::hal::v4l2_camera_test
