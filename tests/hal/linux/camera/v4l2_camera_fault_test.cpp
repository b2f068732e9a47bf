// Faults of a camera, cell by cell: the text for the user, the error of read(), how the camera comes back.
#include <linux/videodev2.h>

#include "v4l2_fixture.hpp"

namespace sinew::hal::v4l2_camera_fault_test {
namespace {

using ::testing::HasSubstr;

class V4l2CameraFault : public V4l2Test {
 protected:
  void stream_from(std::uint32_t first) {
    ASSERT_EQ(open(), std::nullopt) << why_;
    ASSERT_TRUE(deliver(first));
    ASSERT_TRUE(read());
  }
  std::optional<Errc> error_of_read() {
    const auto got = camera_->read(*image_);
    return got ? std::nullopt : std::optional(got.error().code);
  }
};

TEST_F(V4l2CameraFault, AbsentAtStart) {
  sim_.unplug();
  EXPECT_EQ(open(), Errc::not_found);
  EXPECT_EQ(why_, "/dev/video0: there is no such device; no camera is there (or none may be opened by this user)");
}

TEST_F(V4l2CameraFault, PermissionDenied) {
  sim_.refuse(0, EACCES);
  EXPECT_EQ(open(), Errc::denied);
  EXPECT_EQ(
      why_,
      "/dev/video0: permission denied; add the user to the device's group (usually `usermod -aG video USER`, then "
      "log in again) or set a udev rule for /dev/video0");
}

TEST_F(V4l2CameraFault, Busy) {
  sim_.set_busy(true);
  EXPECT_EQ(open(), Errc::busy);
  EXPECT_EQ(why_,
            "/dev/video0 ('Simulated Camera'): setting 320x240 yuyv: another program uses the device; `fuser "
            "-v` on its path says which");
  sim_.set_busy(false);
  sim_.refuse(VIDIOC_STREAMON, EBUSY);
  EXPECT_EQ(open(), Errc::busy);
  EXPECT_THAT(why_, HasSubstr("VIDIOC_STREAMON: busy: another program uses it; `fuser /dev/video0` says which"));
}

TEST_F(V4l2CameraFault, UnpluggedAndPluggedInAgain) {
  spec_.controls = {{"gain", 42}};
  stream_from(7);
  WakeCounter wakes;
  camera_->set_wake(&wakes);
  const auto before = wakes.count();
  sim_.unplug();
  EXPECT_TRUE(eventually([&] { return wakes.count() > before; })) << "who waits for frames learns of it";
  EXPECT_EQ(error_of_read(), Errc::closed);
  ASSERT_TRUE(eventually([&] { return camera_->stats().tries >= 2; }));
  EXPECT_EQ(error_of_read(), Errc::closed) << "and goes on to say so";
  EXPECT_THAT(camera_->state(), HasSubstr("gone: No such device; tried "));
  EXPECT_THAT(camera_->state(), HasSubstr("/dev/video0: there is no such device"));
  EXPECT_THAT(camera_->trouble(), HasSubstr("gone: No such device; /dev/video0: there is no such device"))
      << "without counts, so that it is told once";
  EXPECT_EQ(sim_.descriptors(), 0u) << "the dead device is let go";
  ASSERT_TRUE(camera_->request(*camera_->find("gain"), 55)) << "asked for while it is away";
  sim_.plug_in();
  ASSERT_TRUE(eventually([&] { return sim_.streams() && camera_->stats().reopens == 1; }));
  EXPECT_EQ(sim_.control("Gain"), 55);
  EXPECT_FALSE(error_of_read());
  const std::uint32_t number = image_->frame_number;
  ASSERT_TRUE(deliver(30));
  ASSERT_TRUE(read());
  EXPECT_GT(image_->frame_number, number + 1) << "a gap shows that frames are missing";
  EXPECT_TRUE(same_pixels(30));
  EXPECT_THAT(camera_->state(), HasSubstr("1 time opened again"));
  EXPECT_EQ(camera_->trouble(), "");
  camera_->set_wake(nullptr);
}

TEST_F(V4l2CameraFault, PluggedInAgainAsAnotherNodeIsFoundByItsName) {
  spec_.path = "usb-Sinew_Simulated_Camera";
  stream_from(0);
  sim_.unplug();
  EXPECT_EQ(error_of_read(), Errc::closed);
  sim_.plug_in("/dev/video3");
  ASSERT_TRUE(eventually([&] { return camera_->stats().reopens == 1; }));
  ASSERT_TRUE(deliver(9));
  EXPECT_TRUE(read());
}

TEST_F(V4l2CameraFault, UnpluggedAgainAndAgain) {
  stream_from(0);
  for (std::uint32_t round = 1; round <= 20; ++round) {
    sim_.unplug();
    EXPECT_EQ(error_of_read(), Errc::closed);
    sim_.plug_in();
    ASSERT_TRUE(eventually([&] { return camera_->stats().reopens == round; })) << round;
    ASSERT_TRUE(deliver(round));
    ASSERT_TRUE(read()) << round;
  }
  EXPECT_EQ(camera_->stats().frames, 21u);
}

TEST_F(V4l2CameraFault, DestroyedWhileTheDeviceIsAway) {
  stream_from(0);
  sim_.unplug();
  EXPECT_EQ(error_of_read(), Errc::closed);
  camera_.reset();
  EXPECT_EQ(sim_.descriptors(), 0u);
}

TEST_F(V4l2CameraFault, BusyWhenItComesBackIsTriedAgain) {
  stream_from(0);
  sim_.set_busy(true);
  sim_.unplug();
  EXPECT_EQ(error_of_read(), Errc::closed);
  sim_.plug_in();
  EXPECT_TRUE(
      eventually([&] { return camera_->state().find("another program uses the device") != std::string::npos; }));
  sim_.set_busy(false);
  ASSERT_TRUE(eventually([&] { return camera_->stats().reopens == 1; }));
  ASSERT_TRUE(deliver(1));
  EXPECT_TRUE(read());
}

TEST_F(V4l2CameraFault, Silent) {
  options_.restart_after = 1ms;  // ten periods then count
  stream_from(0);
  sim_.set_fault(V4l2Fault::silent);
  EXPECT_FALSE(deliver(1));
  EXPECT_FALSE(error_of_read()) << "no data is normal";
  EXPECT_TRUE(eventually([&] { return camera_->stats().reopens >= 1; })) << "the stream is begun anew";
  sim_.set_fault(V4l2Fault::none);
  std::uint32_t number = 2;
  EXPECT_TRUE(eventually([&] { return deliver(number++) && read(); }));
}

TEST_F(V4l2CameraFault, SilenceIsSaid) {
  stream_from(0);
  EXPECT_TRUE(eventually([&] { return camera_->state().find("no frame for ") != std::string::npos; }))
      << camera_->state();
  EXPECT_THAT(camera_->trouble(), HasSubstr("is there, but sends no frames"));
  ASSERT_TRUE(deliver(1));
  ASSERT_TRUE(read());
  EXPECT_THAT(camera_->state(), HasSubstr("streaming 320x240 yuyv at 30 frames/s"));
}

TEST_F(V4l2CameraFault, GarbageMarkedByTheDriver) {
  stream_from(0);
  sim_.set_fault(V4l2Fault::corrupt);
  ASSERT_TRUE(deliver(1));
  EXPECT_EQ(error_of_read(), Errc::bad_data);
  EXPECT_FALSE(error_of_read());
  EXPECT_EQ(camera_->stats().corrupted, 1u);
  EXPECT_THAT(camera_->state(), HasSubstr("1 corrupted"));
  EXPECT_EQ(camera_->trouble(), "") << "one bad frame is no problem";
  sim_.set_fault(V4l2Fault::none);
  ASSERT_TRUE(deliver(2));
  ASSERT_TRUE(read());
  EXPECT_EQ(image_->frame_number, 2u) << "the dropped one leaves its gap";
  EXPECT_EQ(camera_->stats().lost, 0u) << "it was not lost by the driver";
  EXPECT_EQ(sim_.queued(), spec_.buffers);
}

TEST_F(V4l2CameraFault, GoodFrameBehindAFaultyOneIsReadAtOnce) {
  stream_from(0);
  sim_.set_fault(V4l2Fault::corrupt);
  ASSERT_TRUE(deliver(1));
  sim_.set_fault(V4l2Fault::none);
  ASSERT_TRUE(deliver(2));
  ASSERT_TRUE(read());
  EXPECT_TRUE(same_pixels(2));
}

TEST_F(V4l2CameraFault, GarbageThatIsTooShort) {
  stream_from(0);
  sim_.set_fault(V4l2Fault::short_frame);
  ASSERT_TRUE(deliver(1));
  EXPECT_EQ(error_of_read(), Errc::bad_data);
  EXPECT_EQ(camera_->stats().corrupted, 1u);
}

TEST_F(V4l2CameraFault, StuckAndDuplicateFramesAreNotHandedOnAgain) {
  stream_from(0);
  sim_.set_fault(V4l2Fault::stuck);
  for (std::uint32_t i = 1; i <= 3; ++i) ASSERT_TRUE(deliver(i));
  EXPECT_EQ(error_of_read(), Errc::bad_data);
  EXPECT_EQ(camera_->stats().repeated, 3u);
  EXPECT_EQ(camera_->stats().frames, 1u);
  EXPECT_THAT(camera_->state(), HasSubstr("3 repeated (no newer than the one before)"));
  sim_.set_fault(V4l2Fault::none);
  ASSERT_TRUE(deliver(4));
  EXPECT_TRUE(read());
}

TEST_F(V4l2CameraFault, SlowIsSaid) {
  stream_from(0);
  EXPECT_THAT(camera_->state(), HasSubstr("streaming"));
  sim_.set_fault(V4l2Fault::slow);
  for (std::uint32_t i = 1; i < 200; ++i) {
    if (deliver(i)) {
      ASSERT_TRUE(read());
    }
  }
  EXPECT_THAT(camera_->state(), HasSubstr("slow, 7.5 frames/s of 30"));
  EXPECT_EQ(camera_->stats().lost, 0u);
}

TEST_F(V4l2CameraFault, LossIsCounted) {
  stream_from(0);
  sim_.set_fault(V4l2Fault::loses);
  for (std::uint32_t i = 1; i <= 20; ++i) {
    if (deliver(i)) {
      ASSERT_TRUE(read());
    }
  }
  EXPECT_EQ(camera_->stats().frames, 1u + 10u);
  EXPECT_EQ(camera_->stats().lost, 10u);
  EXPECT_EQ(image_->frame_number, 20u);
}

TEST_F(V4l2CameraFault, DriverThatFailsIsOpenedAgain) {
  stream_from(0);
  sim_.set_fault(V4l2Fault::io_error);
  EXPECT_EQ(error_of_read(), Errc::closed);
  ASSERT_TRUE(eventually([&] { return camera_->stats().reopens == 1; }));
  ASSERT_TRUE(deliver(1));
  EXPECT_TRUE(read());
}

TEST_F(V4l2CameraFault, ReadingWhileItComesAndGoesNeverMixesFrames) {
  ASSERT_EQ(open(), std::nullopt) << why_;
  std::atomic<bool> done{false};
  auto world = system_os().start_thread(named("world"), [&] {
    for (std::uint32_t i = 0; i < 400; ++i) {
      if (i % 100 == 50) sim_.unplug();
      if (i % 100 == 55) sim_.plug_in();
      deliver(i);
      system_os().sleep_until(system_os().now() + 100us);
    }
    done = true;
  });
  ASSERT_TRUE(world);
  std::uint32_t last = 0;
  std::uint64_t frames = 0;
  while (!done.load()) {
    if (!read()) continue;
    const auto number = static_cast<std::uint8_t>(image_->row(0)[0]);
    ASSERT_TRUE(same_pixels(number));
    if (frames++ > 0) {
      ASSERT_LT(last, image_->frame_number);
    }
    last = image_->frame_number;
  }
  (*world)->join();
  EXPECT_GT(frames, 0u);
  EXPECT_EQ(frames, camera_->stats().frames);
}

}  // namespace
}  // namespace sinew::hal::v4l2_camera_fault_test
