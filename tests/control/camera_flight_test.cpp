// Flights in the plant with its camera's pixels and the pad finder in the loop, still without executor.
#include <gmock/gmock.h>

#include "flight.hpp"
#include "plant_world.hpp"
#include "qemu_user.hpp"
#include "robots/quad/world/room_xml.hpp"
#include "sim_hil/plant/renderer.hpp"
#include "vision/pad_finder.hpp"
#include "vision/pinhole.hpp"

namespace sinew::control::test::camera_flight_test {
namespace {

constexpr std::uint32_t kWidth = 320, kHeight = 240;

class CameraFlight : public ::testing::TestWithParam<int> {};

TEST_P(CameraFlight, LandsOnThePadThatItSees) {
  std::string why;
  auto renderer = plant::Renderer::create({kWidth, kHeight, false, robots::room_xml_of_quad()}, why);
  if (!renderer) SINEW_SKIP_UNDER_QEMU_USER(why);
  ASSERT_TRUE(renderer) << why;
  plant::QuadOptions o;
  o.seed = static_cast<std::uint64_t>(GetParam());
  PlantWorld world(o);
  ASSERT_TRUE(world.good());
  vision::PadFinder finder({}, {.max_runs = 8192, .min_area_px = 12});
  const auto pinhole = vision::Pinhole::from_fov(1.0382921838, kWidth, kHeight);
  std::vector<std::uint8_t> pixels(kWidth * kHeight * 2);

  Flight flight(world, o.seed);
  flight.look = [&](msg::Time stamp) {
    (*renderer)->camera_view(world.quad().camera_pose(), msg::PixelFormat::yuyv, pixels.data());
    const vision::PadCircle pad = finder.find({pixels.data(), kWidth, kHeight, kWidth * 2, msg::PixelFormat::yuyv});
    msg::PadSighting s;
    s.stamp = stamp;
    if (!pad.found) return s;
    s.found = 1;
    s.direction_optical = pinhole.direction(pad.circle.x, pad.circle.y);
    s.confidence = pad.confidence;
    return s;
  };
  const FlightReport r = flight.run(90);
  EXPECT_EQ(r.phase, msg::MissionPhase::done);
  EXPECT_TRUE(world.summary().touched_down);
  EXPECT_FALSE(world.summary().crashed);
  EXPECT_LT(world.summary().touchdown_error_m, 0.15);
  EXPECT_LT(world.summary().touchdown_speed_mps, 0.5);
}
INSTANTIATE_TEST_SUITE_P(Seeds, CameraFlight, ::testing::Values(21, 22));

}  // namespace
}  // namespace sinew::control::test::camera_flight_test
