#include "record/run/player.hpp"

#include <gmock/gmock.h>

#include <cstring>
#include <thread>

#include "../../rt/topic_fixture.hpp"
#include "msg/image_buffer.hpp"
#include "rt/exec/module_rig.hpp"

namespace sinew::record::player_test {
namespace {

using namespace std::chrono_literals;
using ::testing::ElementsAre;
using Handed = Player::Handed;

rt::Time at(int ms) { return rt::Time{1'000'000 * ms}; }

rt::Pair pair(std::uint32_t number) {
  rt::Pair p;
  p.stamp = rt::Time{77};
  p.number = number;
  return p;
}

std::vector<std::uint32_t> numbers(const rt::ModuleRig& rig) {
  std::vector<std::uint32_t> all;
  for (const rt::Pair* p : rig.all<rt::Pair>("out")) all.push_back(static_cast<std::uint32_t>(p->number));
  return all;
}

TEST(Player, SaysEachMessageInTheFirstStepInWhichItIsDue) {
  Player player({{"out", &msg::type_info<rt::Pair>()}});
  rt::ModuleRig rig(player);
  for (std::uint32_t i = 0; i < 5; ++i) {
    const rt::Pair p = pair(i);
    ASSERT_EQ(player.hand(0, at(10 + 2 * static_cast<int>(i)), &p), Handed::yes);
  }
  rig.step(at(9), 1ms);
  EXPECT_THAT(numbers(rig), ElementsAre());
  rig.step(at(10), 1ms);
  EXPECT_THAT(numbers(rig), ElementsAre(0));
  EXPECT_EQ(rig.get<rt::Pair>("out")->stamp, rt::Time{77}) << "as recorded";
  EXPECT_FALSE(player.idle());
  rig.step(at(100), 1ms);
  EXPECT_THAT(numbers(rig), ElementsAre(1, 2, 3, 4));
  EXPECT_TRUE(player.idle());
}

TEST(Player, MoreThanABurstGoesOnWithTheNextStepAndNothingIsLost) {
  Player player({{"out", &msg::type_info<rt::Pair>()}});
  rt::ModuleRig rig(player);
  std::uint32_t handed = 0;
  for (rt::Pair p = pair(0); player.hand(0, at(1), &p) == Handed::yes; p = pair(++handed)) {
  }
  EXPECT_EQ(handed, 256u) << "then there is no room";
  std::vector<std::uint32_t> said;
  for (int t = 1; !player.idle(); ++t) {
    rig.step(at(t), 1ms);
    EXPECT_LE(numbers(rig).size(), 32u);
    for (const std::uint32_t n : numbers(rig)) said.push_back(n);
  }
  ASSERT_EQ(said.size(), handed);
  for (std::uint32_t i = 0; i < handed; ++i) EXPECT_EQ(said[i], i);
}

TEST(Player, SaysImagesWithTheirPixelsAndRefusesThoseThatDoNotFit) {
  Player player({{"image", &msg::type_info<msg::Image>(), 64}});
  rt::ModuleRig rig(player, {.image_bytes = 64});
  msg::ImageBuffer image(100);
  ASSERT_TRUE(image->format_as(msg::PixelFormat::mono8, 8, 8));
  for (int i = 0; i < 64; ++i) image->pixels()[i] = static_cast<std::uint8_t>(i);
  ASSERT_EQ(player.hand(0, at(1), &*image), Handed::yes);
  ASSERT_TRUE(image->format_as(msg::PixelFormat::mono8, 9, 9));
  EXPECT_EQ(player.hand(0, at(1), &*image), Handed::too_large);
  rig.step(at(1), 1ms);
  const auto* said = rig.get<msg::Image>("image");
  ASSERT_TRUE(said);
  EXPECT_EQ(said->width, 8u);
  EXPECT_EQ(said->capacity_bytes, 64u) << "the slot's own, not the recorded one's";
  EXPECT_EQ(said->pixels()[63], 63);
}

TEST(Player, AnotherThreadMayHandOver) {
  Player player({{"out", &msg::type_info<rt::Pair>()}});
  rt::ModuleRig rig(player);
  constexpr std::uint32_t kAll = 5000;
  std::thread feeder([&] {
    for (std::uint32_t i = 0; i < kAll; ++i) {
      const rt::Pair p = pair(i);
      while (player.hand(0, at(0), &p) == Handed::no_room) std::this_thread::yield();
    }
  });
  std::uint32_t next = 0;
  for (int t = 1; next < kAll; ++t) {
    rig.step(at(t), 1ms);
    for (const std::uint32_t n : numbers(rig)) ASSERT_EQ(n, next++);
  }
  feeder.join();
}

}  // namespace
}  // namespace sinew::record::player_test
