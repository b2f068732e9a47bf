// libsinew_client.so as a C program uses it, on a robot of this process.
#include <sys/mman.h>

#include <cstddef>
#include <cstring>
#include <thread>

#include "../tap/tap_rig.hpp"
#include "client/sinew_client.h"

namespace sinew::tap::client_test {
namespace {

OwnRunDir g_run_dir;

// What other languages count on; docs/clients.md has the rule.
static_assert(sizeof(sinew_message) == 2 * sizeof(void*) + 16 + 16 + 24);
static_assert(offsetof(sinew_message, stamp_ns) == 2 * sizeof(void*) + 16);
static_assert(offsetof(sinew_topic, message_bytes) == 2 * sizeof(void*) && offsetof(sinew_topic, rate_hz) % 8 == 0);
static_assert(offsetof(sinew_field, kind) == 4 * sizeof(void*) && offsetof(sinew_value, integer) == 8);

class Handle {
 public:
  explicit Handle(const char* name = "robot") {
    if (sinew_attach(name, &robot_) != SINEW_OK) ADD_FAILURE() << sinew_last_error();
  }
  ~Handle() { sinew_detach(robot_); }
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  sinew_robot* get() const { return robot_; }
  std::uint32_t topic(const char* name) const {
    std::uint32_t topic = 0;
    EXPECT_EQ(sinew_topic_find(robot_, name, &topic), SINEW_OK) << sinew_last_error();
    return topic;
  }
  std::string request(const char* name, const char* arguments = nullptr) const {
    const char* reply = nullptr;
    EXPECT_EQ(sinew_request(robot_, name, arguments, &reply), SINEW_OK) << sinew_last_error();
    return reply ? reply : "";
  }

