// The server of simulated buses, spoken to by our own client and by raw text.
#include "sim_hil/wire/socketcand_server.hpp"

#include <gmock/gmock.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <thread>

#include "hal/linux/devices/connectors.hpp"
#include "hal/linux/socket.hpp"
#include "hal/platform.hpp"
#include "wire/can_bytes.hpp"

namespace sinew::sim_hil::socketcand_server_test {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;
using ::testing::StartsWith;

hal::Os& os() { return hal::system_os(); }

template <class Holds>
bool until(Holds&& holds, hal::Duration patience = 10s) {
  for (const hal::Time end = os().now() + patience; os().now() < end; os().sleep_until(os().now() + 1ms))
    if (holds()) return true;
  return false;
}

msg::CanFrame frame_of(std::uint32_t id, std::initializer_list<std::uint8_t> data) {
  msg::CanFrame frame = wire::can_frame(id, 0, id > 0x7FF);
  for (const std::uint8_t byte : data) frame.data[frame.size++] = byte;
  return frame;
}

class Text {
 public:
  explicit Text(const std::string& endpoint) {
    auto stream = hal::connect_stream(endpoint, 5s);
    if (stream) stream_ = std::move(*stream);
  }
  bool say(std::string_view text) { return stream_->write(std::as_bytes(std::span(text))).has_value(); }
  /// Everything so far; `closed` when the server has hung up.
  const std::string& hear() {
    std::array<char, 4096> piece{};
    for (;;) {
      const auto n = stream_->read_now(std::as_writable_bytes(std::span(piece)));
      closed = closed || !n;
      if (!n || *n == 0) return heard_;
      heard_.append(piece.data(), *n);
    }
  }
  bool hears(const std::string& text) {
    return until([&] { return hear().find(text) != std::string::npos; });
  }
  bool greet(const std::string& bus) {
    return hears("< hi >") && say("< open " + bus + " >") && hears("< ok >") && say("< rawmode >") &&
           hears("< ok >< ok >");
  }
  bool closed = false;

 private:
  std::unique_ptr<hal::Stream> stream_;
  std::string heard_;
};

/// Asks for all frames of can0 and then reads nothing. Its sockets hold some kilobytes and not the megabytes that are
/// usual, which take a board's emulator a minute to fill.
class Deaf {
 public:
  explicit Deaf(const std::string& endpoint) {
    const int receive = 4096, segment = 536;  // what the sender may have under way follows from the latter
    sockaddr_in at{};
    at.sin_family = AF_INET;
    at.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    at.sin_port = htons(static_cast<std::uint16_t>(std::stoi(endpoint.substr(endpoint.rfind(':') + 1))));
    asked = ::setsockopt(fd_, SOL_SOCKET, SO_RCVBUF, &receive, sizeof receive) == 0 &&
            ::setsockopt(fd_, IPPROTO_TCP, TCP_MAXSEG, &segment, sizeof segment) == 0 &&
            ::connect(fd_, reinterpret_cast<const sockaddr*>(&at), sizeof at) == 0 && hears("< hi >") &&
            says("< open can0 >") && hears("< ok >") && says("< rawmode >") && hears("< ok >< ok >");
  }
  ~Deaf() { ::close(fd_); }
  Deaf(const Deaf&) = delete;
  Deaf& operator=(const Deaf&) = delete;
  bool asked = false;

