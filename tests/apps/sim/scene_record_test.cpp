#include "apps/sim/scene_record.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>

namespace sinew::plant::scene_record_test {
namespace {

TakenScene sample() {
  TakenScene scene;
  scene.at.ns = 1'300'000'000;
  scene.bodies = {{{1, 2, 3}, {0.5, -0.5, 0.5, -0.5}}, {{-0.1, 1e-300, 7}, {1, 0, 0, 0}}};
  scene.pictures = {{0, 0, 13, {{0.1, 0.2, 0.3}, {0, 1, 0, 0}, 0.875}}, {1, 1, 12, {{4, 5, 6}, {1, 0, 0, 0}, 1.5}}};
  return scene;
}

TEST(TakenScene, ComesBackFromItsBytesExactly) {
  const TakenScene scene = sample();
  record::Buffer bytes;
  encode(bytes, scene);
  const auto again = decode_scene(bytes.bytes());
  ASSERT_TRUE(again);
  EXPECT_EQ(again->at, scene.at);
  ASSERT_EQ(again->bodies.size(), 2u);
  EXPECT_EQ(again->bodies[1].p_world_m.y, 1e-300);
  EXPECT_EQ(again->bodies[0].q_world.y, 0.5);
  ASSERT_EQ(again->pictures.size(), 2u);
  EXPECT_EQ(again->pictures[0].number, 13u);
  EXPECT_EQ(again->pictures[1].robot, 1u);
  EXPECT_EQ(again->pictures[1].camera, 1u);
  EXPECT_EQ(again->pictures[1].pose.focal_per_height, 1.5);
  record::Buffer same;
  encode(same, *again);
  EXPECT_TRUE(std::ranges::equal(bytes.bytes(), same.bytes()));
}

TEST(TakenScene, BytesThatAreNoneAreRefusedWhereverTheyEndOrChange) {
  record::Buffer bytes;
  encode(bytes, sample());
  for (std::size_t size = 0; size < bytes.size(); ++size) EXPECT_FALSE(decode_scene(bytes.bytes().first(size))) << size;
  for (std::size_t at = 0; at < bytes.size(); ++at)
    for (const std::uint8_t value : std::array<std::uint8_t, 4>{0x00, 0x7f, 0x80, 0xff}) {
      const std::byte before = bytes.data()[at];
      bytes.data()[at] = std::byte{value};
      if (const auto read = decode_scene(bytes.bytes())) {  // another number, but no more of them than there are bytes
        EXPECT_LE(read->bodies.size() * 7 * 8 + read->pictures.size() * 11 * 8, bytes.size());
      }
      bytes.data()[at] = before;
    }
}

TEST(TakenScene, IsWhatThePainterTakes) {
  const TakenScene taken = sample();
  const Scene scene = taken.scene(taken.pictures[1].pose);
  EXPECT_EQ(scene.bodies, 2u);
  EXPECT_EQ(scene.body[1].p_world_m.z, 7);
  EXPECT_EQ(scene.camera.p_world_m.x, 4);
}

}  // namespace
}  // namespace sinew::plant::scene_record_test
