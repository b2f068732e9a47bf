#include "hal/linux/can/udp_can.hpp"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>

#include "hal/can_waiting.hpp"
#include "hal/linux/can/can.hpp"
#include "qemu_user.hpp"
#include "wire/dronecan_udp.hpp"
#include "wire/random_can_frame.hpp"

namespace sinew::hal::udp_can_test {
namespace {

using wire::frame_of;
using wire::same_frame;

/// Tests run beside each other: each process has a bus of its own, as far as 255 go.
std::string own_bus() { return std::to_string(getpid() % 255 + 1); }

CanSpec spec(std::uint32_t data_bit_rate = 0) {
  CanSpec out;
  out.transport = "udp", out.address = own_bus(), out.data_bit_rate = data_bit_rate;
  return out;
}

std::unique_ptr<CanBus> opened(const CanSpec& s, const std::shared_ptr<FdWatch>& watch) {
  std::string why;
  auto bus = open_can(s, system_os(), watch, why);
  EXPECT_TRUE(bus) << why;
  return bus ? std::move(*bus) : nullptr;
}

/// Sends any bytes to the bus, as a foreign program.
class Foreign {
 public:
  Foreign() {
    ip_mreqn loopback{};
    loopback.imr_address.s_addr = htonl(INADDR_LOOPBACK);
    EXPECT_EQ(setsockopt(fd_, IPPROTO_IP, IP_MULTICAST_IF, &loopback, sizeof loopback), 0);
    to_.sin_family = AF_INET, to_.sin_port = htons(wire::kDronecanUdpPort);
    to_.sin_addr.s_addr = htonl(wire::kDronecanUdpGroup | static_cast<unsigned>(std::stoi(own_bus())));
  }
  ~Foreign() { close(fd_); }
  void put(std::span<const std::uint8_t> bytes) {
    EXPECT_EQ(sendto(fd_, bytes.data(), bytes.size(), 0, reinterpret_cast<sockaddr*>(&to_), sizeof to_),
              static_cast<ssize_t>(bytes.size()));
  }
  void put(const msg::CanFrame& frame) {
    std::array<std::uint8_t, wire::kDronecanUdpMax> packet{};
    put(std::span(packet).first(wire::dronecan_udp_encode(frame, packet)));
  }

