// Frames of a plant as images of the board, over real sockets.
#include "rig.hpp"

namespace sinew::sim_hil::sim_camera_test {
namespace {

using hal::Errc;

std::uint8_t pixel(std::size_t i, std::uint32_t number) { return static_cast<std::uint8_t>(i * 7 + number * 31); }

void send_frame(PlantLink& plant, std::uint32_t number, Duration stamp) {
  const FrameSlot slot = plant.begin_frame(kCamera);
  for (std::size_t i = 0; i < slot.pixels.size(); ++i) slot.pixels[i] = pixel(i, number);
  ASSERT_TRUE(plant.send_frame(kCamera, slot, {at(stamp), at(stamp + 20ms), 4'000'000, number}));
}

class SimCameraPath : public testing::TestWithParam<bool> {
 protected:
  SimBoardOptions options() {
    SimBoardOptions o;
    o.accepts_shared_memory = GetParam();
    return o;
  }
};

TEST_P(SimCameraPath, FrameArrivesByteForByte) {
  Rig rig(
      [](PlantLink& plant) {
        send_frame(plant, 1, 10ms);
        ASSERT_TRUE(plant.grant(at(33ms)));
        send_frame(plant, 2, 43ms);
        static_cast<void>(plant.grant(at(66ms)));
      },
      options());
  ASSERT_EQ(rig.board->shares_memory(), GetParam());
  hal::Camera* camera = *rig.board->camera("camera");
  ImageBox image(1024);
  for (std::uint32_t number : {1u, 2u}) {
    const Time until = *rig.board->next_grant(number == 1 ? at(0ms) : at(33ms));
    EXPECT_EQ(camera->ready_at(), at(30ms + (number - 1) * 33ms));
    rig.clock.set(camera->ready_at() - 1ns);
    EXPECT_FALSE(*camera->read(*image));
    rig.clock.set(until);
    ASSERT_TRUE(*camera->read(*image));
    EXPECT_EQ(image->frame_number, number);
    EXPECT_EQ(image->stamp, at(10ms + (number - 1) * 33ms));
    EXPECT_EQ(image->exposure_ns, 4'000'000);
    EXPECT_EQ(image->width, 16u);
    EXPECT_EQ(image->height, 8u);
    EXPECT_EQ(image->stride, 32u);
    EXPECT_EQ(image->format, msg::PixelFormat::yuyv);
    const auto got = image.pixels();
    ASSERT_EQ(got.size(), 256u);
    for (std::size_t i = 0; i < got.size(); ++i) ASSERT_EQ(got[i], pixel(i, number)) << i;
  }
}

TEST_P(SimCameraPath, FrameThatDoesNotFitTheMessageIsDropped) {
  Rig rig(
      [](PlantLink& plant) {
        send_frame(plant, 1, 10ms);
        static_cast<void>(plant.grant(at(33ms)));
      },
      options());
  hal::Camera* camera = *rig.board->camera("camera");
  ASSERT_TRUE(rig.board->next_grant({}));
  rig.clock.set(at(33ms));
  ImageBox small(255);
  EXPECT_EQ(camera->read(*small).error().code, Errc::bad_argument);
  EXPECT_FALSE(*camera->read(*small));
}

TEST_P(SimCameraPath, SkippedFrameNumbersAreLostFrames) {
  Rig rig(
      [](PlantLink& plant) {
        send_frame(plant, 1, 10ms);
        send_frame(plant, 4, 110ms);
        static_cast<void>(plant.grant(at(200ms)));
      },
      options());
  static_cast<void>(*rig.board->camera("camera"));
  ASSERT_TRUE(rig.board->next_grant({}));
  EXPECT_EQ(rig.board->stats().devices[kCamera].lost, 2u);
}

TEST_P(SimCameraPath, SlowReaderGetsTheNewestFramesAndTheRestIsCounted) {
  Rig rig(
      [](PlantLink& plant) {
        for (std::uint32_t n = 0; n < 6; ++n) send_frame(plant, n, n * 33ms);
        static_cast<void>(plant.grant(at(400ms)));
      },
      options());
  hal::Camera* camera = *rig.board->camera("camera");
  ASSERT_TRUE(rig.board->next_grant({}));
  rig.clock.set(at(400ms));
  ImageBox image(256);
  std::vector<std::uint32_t> numbers;
  while (*camera->read(*image)) {
    numbers.push_back(image->frame_number);
    ASSERT_EQ(image.pixels()[100], pixel(100, image->frame_number));
  }
  EXPECT_EQ(numbers, (std::vector<std::uint32_t>{2, 3, 4, 5}));
  EXPECT_EQ(rig.board->stats().devices[kCamera].overflow, 2u);
}

INSTANTIATE_TEST_SUITE_P(Frames, SimCameraPath, testing::Values(true, false),
                         [](const auto& path) { return path.param ? "InSharedMemory" : "InTheStream"; });

TEST(SimLockstep, FrameOverwrittenBeforeItWasReadIsAnErrorNotAPicture) {
  Rig rig([](PlantLink& plant) {
    send_frame(plant, 1, 0ms);
    ASSERT_TRUE(plant.grant(at(33ms)));
    for (std::uint32_t i = 0; i < PlantLink::kFrameSlots; ++i) static_cast<void>(plant.begin_frame(kCamera));
    static_cast<void>(plant.grant(at(34ms)));
  });
  ASSERT_TRUE(rig.board->shares_memory());
  hal::Camera* camera = *rig.board->camera("camera");
  ASSERT_TRUE(rig.board->next_grant({}));
  ASSERT_TRUE(rig.board->next_grant(at(33ms)));
  rig.clock.set(at(34ms));
  ImageBox image(256);
  EXPECT_EQ(camera->read(*image).error().code, Errc::bad_data);
  EXPECT_EQ(rig.board->stats().devices[kCamera].lost, 1u);
  EXPECT_FALSE(*camera->read(*image));
}

}  // namespace
}  // namespace sinew::sim_hil::sim_camera_test