 private:
  bool says(std::string_view text) {
    return ::send(fd_, text.data(), text.size(), MSG_NOSIGNAL) == static_cast<ssize_t>(text.size());
  }
  bool hears(const std::string& text) {
    return until([&] {
      std::array<char, 64> piece;
      const ssize_t n = ::recv(fd_, piece.data(), piece.size(), MSG_DONTWAIT);
      if (n > 0) heard_.append(piece.data(), static_cast<std::size_t>(n));
      return heard_.find(text) != std::string::npos;
    });
  }
  std::string heard_;
  int fd_ = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
};

class SocketcandServerTest : public testing::Test {
 protected:
  void SetUp() override {
    auto listener = hal::listen_stream("tcp:127.0.0.1:0");
    ASSERT_TRUE(listener);
    auto opened = SocketcandServer::open(os(), std::move(*listener), {"can0", "can1"});
    ASSERT_TRUE(opened);
    server = std::move(*opened);
    for (const char* name : {"can0", "can1"}) devices.push_back(std::move(*server->bus(name)));
  }
  std::unique_ptr<hal::CanBus> ours(const std::string& bus) {
    auto opened = connectors->can({"socketcand", server->endpoint().substr(4) + "/" + bus}, why);
    return opened ? std::move(*opened) : nullptr;
  }
  static bool gets(hal::CanBus& bus, msg::CanFrame& frame) {
    return until([&] {
      const auto got = bus.read(frame);
      return got && *got;
    });
  }
  std::string why;
  std::unique_ptr<hal::Connectors> connectors = std::move(*hal::LinuxConnectors::open(os(), why));
  std::unique_ptr<SocketcandServer> server;
  std::vector<std::unique_ptr<hal::CanBus>> devices;
};

TEST_F(SocketcandServerTest, FramesGoBothWaysAndToOtherClientsButNotBack) {
  const auto first = ours("can0"), second = ours("can0");
  ASSERT_TRUE(first && second) << why;
  ASSERT_TRUE(first->send(frame_of(0x601, {0x40, 0x18, 0x10, 1}), hal::kNever));
  msg::CanFrame got;
  ASSERT_TRUE(gets(*devices[0], got));
  EXPECT_EQ(got.id, 0x601u);
  EXPECT_EQ(got.size, 4u);
  ASSERT_TRUE(gets(*second, got));
  EXPECT_EQ(got.data[1], 0x18);
  ASSERT_TRUE(devices[0]->send(frame_of(0x12345678, {}), hal::kNever));
  ASSERT_TRUE(gets(*first, got));
  EXPECT_EQ(got.id, 0x12345678u) << "and what it had sent did not come back before";
  EXPECT_TRUE(got.extended());
  EXPECT_EQ(got.size, 0u);
}

TEST_F(SocketcandServerTest, WhoAsksAndNeverReadsCostsNoMoreThanItsQueue) {
  Text flood(server->endpoint());
  ASSERT_TRUE(flood.greet("can0"));
  std::string many;
  while (many.size() < 64 * 1024) many += "< echo >";
  const std::uint64_t each = many.size() / 8;
  std::uint64_t asked = 0;
  for (int i = 0; i < 2000 && server->stats().lost == 0; ++i, asked += each) ASSERT_TRUE(flood.say(many));
  EXPECT_GT(server->stats().lost, 0u) << "of " << asked;
  // The other clients are served, and this one gets the frames that had room, whole.
  const auto other = ours("can0");
  ASSERT_TRUE(other) << why;
  ASSERT_TRUE(devices[0]->send(frame_of(0x181, {7}), hal::kNever));
  msg::CanFrame got;
  EXPECT_TRUE(gets(*other, got));
  EXPECT_TRUE(until([&] {
    std::uint64_t answers = 0;
    const std::string& all = flood.hear();
    for (auto at = all.find("< echo >"); at != std::string::npos; at = all.find("< echo >", at + 8)) ++answers;
    return answers + server->stats().lost >= asked;
  }));
}

TEST_F(SocketcandServerTest, BusesAreApart) {
  const auto zero = ours("can0"), one = ours("can1");
  ASSERT_TRUE(zero && one) << why;
  ASSERT_TRUE(zero->send(frame_of(1, {1}), hal::kNever));
  msg::CanFrame got;
  ASSERT_TRUE(gets(*devices[0], got));
  ASSERT_TRUE(one->send(frame_of(2, {2}), hal::kNever));
  ASSERT_TRUE(gets(*devices[1], got));
  EXPECT_EQ(got.id, 2u);
  EXPECT_FALSE(*zero->read(got));
}

TEST_F(SocketcandServerTest, BusThatDoesNotExistIsRefused) {
  EXPECT_FALSE(ours("can7"));
  EXPECT_THAT(why, HasSubstr("could not open bus"));
  EXPECT_FALSE(server->bus("can7"));
}

TEST_F(SocketcandServerTest, WhoComesTooEarlyIsToldAndNothingIsSent) {
  Text text(server->endpoint());
  ASSERT_TRUE(text.hears("< hi >"));
  text.say("< send 123 1 55 >< rawmode >< echo >< open can0 >< send 123 1 55 >");
  ASSERT_TRUE(text.hears("< ok >")) << text.hear();
  ASSERT_TRUE(until([&] { return text.hear().ends_with("< error not in raw mode >"); }));
  EXPECT_EQ(text.hear(),
            "< hi >< error not in raw mode >< error no bus is open >< echo >< ok >< error not in raw mode >");
  msg::CanFrame got;
  EXPECT_FALSE(*devices[0]->read(got));
}

TEST_F(SocketcandServerTest, AnswerToTheFirstFrameWaitsUntilOkIsReadAlone) {
  Text text(server->endpoint());
  ASSERT_TRUE(text.greet("can0"));
  ASSERT_TRUE(devices[0]->send(frame_of(0x80, {}), hal::kNever));
  ASSERT_TRUE(text.hears(" < frame 080 ")) << "not lost, with a blank before it";
}

TEST_F(SocketcandServerTest, NonsenseIsCountedAndEndsTheConnectionButNoOther) {
  const auto good = ours("can0");
  ASSERT_TRUE(good) << why;
  Text bad(server->endpoint());
  ASSERT_TRUE(bad.greet("can0"));
  const std::string endless(10'000, 'x');
  bad.say("< " + endless + " >");
  for (int i = 0; i < 300; ++i) bad.say("< send 12345 9 1 2 3 >< frobnicate >< frame 1 1.0 11 >");
  EXPECT_TRUE(until([&] {
    bad.hear();
    return bad.closed;
  }));
  EXPECT_EQ(server->stats().hung_up, 1u);
  EXPECT_GT(server->stats().malformed, SocketcandServer::kMostNonsense);
  msg::CanFrame got;
  ASSERT_TRUE(good->send(frame_of(3, {3}), hal::kNever));
  ASSERT_TRUE(gets(*devices[0], got));
  EXPECT_EQ(got.id, 3u) << "and none of the nonsense before it";
}

TEST_F(SocketcandServerTest, ClientThatReadsNothingLosesFramesAndHoldsUpNobody) {
  const auto good = ours("can0");
  ASSERT_TRUE(good) << why;
  const Deaf lazy(server->endpoint());
  ASSERT_TRUE(lazy.asked);
  msg::CanFrame got;
  std::uint64_t received = 0;
  const auto overflows = [&] {
    for (int i = 0; i < 500; ++i)
      static_cast<void>(devices[0]->send(frame_of(0x181, {1, 2, 3, 4, 5, 6, 7, 8}), hal::kNever));
    for (auto n = good->read(got); n && *n; n = good->read(got)) ++received;
    return server->stats().lost > 0 && received > 1000;
  };
  EXPECT_TRUE(until(overflows, 90s)) << "megabytes of the kernel's buffers are filled first, in an emulator as well";
}

TEST_F(SocketcandServerTest, BusThatIsNeverSilentStarvesNobody) {
  const auto good = ours("can0");
  ASSERT_TRUE(good) << why;
  std::atomic<bool> stop{false};
  std::thread talker([&] {
    while (!stop) static_cast<void>(devices[0]->send(frame_of(0x181, {1, 2, 3, 4, 5, 6, 7, 8}), hal::kNever));
  });
  msg::CanFrame got;
  EXPECT_TRUE(gets(*good, got));
  Text other(server->endpoint());
  EXPECT_TRUE(other.hears("< hi >"));
  stop = true;
  talker.join();
}

TEST_F(SocketcandServerTest, MoreClientsThanItTakesAreTurnedAway) {
  std::vector<std::unique_ptr<Text>> all;
  for (std::size_t i = 0; i <= SocketcandServer::kMostClients; ++i)
    all.push_back(std::make_unique<Text>(server->endpoint()));
  EXPECT_TRUE(until([&] { return server->stats().refused == 1; }));
  EXPECT_TRUE(until([&] {
    all.back()->hear();
    return all.back()->closed;
  }));
  EXPECT_TRUE(all.front()->hears("< hi >"));
}

}  // namespace
}  // namespace sinew::sim_hil::socketcand_server_test
