// Images from outside the robot: bytes that somebody else may change at any moment become messages of an external
// topic.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <set>

#include "graph_fixture.hpp"
#include "msg/image.hpp"
#include "rt/external_source.hpp"
#include "rt/trap.hpp"
#include "trap.hpp"

namespace sinew::rt::outside_image_test {
namespace {

using ::testing::ElementsAre;

constexpr std::uint32_t kWidth = 16, kHeight = 4, kBytes = kWidth * kHeight;

/// The bytes of an image as another program hands them over: the header, then the pixels.
struct Picture {
  explicit Picture(std::uint8_t value) {
    image().set_bulk_capacity(kBytes);
    EXPECT_TRUE(image().format_as(msg::PixelFormat::mono8, kWidth, kHeight));
    std::fill(bytes.begin() + sizeof(msg::Image), bytes.end(), static_cast<std::byte>(value));
  }
  msg::Image& image() { return *reinterpret_cast<msg::Image*>(bytes.data()); }
  alignas(msg::Image) std::array<std::byte, sizeof(msg::Image) + kBytes> bytes{};
};

/// Memory of another process. What it says may change with every look.
class OtherMemory final : public hal::SharedMemory {
 public:
  explicit OtherMemory(std::span<const std::byte> bytes) : bytes_(bytes) {}
  std::byte* data() override { return nullptr; }
  std::size_t size() const override { return bytes_.size(); }
  bool copy(std::size_t offset, std::span<std::byte> into) const noexcept override {
    ++looks;
    if (offset > bytes_.size() || into.size() > bytes_.size() - offset) return false;
    std::memcpy(into.data(), bytes_.data() + offset, into.size());
    return true;
  }
  mutable int looks = 0;

 private:
  std::span<const std::byte> bytes_;
};

class Viewer final : public Module {
 public:
  Viewer() { values.reserve(1000), stamps.reserve(1000); }
  void declare(Declaration& d) override { d.in("image", in_, {.depth = 4}); }
  StepStatus step(const Step&) noexcept override {
    for (const msg::Image& image : in_) {
      for (std::uint32_t i = 1; i < kBytes; ++i)
        if (image.pixels()[i] != image.pixels()[0]) return StepStatus::fault;
      values.push_back(image.pixels()[0]);
      stamps.push_back(image.stamp);
    }
    return StepStatus::ok;
  }
  std::vector<int> values;
  std::vector<Time> stamps;

