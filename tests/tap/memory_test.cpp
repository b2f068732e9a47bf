// A robot whose memory runs out while it answers: it closes the asking client, and goes on.
#include "raw_client.hpp"
#include "refusing_new.hpp"
#include "tap_rig.hpp"

namespace sinew::tap::memory_test {
namespace {

OwnRunDir g_run_dir;

class Scarce : public testing::Test {
 protected:
  Scarce() { robot.start(); }
  ~Scarce() override { test::refuse_above(SIZE_MAX); }
  void expect_closed_and_robot_well(RawClient& client, std::string_view request) {
    EXPECT_TRUE(client.send_frame(request));
    EXPECT_FALSE(client.reply()) << "what was to be said needs memory, too";
    RawClient other(robot);
    ASSERT_TRUE(other.send_frame(R"({"request":"hello"})"));
    const auto reply = other.reply();
    ASSERT_TRUE(reply);
    EXPECT_EQ((*reply)["ok"], true) << *reply;
    EXPECT_EQ(robot.server->stats().out_of_memory.value(), 1U);
    EXPECT_EQ(robot.server->stats().garbage.value(), 0U);
  }
  static std::string hello(std::size_t bytes) {
    return R"({"request":"hello","id":")" + std::string(bytes, 'a') + "\"}";
  }
  Robot robot;
};

TEST_F(Scarce, ARequestThatFindsNoRoom) {
  RawClient client(robot);
  test::refuse_above(24 * 1024);  // two of the pieces in which a request grows
  expect_closed_and_robot_well(client, hello(60'000));
}

TEST_F(Scarce, ARequestThatCannotBeUnderstood) {
  RawClient client(robot);
  test::refuse_above(16 * 1024);
  expect_closed_and_robot_well(client, hello(16'100));
}

TEST_F(Scarce, AReplyThatCannotBeWritten) {
  RawClient client(robot);
  test::refuse_above(2048);
  expect_closed_and_robot_well(client, R"({"request":"status"})");
}

}  // namespace
}  // namespace sinew::tap::memory_test