 private:
  sinew_robot* robot_ = nullptr;
};

double range_of(const Handle& handle, const sinew_message& m) {
  sinew_field field{};
  EXPECT_EQ(sinew_field_find(handle.get(), m.topic, "range_m", &field), SINEW_OK);
  EXPECT_EQ(field.kind, static_cast<std::uint32_t>(SINEW_F64));
  double value = 0;
  std::memcpy(&value, static_cast<const char*>(m.data) + field.offset, sizeof value);
  return value;
}

TEST(CClient, ListsTheRobotsThatRunAndNamesWhatDoesNot) {
  Robot robot({.name = "quad"});
  robot.start();
  sinew_robots* list = nullptr;
  ASSERT_EQ(sinew_robots_list(&list), SINEW_OK) << sinew_last_error();
  ASSERT_EQ(sinew_robots_count(list), 1U);
  EXPECT_STREQ(sinew_robots_name(list, 0), "quad");
  EXPECT_EQ(sinew_robots_pid(list, 0), ::getpid());
  EXPECT_EQ(sinew_robots_name(list, 1), nullptr);
  sinew_robots_free(list);
  sinew_robot* none = nullptr;
  EXPECT_EQ(sinew_attach("quat", &none), SINEW_NOT_FOUND);
  EXPECT_STREQ(sinew_last_error(), "no robot \"quat\" runs; there is quad; did you mean quad?");
  EXPECT_STREQ(sinew_code_name(SINEW_NOT_FOUND), "not_found");
}

TEST(CClient, DescribesFieldsSoThatNoHeaderOfARobotIsNeeded) {
  Robot robot({.graph = {.camera = true}});
  robot.start();
  Handle handle;
  EXPECT_STREQ(sinew_name(handle.get()), "robot");
  sinew_topic about{};
  ASSERT_EQ(sinew_topic_at(handle.get(), handle.topic("outside.image"), &about), SINEW_OK);
  EXPECT_STREQ(about.type, "Image");
  EXPECT_EQ(about.message_bytes, sizeof(msg::Image));
  EXPECT_EQ(about.bulk_bytes, 2 * Eye::kWidth * Eye::kHeight);
  EXPECT_NE(about.is_external, 0);
  sinew_field width{}, format{};
  ASSERT_EQ(sinew_field_find(handle.get(), handle.topic("eye.image"), "width", &width), SINEW_OK);
  EXPECT_EQ(width.offset, offsetof(msg::Image, width));
  EXPECT_STREQ(width.unit, "px");
  ASSERT_EQ(sinew_field_find(handle.get(), handle.topic("eye.image"), "format", &format), SINEW_OK);
  EXPECT_STREQ(format.names, R"({"none":0,"mono8":1,"rgb8":2,"bgr8":3,"yuyv":4})");
  EXPECT_EQ(sinew_field_find(handle.get(), handle.topic("eye.image"), "widht", &width), SINEW_NOT_FOUND);
  EXPECT_EQ(sinew_topic_at(handle.get(), 1000, &about), SINEW_BAD_ARGUMENT);
  std::uint32_t topic = 0;
  EXPECT_EQ(sinew_topic_find(handle.get(), "eye.imgae", &topic), SINEW_NOT_FOUND);
  EXPECT_STREQ(sinew_last_error(), "no topic eye.imgae; did you mean eye.image?");
}

TEST(CClient, WaitGivesEachNewestMessageOnceAndCountsTheMissed) {
  Robot robot;
  robot.start();
  Handle handle;
  const std::uint32_t range = handle.topic("counter.range");
  sinew_message m{};
  std::uint32_t last = 0;
  for (int i = 0; i < 20; ++i) {
    ASSERT_EQ(sinew_wait(handle.get(), range, 5'000'000'000, &m), SINEW_OK) << sinew_last_error();
    const double value = range_of(handle, m);
    if (!sinew_still_valid(handle.get(), &m)) continue;
    EXPECT_EQ(m.sequence, i == 0 ? m.sequence : last + m.missed + 1);
    EXPECT_GT(value, 0);
    EXPECT_GE(m.published_ns, m.stamp_ns);
    last = m.sequence;
  }
}

TEST(CClient, NextGivesEveryMessage) {
  Robot robot;
  robot.start();
  Handle handle;
  const std::uint32_t range = handle.topic("counter.range");
  sinew_message m{};
  double last = 0;
  for (int i = 0; i < 50; ++i) {
    ASSERT_EQ(sinew_next(handle.get(), range, 5'000'000'000, &m), SINEW_OK) << sinew_last_error();
    const double value = range_of(handle, m);
    EXPECT_EQ(value, i > 0 && m.missed == 0 ? last + 1 : value);
    last = value;
  }
}

TEST(CClient, AWaitForATopicThatNobodyWritesEndsWithTheTime) {
  Robot robot;
  robot.start();
  Handle handle;
  sinew_message m{};
  EXPECT_EQ(sinew_latest(handle.get(), handle.topic("operator.range"), &m), SINEW_NOT_FOUND);
  EXPECT_EQ(sinew_wait(handle.get(), handle.topic("operator.range"), 1'000'000, &m), SINEW_TIMEOUT);
  EXPECT_STREQ(sinew_last_error(), "operator.range: no new message in time");
}

TEST(CClient, AWaitEndsWhenTheRobotDoes) {
  Robot robot;
  robot.start();
  Handle handle;
  std::thread end([&] {
    std::this_thread::sleep_for(20ms);
    robot.server.reset();
  });
  sinew_message m{};
  EXPECT_EQ(sinew_wait(handle.get(), handle.topic("operator.range"), INT64_MAX, &m), SINEW_CLOSED);
  end.join();
  EXPECT_EQ(sinew_request(handle.get(), "status", nullptr, nullptr), SINEW_BAD_ARGUMENT);
}

TEST(CClient, ReadsPixelsInPlaceAndSaysWhenTheyAreGone) {
  Robot robot;
  robot.start();
  Handle handle;
  const std::uint32_t image = handle.topic("eye.image");
  sinew_message m{};
  ASSERT_EQ(sinew_wait(handle.get(), image, 5'000'000'000, &m), SINEW_OK) << sinew_last_error();
  EXPECT_EQ(m.bulk_bytes, Eye::kWidth * Eye::kHeight);
  std::vector<std::uint8_t> copy(m.message_bytes + m.bulk_bytes);
  ASSERT_EQ(sinew_copy(handle.get(), &m, copy.data(), copy.size()), SINEW_OK) << sinew_last_error();
  for (std::size_t i = m.message_bytes; i < copy.size(); ++i) ASSERT_EQ(copy[i], copy[m.message_bytes]);
  EXPECT_EQ(sinew_copy(handle.get(), &m, copy.data(), copy.size() - 1), SINEW_BAD_ARGUMENT);
  sinew_message old{};
  std::uint64_t after = 0;
  for (int tries = 0; tries < 20 && after != 5;
       ++tries) {  // a reader that has no processor for a while sees another number
    old = m;
    while (sinew_still_valid(handle.get(), &old))
      ASSERT_EQ(sinew_next(handle.get(), image, 5'000'000'000, &m), SINEW_OK) << sinew_last_error();
    after = m.sequence - old.sequence;
  }
  EXPECT_EQ(after, 5U) << "the topic keeps five";
  EXPECT_EQ(sinew_copy(handle.get(), &old, copy.data(), copy.size()), SINEW_OVERWRITTEN);
}

TEST(CClient, SetsParametersWithinTheirRange) {
  Robot robot;
  robot.start();
  Handle handle;
  sinew_value value{};
  value.kind = SINEW_NUMBER, value.number = 2.5;
  ASSERT_EQ(sinew_param_set(handle.get(), "counter", "gain", &value), SINEW_OK) << sinew_last_error();
  value = {};
  ASSERT_EQ(sinew_param_get(handle.get(), "counter", "gain", &value), SINEW_OK);
  EXPECT_EQ(value.kind, SINEW_NUMBER);
  EXPECT_EQ(value.number, 2.5);
  ASSERT_EQ(sinew_param_get(handle.get(), "counter", "label", &value), SINEW_OK);
  EXPECT_STREQ(value.text, "a \"label\"");
  value.kind = SINEW_INTEGER, value.integer = 77;
  EXPECT_EQ(sinew_param_set(handle.get(), "counter", "gain", &value), SINEW_BAD_ARGUMENT);
  EXPECT_STREQ(sinew_last_error(), "counter.gain: 77: a number from 0 to 10");
  EXPECT_EQ(sinew_param_get(handle.get(), "counter", "gian", &value), SINEW_NOT_FOUND);
}

TEST(CClient, ARequestGivesTheReplyAlsoWhenItIsRefused) {
  Robot robot;
  robot.start();
  Handle handle;
  EXPECT_NE(handle.request("hello").find("\"robot\":\"robot\""), std::string::npos);
  const char* reply = nullptr;
  EXPECT_EQ(sinew_request(handle.get(), "halo", nullptr, &reply), SINEW_NOT_FOUND);
  ASSERT_NE(reply, nullptr);
  EXPECT_NE(std::string(reply).find("\"ok\":false"), std::string::npos);
}

TEST(CClient, KnowsTheRobotsClock) {
  Robot robot;
  robot.start();
  Handle handle;
  std::int64_t now = 0, offset = -1;
  const hal::Time before = robot.os.now();
  ASSERT_EQ(sinew_now(handle.get(), &now, &offset), SINEW_OK) << sinew_last_error();
  EXPECT_GE(now, before.ns);
  EXPECT_LE(now, robot.os.now().ns);
  EXPECT_EQ(offset, 0) << "in real time it is this machine's";
}

// ---- messages to the robot

struct Camera : testing::Test {
  Camera() : robot({.graph = {.camera = true}}) {
    robot.start();
    handle.emplace();
    topic = handle->topic("outside.image");
  }
  static msg::Image& image_of(void* message) { return *static_cast<msg::Image*>(message); }
  /// Describes mono8 pixels in a loan and fills them with one value.
  std::size_t draw(std::uint8_t value) {
    void *message = nullptr, *bulk = nullptr;
    std::size_t room = 0;
    EXPECT_EQ(sinew_loan(handle->get(), topic, &message, &bulk, &room), SINEW_OK) << sinew_last_error();
    EXPECT_EQ(room, 2 * Eye::kWidth * Eye::kHeight);
    msg::Image& image = image_of(message);
    image.set_bulk_capacity(static_cast<std::uint32_t>(room));
    EXPECT_TRUE(image.format_as(msg::PixelFormat::mono8, Eye::kWidth, Eye::kHeight));
    std::memset(bulk, value, room);
    loaned = &image;
    return Eye::kWidth * Eye::kHeight;
  }
  Robot robot;
  std::optional<Handle> handle;
  std::uint32_t topic = 0;
  msg::Image* loaned = nullptr;
};

TEST_F(Camera, OfAnotherProcessIsASourceOfTheRobot) {
  std::int64_t now = 0;
  for (std::uint8_t i = 1; i < 10; ++i) {
    ASSERT_EQ(sinew_now(handle->get(), &now, nullptr), SINEW_OK);
    const std::size_t used = draw(i);
    ASSERT_EQ(sinew_send(handle->get(), used, now, 0), SINEW_OK) << sinew_last_error();
    sinew_message m{};
    ASSERT_EQ(sinew_wait(handle->get(), topic, 5'000'000'000, &m), SINEW_OK) << sinew_last_error();
    EXPECT_EQ(m.stamp_ns, now) << "the camera's own stamp";
    EXPECT_GE(m.published_ns, now);
    ASSERT_EQ(m.bulk_bytes, used);
    EXPECT_EQ(static_cast<const std::uint8_t*>(m.bulk)[0], i);
    EXPECT_EQ(static_cast<const std::uint8_t*>(m.bulk)[used - 1], i);
  }
}

TEST_F(Camera, IsRefusedWithTheReasonWhenItsHeaderLies) {
  const auto refused = [&](std::size_t used, std::int64_t stamp = 0) {
    EXPECT_EQ(sinew_send(handle->get(), used, stamp, 0), SINEW_BAD_ARGUMENT);
    return std::string(sinew_last_error());
  };
  const std::string rows = "an image whose rows do not fit its bytes";
  const std::size_t used = draw(1);
  EXPECT_EQ(refused(used - 1), rows);
  loaned->height = 0;
  EXPECT_EQ(refused(used), rows);
  loaned->height = Eye::kHeight, loaned->stride = Eye::kWidth - 1;
  EXPECT_EQ(refused(used), rows) << "rows that overlap";
  loaned->stride = 0xFFFFFFFF;
  EXPECT_EQ(refused(used), rows);
  loaned->stride = Eye::kWidth, loaned->format = static_cast<msg::PixelFormat>(77);
  EXPECT_EQ(refused(used), rows);
  loaned->format = msg::PixelFormat::mono8, loaned->height = 2 * Eye::kHeight;
  EXPECT_EQ(refused(2 * used), "an image with more pixels than the robot file has");
  loaned->height = Eye::kHeight, loaned->width = 0x80000001;
  EXPECT_EQ(refused(used), rows);
  loaned->width = Eye::kWidth;
  EXPECT_NE(refused(used, robot.os.now().ns + 3'600'000'000'000).find("an integer from 1 to the robot's present time"),
            std::string::npos);
  EXPECT_NE(refused(used, -1).find("an integer from 1"), std::string::npos);
  EXPECT_NE(refused(10 * used).find("bytes of pixels"), std::string::npos);
  EXPECT_EQ(sinew_send(handle->get(), used, 0, 0), SINEW_OK) << "and then it is good: " << sinew_last_error();
}

TEST_F(Camera, DoesNotWaitForTheLoopWhenItDoesNotWantTo) {
  int sent = 0, busy = 0;
  while (sent < 6 || busy == 0) {  // faster than the loop, and through several of its cycles
    const std::size_t used = draw(7);
    const int code = sinew_send(handle->get(), used, 0, SINEW_NO_WAIT);
    ++(code == SINEW_OK ? sent : busy);
    if (code == SINEW_OK) continue;
    ASSERT_EQ(code, SINEW_BUSY) << sinew_last_error();
    ASSERT_STREQ(sinew_last_error(), "2 messages of outside.image wait already");
    std::this_thread::sleep_for(1ms);
  }
}

TEST_F(Camera, ShortMessagesComeInTheSameWay) {
  const std::uint32_t range = handle->topic("operator.range");
  const msg::RangeSample sample{{}, 3.25};
  ASSERT_EQ(sinew_publish(handle->get(), range, &sample, sizeof sample, nullptr, 0, 0, 0), SINEW_OK)
      << sinew_last_error();
  sinew_message m{};
  ASSERT_EQ(sinew_wait(handle->get(), range, 5'000'000'000, &m), SINEW_OK) << sinew_last_error();
  EXPECT_EQ(range_of(*handle, m), 3.25);
  EXPECT_GT(m.stamp_ns, 0) << "the instant of the step";
  EXPECT_EQ(sinew_publish(handle->get(), range, &sample, sizeof sample - 1, nullptr, 0, 0, 0), SINEW_BAD_ARGUMENT);
  const msg::RangeSample no_number{{}, std::numeric_limits<double>::quiet_NaN()};
  EXPECT_EQ(sinew_publish(handle->get(), range, &no_number, sizeof no_number, nullptr, 0, 0, 0), SINEW_BAD_ARGUMENT);
  EXPECT_STREQ(sinew_last_error(), "not finite: finite numbers in every field");
  void* message = nullptr;
  EXPECT_EQ(sinew_loan(handle->get(), handle->topic("counter.range"), &message, nullptr, nullptr), SINEW_NOT_SUPPORTED);
}

// ---- one reader that the writer wakes itself

TEST(CClient, IsWokenByTheWriterItselfWhereTheRobotFileAllowsIt) {
  Robot robot({.graph = {.wake_outsiders = true}});
  robot.start();
  Handle handle;
  const std::uint32_t range = handle.topic("counter.range");
  ASSERT_EQ(sinew_wake_at_once(handle.get(), range, 1), SINEW_OK) << sinew_last_error();
  sinew_message m{};
  for (int i = 0; i < 50; ++i)
    ASSERT_EQ(sinew_next(handle.get(), range, 5'000'000'000, &m), SINEW_OK) << sinew_last_error();
  ASSERT_EQ(sinew_wake_at_once(handle.get(), range, 0), SINEW_OK);
  for (int i = 0; i < 5; ++i) ASSERT_EQ(sinew_next(handle.get(), range, 5'000'000'000, &m), SINEW_OK);
  EXPECT_EQ(sinew_wake_at_once(handle.get(), handle.topic("eye.image"), 1), SINEW_NOT_SUPPORTED);
}

TEST(CClient, NullIsRefusedAndNotRead) {
  EXPECT_EQ(sinew_attach("robot", nullptr), SINEW_BAD_ARGUMENT);
  EXPECT_STREQ(sinew_last_error(), "robot is NULL");
  sinew_message m{};
  EXPECT_EQ(sinew_wait(nullptr, 0, 0, &m), SINEW_BAD_ARGUMENT);
  EXPECT_EQ(sinew_still_valid(nullptr, &m), 0);
  sinew_detach(nullptr);
  sinew_robots_free(nullptr);
  EXPECT_EQ(sinew_topic_count(nullptr), 0U);
}

}  // namespace
}  // namespace sinew::tap::client_test