 private:
  InQueue<msg::Image> in_;
};

struct WatchingRobot : Robot {
  WatchingRobot() {
    viewer = &add<Viewer>("viewer", {{"image", "outside.image"}});
    periodic("main", 10, 1ms, {"viewer"});
    spec.topics.push_back({"outside.image", kBytes, 0, 0, ExternalSpec{"Image", "main"}, kBytes});
  }
  Viewer* viewer;
};

Time ms(std::int64_t n) { return Time{n * 1'000'000}; }

hal::Result<Ticket> show(Graph& graph, std::uint8_t value, Time stamp = {}, std::string* why = nullptr) {
  const Picture picture(value);
  return graph.publish("outside.image", OutsideMessage{.bytes = picture.bytes, .stamp = stamp}, why);
}

TEST(OutsideImage, IsPublishedInTheNextCycleWithItsOwnStampOrTheSteps) {
  WatchingRobot robot;
  Graph& graph = robot.build();
  robot.grants.at(Time{1'500'000}, [&] {
    EXPECT_TRUE(show(graph, 7, Time{1'200'000}));
    EXPECT_TRUE(show(graph, 8));
  });
  robot.grants.at(ms(4), [&] { EXPECT_TRUE(show(graph, 9, ms(1000))); });
  robot.run(6500us);
  EXPECT_THAT(robot.viewer->values, ElementsAre(7, 8, 9));
  EXPECT_THAT(robot.viewer->stamps, ElementsAre(Time{1'200'000}, ms(2), ms(5))) << "never later than the step";
}

TEST(OutsideImage, MoreThanTwoThatWaitAreRefusedAndNoneIsLost) {
  WatchingRobot robot;
  Graph& graph = robot.build();
  std::string why;
  std::vector<int> expected;
  for (int cycle = 0; cycle < 20; ++cycle)
    robot.grants.at(Time{500'000} + cycle * 1ms, [&] {
      for (int i = 0; i < 4; ++i) {
        const auto value = static_cast<std::uint8_t>(expected.size());
        if (show(graph, value, {}, &why)) expected.push_back(value);
      }
    });
  robot.run(22ms);
  EXPECT_EQ(expected.size(), 20u * ExternalSource::kImageRoom);
  EXPECT_EQ(robot.viewer->values, expected);
  EXPECT_EQ(why, "2 messages of outside.image wait already");
  EXPECT_EQ(graph.busy_posts(), 20u * 2);
}

TEST(OutsideImage, OfMemoryThatOthersChangeIsLookedAtOnce) {
  WatchingRobot robot;
  Graph& graph = robot.build();
  Picture picture(5);
  OtherMemory memory(picture.bytes);
  robot.grants.at(Time{500'000}, [&] {
    EXPECT_TRUE(graph.publish("outside.image", OutsideMessage{.memory = &memory, .size = memory.size()}));
    std::fill(picture.bytes.begin(), picture.bytes.end(), std::byte{0xFF});
  });
  robot.run(3ms);
  EXPECT_EQ(memory.looks, 1);
  EXPECT_THAT(robot.viewer->values, ElementsAre(5));
}

TEST(OutsideImage, OfMemoryThatIsTooShortIsRefusedAndGivesItsPlaceBack) {
  WatchingRobot robot;
  Graph& graph = robot.build();
  Picture picture(5);
  OtherMemory memory(picture.bytes);
  const std::size_t size = memory.size();
  robot.grants.at(Time{500'000}, [&] {
    for (const std::size_t offset : {std::size_t{1}, size, size + 1, SIZE_MAX - 1, SIZE_MAX})
      for (int i = 0; i < 5; ++i) {
        std::string why;
        const auto ticket =
            graph.publish("outside.image", OutsideMessage{.memory = &memory, .offset = offset, .size = size}, &why);
        ASSERT_FALSE(ticket);
        EXPECT_EQ(ticket.error().code, hal::Errc::bad_data) << why;
      }
    for (const std::size_t bytes : {std::size_t{0}, sizeof(msg::Image) - 1, size + 1, std::size_t{UINT32_MAX}})
      EXPECT_EQ(graph.publish("outside.image", OutsideMessage{.memory = &memory, .size = bytes}).error().code,
                hal::Errc::bad_argument);
    EXPECT_TRUE(show(graph, 1));
    EXPECT_TRUE(show(graph, 2)) << "both places are free";
  });
  robot.run(3ms);
  EXPECT_THAT(robot.viewer->values, ElementsAre(1, 2));
  EXPECT_EQ(graph.busy_posts(), 0u);
}

std::uint64_t hash_of_a_watching_run(std::uint8_t value) {
  WatchingRobot robot;
  Graph& graph = robot.build();
  for (std::uint8_t i = 0; i < 10; ++i)
    robot.grants.at(Time{300'000} + i * 1700us,
                    [&graph, i, value] { EXPECT_TRUE(show(graph, i == 5 ? value : i, Time{1 + i * 1'000'000})); });
  robot.run(20ms);
  EXPECT_EQ(robot.viewer->values.size(), 10u);
  return robot.hash("outside.image");
}

TEST(OutsideImage, TheSamePixelsBetweenTheSameGrantsGiveTheSameBytes) {
  const std::uint64_t a = hash_of_a_watching_run(5), b = hash_of_a_watching_run(5), other = hash_of_a_watching_run(6);
  EXPECT_EQ(a, b);
  EXPECT_NE(a, other);
}

TEST(OutsideImage, IsTakenWithoutAnAllocationLockOrCallOfTheKernel) {
  if (!sinew::trap::is_set()) GTEST_SKIP() << "no trap in this build";
  WatchingRobot robot;
  Graph& graph = robot.build();
  std::uint32_t calls = 0;
  class Trapped final : public hal::GrantSource {
   public:
    Trapped(std::uint32_t& calls, Graph& graph) : calls_(calls), graph_(graph) {}
    hal::Result<Time> next_grant(Time done) override {
      trap::state = {};
      if (done >= ms(200)) return hal::Error{hal::Errc::closed, "end"};
      EXPECT_TRUE(show(graph_, static_cast<std::uint8_t>(done.ns / 1'000'000)));
      trap::state = {"the executor's loop", &calls_};
      return done + 2ms;
    }

   private:
    std::uint32_t& calls_;
    Graph& graph_;
  } grants(calls, graph);
  DiscreteExecutor executor(graph, robot.clock, grants, {});
  ASSERT_TRUE(executor.run());
  trap::state = {};
  EXPECT_EQ(calls, 0u);
  EXPECT_EQ(robot.viewer->values.size(), 100u);
}

TEST(OutsideImage, NeverLeavesItsSlotOnTheWayToTheReaders) {
  WatchingRobot robot;
  Graph& graph = robot.build();
  EXPECT_EQ(graph.slots(graph.find_topic("outside.image")).held, ExternalSource::kImageRoom);
  EXPECT_EQ(graph.slots(graph.find_topic("outside.image")).burst, ExternalSource::kImageRoom);
}

}  // namespace
}  // namespace sinew::rt::outside_image_test
