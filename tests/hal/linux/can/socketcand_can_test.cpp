#include "hal/linux/can/socketcand_can.hpp"

#include <gtest/gtest.h>

#include "hal/can_waiting.hpp"
#include "hal/linux/can/can.hpp"
#include "qemu_user.hpp"
#include "socketcand_server.hpp"
#include "wire/random_can_frame.hpp"

namespace sinew::hal::socketcand_can_test {
namespace {

using wire::frame_of;
using wire::same_frame;

CanSpec spec(const std::string& address) {
  CanSpec out;
  out.transport = "socketcand", out.address = address, out.data_bit_rate = 8'000'000;
  return out;
}

class Socketcand : public ::testing::Test {
 protected:
  std::unique_ptr<CanBus> open(const CanSpec& s) {
    auto bus = open_can(s, system_os(), watch_, why_);
    if (bus) return std::move(*bus);
    code_ = bus.error().code;
    return nullptr;
  }
  std::shared_ptr<FdWatch> watch_ = start_watch();
  std::string why_;
  Errc code_ = Errc::io;
};

TEST_F(Socketcand, FramesGoBothWays) {
  SocketcandServer server;
  auto bus = open(spec(server.address()));
  ASSERT_TRUE(bus) << why_;
  std::mt19937 random(6);
  std::vector<msg::CanFrame> frames;
  for (int i = 0; i < 200; ++i) frames.push_back(wire::random_can_frame(random, true, true));
  for (const auto& frame : frames) {
    ASSERT_TRUE(eventually([&] { return bus->send(frame, kNever).has_value(); }));
    server.tell(frame);
    msg::CanFrame out;
    const Time before = system_os().now();
    ASSERT_TRUE(next_frame(*bus, out));
    ASSERT_TRUE(same_frame(out, frame));
    EXPECT_GE(out.stamp, before - Duration(kPatience));
    EXPECT_LE(out.stamp, system_os().now());
  }
  ASSERT_TRUE(eventually([&] { return server.sent().size() == frames.size(); }));
  const auto sent = server.sent();
  for (std::size_t i = 0; i < frames.size(); ++i) ASSERT_TRUE(same_frame(sent[i], frames[i])) << i;
  EXPECT_EQ(bus->stats().received, 200u);
  EXPECT_EQ(bus->stats().sent, 200u);
  EXPECT_EQ(bus->stats().malformed, 0u);
}

TEST_F(Socketcand, WhoWaitsIsWoken) {
  SocketcandServer server;
  auto bus = open(spec(server.address()));
  ASSERT_TRUE(bus) << why_;
  ASSERT_TRUE(eventually([&] { return server.connected(); }));  // a frame before reaches nobody
  Bell bell;
  bus->set_wake(&bell);
  const Time deadline = system_os().now() + kPatience;
  msg::CanFrame out;
  for (bool told = false;;) {  // the server's answers may wake it, too
    const auto seen = bell.times();
    const auto got = bus->read(out);
    ASSERT_TRUE(got);
    if (*got) break;
    if (!told) server.tell(frame_of(1, {}));
    told = true;
    bell.wait_beyond(seen, deadline);
    ASSERT_LT(system_os().now(), deadline) << "not woken";
  }
  EXPECT_EQ(out.id, 1u);
  bus->set_wake(nullptr);
}

TEST_F(Socketcand, ServerThatIsLostIsFoundAgain) {
  SocketcandServer server;
  auto bus = open(spec(server.address()));
  ASSERT_TRUE(bus) << why_;
  msg::CanFrame out;
  ASSERT_TRUE(eventually([&] { return server.connected(); }));
  for (int round = 1; round <= 3; ++round) {
    server.say("< frame 123 1.0 11");  // cut in the middle of an element
    server.hang_up();
    ASSERT_TRUE(eventually([&] {
      const auto read = bus->read(out);
      return !read && read.error().code == Errc::closed;
    }));
    // Stopped, unless the thread that looks for the server was faster than this one, as on one processor it may be.
    EXPECT_TRUE(bus->stats().state == CanState::stopped || server.connections() == round + 1);
    ASSERT_TRUE(eventually([&] { return server.connections() == round + 1 && server.connected(); }));
    server.tell(frame_of(0x7F0, {static_cast<std::uint8_t>(round)}));
    ASSERT_TRUE(next_frame(*bus, out));
    EXPECT_TRUE(same_frame(out, frame_of(0x7F0, {static_cast<std::uint8_t>(round)})));
    EXPECT_EQ(bus->stats().state, CanState::active);
    const msg::CanFrame answer = frame_of(0x100 + static_cast<std::uint32_t>(round), {});
    ASSERT_TRUE(eventually([&] { return bus->send(answer, kNever).has_value(); }));
    ASSERT_TRUE(eventually([&] { return !server.sent().empty() && server.sent().back().id == answer.id; }));
  }
}

TEST_F(Socketcand, WhileTheServerIsAwaySendingIsClosedAndCounted) {
  auto server = std::make_unique<SocketcandServer>();
  const std::string endpoint = server->endpoint();
  auto bus = open(spec(server->address()));
  ASSERT_TRUE(bus) << why_;
  server.reset();
  msg::CanFrame out;
  ASSERT_TRUE(eventually([&] { return !bus->read(out); }));
  const Status sent = bus->send(frame_of(1, {}), kNever);
  ASSERT_FALSE(sent);
  EXPECT_EQ(sent.error().code, Errc::closed);
  EXPECT_EQ(bus->stats().tx_lost, 1u);
  auto& socketcand = static_cast<SocketcandCan&>(*bus);
  if (!test::qemu_user()) {  // on MIPS, errors read with SO_ERROR keep this machine's numbers there
    EXPECT_TRUE(eventually([&] { return socketcand.trouble().find("refused") != std::string::npos; }));
  }
  SocketcandServer again(endpoint);
  ASSERT_TRUE(eventually([&] { return bus->send(frame_of(2, {}), kNever).has_value(); }));
  EXPECT_TRUE(eventually([&] { return again.sent().size() == 1; }));
  EXPECT_TRUE(eventually([&] { return socketcand.trouble().empty(); }));
}

TEST_F(Socketcand, FullConnectionIsATimeOutAndElementsStayWhole) {
  SocketcandServer server;
  auto bus = open(spec(server.address()));
  ASSERT_TRUE(bus) << why_;
  std::uint64_t sent = 0, refused = 0;
  for (std::uint32_t i = 0; i < 200000 && refused < 100; ++i) {
    const Status s = bus->send(frame_of(i & 0x7FF, {1, 2, 3, 4, 5, 6, 7, 8}), kNever);
    s ? ++sent : ++refused;
    if (!s) {
      EXPECT_EQ(s.error().code, Errc::timeout);
    }
  }
  EXPECT_GT(refused, 0u) << "the server reads more slowly than we write";
  ASSERT_TRUE(eventually([&] { return bus->send(frame_of(0x7FF, {}), kNever).has_value(); }));
  ASSERT_TRUE(eventually([&] { return server.sent().size() == sent + 1; }));
  EXPECT_EQ(bus->stats().sent, sent + 1);
  EXPECT_GE(bus->stats().tx_lost, refused);
}

TEST_F(Socketcand, GarbageOnlyCounts) {
  SocketcandServer server;
  auto bus = open(spec(server.address()));
  ASSERT_TRUE(bus) << why_;
  ASSERT_TRUE(eventually([&] { return server.connected(); }));
  ASSERT_TRUE(server.say("noise < what 1 2 3 >< frame 9999 >< frame 12< rtr 123 1.0 9 >\xff<" + std::string(300, 'x')));
  server.tell(frame_of(0x44, {5}));
  msg::CanFrame out;
  ASSERT_TRUE(next_frame(*bus, out));
  EXPECT_EQ(out.id, 0x44u);
  ASSERT_TRUE(bus->read(out));
  EXPECT_EQ(bus->stats().malformed, 5u) << "three that say nothing, one without an end, one too long";
  EXPECT_EQ(bus->stats().received, 1u);
}

TEST_F(Socketcand, ErrorFramesChangeTheState) {
  SocketcandServer server;
  auto bus = open(spec(server.address()));
  ASSERT_TRUE(bus) << why_;
  ASSERT_TRUE(server.say("< error 040 12.500000 >"));
  msg::CanFrame out;
  ASSERT_TRUE(next_frame(*bus, out));
  EXPECT_TRUE(out.error());
  EXPECT_EQ(bus->stats().state, CanState::bus_off);
  EXPECT_EQ(bus->stats().bus_offs, 1u);
  ASSERT_TRUE(server.say("< error 100 12.600000 >"));
  ASSERT_TRUE(next_frame(*bus, out));
  EXPECT_EQ(bus->stats().state, CanState::active);
  EXPECT_EQ(bus->stats().restarts, 1u);
}

TEST_F(Socketcand, WhatKeepsItFromOpeningIsSaid) {
  EXPECT_FALSE(open(spec("localhost/can0")));
  EXPECT_EQ(code_, Errc::bad_argument);
  EXPECT_EQ(why_, "'localhost/can0' is no bus of a socketcand server: HOST:PORT/BUS, as in localhost:29536/can0");

  SocketcandServer server;
  CanSpec other = spec(server.endpoint().substr(4) + "/can7");
  EXPECT_FALSE(open(other));
  EXPECT_EQ(code_, Errc::denied);
  EXPECT_EQ(why_, other.address + ": the server says: could not open bus");

  SINEW_SKIP_UNDER_QEMU_USER("on MIPS, errors read with SO_ERROR keep this machine's numbers");

  auto listener = listen_stream("tcp:127.0.0.1:0");
  ASSERT_TRUE(listener);
  const std::string address = (*listener)->endpoint().substr(4) + "/can0";
  listener->reset();
  EXPECT_FALSE(open(spec(address)));
  EXPECT_EQ(code_, Errc::closed);
  EXPECT_EQ(why_, address + ": Connection refused (does a socketcand run there?)");
}

TEST_F(Socketcand, WhoeverListensAndSaysSomethingElseIsNotWaitedForLong) {
  auto listener = listen_stream("tcp:127.0.0.1:0");
  ASSERT_TRUE(listener);
  EXPECT_FALSE(open(spec((*listener)->endpoint().substr(4) + "/can0")));
  EXPECT_EQ(code_, Errc::timeout);
  EXPECT_NE(why_.find("the server there does not say '< hi >'"), std::string::npos) << why_;
}

}  // namespace
}  // namespace sinew::hal::socketcand_can_test
