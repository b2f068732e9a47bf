// One connection of the server, on a clock of the test's.
#include "tap/connection.hpp"

#include <gtest/gtest.h>

#include "tap/frames.hpp"

#include <chrono>

#include "hal/linux/socket.hpp"

namespace sinew::tap::connection_test {
namespace {

using namespace std::chrono_literals;
using End = Connection::End;

constexpr hal::Time kBegin{1'000'000'000};

class OneConnection : public testing::Test {
 protected:
  OneConnection() {
    auto ends = hal::stream_pair();
    client_ = std::move(ends->second);
    client_->set_patience(20s);
    connection = std::make_unique<Connection>(1, std::move(ends->first), 1, Allowance{200, 1s}, kBegin);
  }
  /// Reads so many bytes as the client.
  void take(std::size_t bytes) {
    std::vector<std::byte> piece(bytes);
    for (std::size_t have = 0; have < bytes;) {
      const auto n = client_->read(std::span(piece).subspan(have));
      ASSERT_TRUE(n);
      have += *n;
    }
  }
  Json take_frame() {
    FrameReader frames(kMaxReplyBytes);
    while (!frames.frame()) {
      const auto n = client_->read(frames.room());
      if (!n) return {};
      frames.filled(*n);
      if (connection->held() > 0) connection->write();
    }
    return Json::parse(*frames.frame());
  }
  static Reply reply_of(std::size_t bytes) {
    Json json = {{"ok", true}, {"id", 7}, {"text", std::string(bytes, 'x')}};
    return {std::move(json)};
  }
  std::unique_ptr<Connection> connection;

 private:
  std::unique_ptr<hal::Stream> client_;
};

TEST_F(OneConnection, AReplyTakenInSmallPiecesHasNoMoreTimeThanAnyOther) {
  EXPECT_TRUE(connection->reply(reply_of(4 << 20), kMaxReplyBytes, kBegin));
  for (hal::Time now = kBegin; now <= kBegin + 1s; now = now + 100ms) {
    take(64 * 1024);
    const std::size_t before = connection->held();
    connection->write();
    ASSERT_EQ(connection->held(), before) << "not through";
    connection->look_at_time(now);
    ASSERT_EQ(connection->end(), End::open);
  }
  connection->look_at_time(kBegin + 1001ms);
  EXPECT_EQ(connection->end(), End::slow);
}

TEST_F(OneConnection, AReplyThatIsTakenHoldsNothing) {
  EXPECT_TRUE(connection->reply(reply_of(4 << 20), kMaxReplyBytes, kBegin));
  EXPECT_GT(connection->held(), std::size_t{4 << 20});
  EXPECT_EQ(take_frame()["ok"], true);
  EXPECT_EQ(connection->held(), 0U);
  connection->look_at_time(kBegin + 1h);
  EXPECT_EQ(connection->end(), End::open);
}

TEST_F(OneConnection, ALongReplyWithoutRoomIsBusyAndAShortOneGoes) {
  EXPECT_FALSE(connection->reply(reply_of(kShortReplyBytes), kShortReplyBytes, kBegin));
  const Json busy = take_frame();
  EXPECT_EQ(busy["error"]["code"], code_name(hal::Errc::busy));
  EXPECT_EQ(busy["id"], 7);
  EXPECT_TRUE(connection->reply(reply_of(kShortReplyBytes / 2), 0, kBegin));
  EXPECT_EQ(take_frame()["ok"], true);
}

TEST_F(OneConnection, AReplyThatIsTooLongForAnybodySaysSo) {
  EXPECT_TRUE(connection->reply(reply_of(kMaxReplyBytes), kMaxReplyBytes, kBegin));
  const Json refusal = take_frame();
  EXPECT_EQ(refusal["error"]["code"], code_name(hal::Errc::not_supported));
  EXPECT_EQ(refusal["id"], 7);
}

}  // namespace
}  // namespace sinew::tap::connection_test