 private:
  int fd_ = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  sockaddr_in to_{};
};

class UdpCan : public ::testing::Test {
 protected:
  void SetUp() override { SINEW_SKIP_UNDER_QEMU_USER("IP_MULTICAST_IF"); }
  std::shared_ptr<FdWatch> watch_ = start_watch();
};

TEST_F(UdpCan, FramesReachTheOthersOfTheBusAndNotTheirSender) {
  auto a = opened(spec(), watch_), b = opened(spec(), watch_), c = opened(spec(), watch_);
  const msg::CanFrame frame = frame_of(0x0804062A, {0, 3, 0xFD}, msg::kCanExtended);
  const Time before = system_os().now();
  ASSERT_TRUE(a->send(frame, kNever));
  msg::CanFrame out;
  ASSERT_TRUE(next_frame(*b, out));
  EXPECT_TRUE(same_frame(out, frame));
  EXPECT_GE(out.stamp.ns, before.ns - 10'000'000);
  EXPECT_LE(out.stamp, system_os().now()) << "on the runtime's clock";
  ASSERT_TRUE(next_frame(*c, out));
  ASSERT_TRUE(b->send(frame_of(0x123, {1}), kNever));
  ASSERT_TRUE(next_frame(*a, out));
  EXPECT_EQ(out.id, 0x123u) << "its own frame, which was first, did not come back";
  EXPECT_EQ(a->stats().sent, 1u);
  EXPECT_EQ(a->stats().received, 1u);
  EXPECT_EQ(b->stats().received_bits, can_frame_bits(frame));
}

TEST_F(UdpCan, OwnFramesComeBackWhereTheyAreWanted) {
  CanSpec own = spec();
  own.receive_own = true;
  auto bus = opened(own, watch_);
  ASSERT_TRUE(bus->send(frame_of(0x7FF, {9}), kNever));
  msg::CanFrame out;
  ASSERT_TRUE(next_frame(*bus, out));
  EXPECT_EQ(out.id, 0x7FFu);
}

TEST_F(UdpCan, AnotherBusOfTheSameMachineHearsNothing) {
  auto bus = opened(spec(), watch_);
  CanSpec other = spec();
  other.address = "239.65.82.0:lo";  // own_bus() is never 0
  auto quiet = opened(other, watch_);
  auto peer = opened(spec(), watch_);
  ASSERT_TRUE(bus->send(frame_of(1, {}), kNever));
  msg::CanFrame out;
  ASSERT_TRUE(next_frame(*peer, out));
  const auto read = quiet->read(out);
  ASSERT_TRUE(read);
  EXPECT_FALSE(*read);
}

TEST_F(UdpCan, WhoWaitsIsWokenWhenAFrameCame) {
  auto a = opened(spec(), watch_), b = opened(spec(), watch_);
  WakeCounter wakes;
  b->set_wake(&wakes);
  msg::CanFrame out;
  ASSERT_TRUE(b->read(out));
  const auto seen = wakes.count();
  ASSERT_TRUE(a->send(frame_of(5, {}), kNever));
  EXPECT_TRUE(eventually([&] { return wakes.count() > seen; }));
  b->set_wake(nullptr);
}

TEST_F(UdpCan, BurstsArriveWholeAndInOrder) {
  auto a = opened(spec(64), watch_), b = opened(spec(64), watch_);
  std::mt19937 random(4);
  for (int round = 0; round < 20; ++round) {
    std::vector<msg::CanFrame> sent;
    for (int i = 0; i < 50; ++i) {
      sent.push_back(wire::random_can_frame(random, false, true));
      ASSERT_TRUE(a->send(sent.back(), kNever));
    }
    for (const msg::CanFrame& frame : sent) {
      msg::CanFrame out;
      ASSERT_TRUE(next_frame(*b, out));
      ASSERT_TRUE(same_frame(out, frame));
    }
  }
  EXPECT_EQ(b->stats().received, 1000u);
  EXPECT_EQ(b->stats().rx_lost, 0u);
}

TEST_F(UdpCan, WhatTheSocketHadNoRoomForIsCounted) {
  auto bus = opened(spec(), watch_);
  Foreign foreign;
  constexpr std::uint64_t kSent = 20000;  // far more than a megabyte of socket buffer holds
  for (std::uint64_t i = 0; i < kSent; ++i) foreign.put(frame_of(0x100, {1, 2, 3, 4, 5, 6, 7, 8}));
  msg::CanFrame out;
  for (auto read = bus->read(out); read && *read;) read = bus->read(out);
  EXPECT_LT(bus->stats().received, kSent);
  foreign.put(frame_of(0x101, {}));  // the kernel tells its count with the next packet that fits
  ASSERT_TRUE(next_frame(*bus, out));
  EXPECT_EQ(out.id, 0x101u);
  EXPECT_EQ(bus->stats().received + bus->stats().rx_lost, kSent + 1);
}

TEST_F(UdpCan, GarbageOnlyCounts) {
  auto bus = opened(spec(), watch_);
  Foreign foreign;
  std::mt19937 random(5);
  for (int i = 0; i < 500; ++i) {
    std::vector<std::uint8_t> bytes(random() % 100);
    for (auto& b : bytes) b = static_cast<std::uint8_t>(random());
    foreign.put(bytes);
  }
  foreign.put(frame_of(0x10, {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12}, msg::kCanFd));  // FD on a classic bus
  foreign.put(frame_of(0x11, {7}));
  msg::CanFrame out;
  ASSERT_TRUE(next_frame(*bus, out));
  EXPECT_EQ(out.id, 0x11u);
  EXPECT_EQ(bus->stats().malformed, 501u);
  EXPECT_EQ(bus->stats().received, 1u);
}

TEST_F(UdpCan, FiltersLetThroughWhatTheyName) {
  auto bus = opened(spec(), watch_);
  const CanFilter filters[] = {{0x180, 0x780, false}, {0x0803F200, 0x00FFFF00, true}};
  ASSERT_TRUE(bus->set_filters(filters));
  Foreign foreign;
  for (const std::uint32_t id : {0x1FFu, 0x200u, 0x181u}) foreign.put(frame_of(id, {}));
  for (const std::uint32_t id : {0x0803F22Au, 0x0804062Au, 0x181u}) foreign.put(frame_of(id, {}, msg::kCanExtended));
  ASSERT_TRUE(bus->set_filters(filters));
  foreign.put(frame_of(0x187, {}));
  std::vector<std::uint32_t> ids;
  msg::CanFrame out;
  do {
    ASSERT_TRUE(next_frame(*bus, out));
    ids.push_back(out.id);
  } while (out.id != 0x187);
  EXPECT_EQ(ids, (std::vector<std::uint32_t>{0x1FF, 0x181, 0x0803F22A, 0x187}));
}

TEST_F(UdpCan, FramesThatComeTooLateOrCannotBeAreNotSent) {
  auto a = opened(spec(), watch_), b = opened(spec(), watch_);
  const Status late = a->send(frame_of(1, {}), system_os().now());
  ASSERT_FALSE(late);
  EXPECT_EQ(late.error().code, Errc::timeout);
  EXPECT_EQ(a->stats().tx_lost, 1u);
  for (const auto& bad : {frame_of(0x800, {}), frame_of(1, {}, msg::kCanError), frame_of(1, {}, msg::kCanRemote),
                          frame_of(1, {}, msg::kCanFd)}) {
    const Status refused = a->send(bad, kNever);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, Errc::bad_argument);
  }
  ASSERT_TRUE(a->send(frame_of(2, {}), system_os().now() + kPatience));
  msg::CanFrame out;
  ASSERT_TRUE(next_frame(*b, out));
  EXPECT_EQ(out.id, 2u) << "and nothing before it";
}

TEST_F(UdpCan, WrongAddressesSayWhatIsAllowed) {
  for (const auto& [address, text] :
       {std::pair{"256", "'256' is no bus: a number 0..255 or 239.65.82.NUMBER, and :INTERFACE if it is not to be lo"},
        std::pair{"239.65.83.1",
                  "'239.65.83.1' is no bus: a number 0..255 or 239.65.82.NUMBER, and :INTERFACE if it is not to be lo"},
        std::pair{"1:nowhere0", "there is no interface 'nowhere0' ('ip link' lists them)"}}) {
    CanSpec wrong = spec();
    wrong.address = address;
    std::string why;
    EXPECT_FALSE(open_can(wrong, system_os(), watch_, why));
    EXPECT_EQ(why, text);
  }
}

TEST_F(UdpCan, AnUnknownTransportIsNamed) {
  CanSpec wrong = spec();
  wrong.transport = "slcan";
  std::string why;
  const auto bus = open_can(wrong, system_os(), watch_, why);
  ASSERT_FALSE(bus);
  EXPECT_EQ(bus.error().code, Errc::bad_argument);
  EXPECT_EQ(why, "'slcan' is no transport of CAN frames: socketcan, udp or socketcand");
}

}  // namespace
}  // namespace sinew::hal::udp_can_test
