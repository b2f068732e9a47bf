// SocketCanBus on a real kernel: SINEW_CAN names one virtual interface or more ("vcan0,vcan1") that are up. The VM
// bench sets it, as root; elsewhere these tests are skipped.
#include "hal/linux/can/socket_can.hpp"

#include <gtest/gtest.h>
#include <linux/can/error.h>

#include <cstdlib>

#include "can_interface.hpp"
#include "hal/can_waiting.hpp"
#include "hal/linux/can/can.hpp"
#include "wire/random_can_frame.hpp"

namespace sinew::hal::socket_can_test {
namespace {

using wire::frame_of;
using wire::same_frame;

bool kernel_has_can() {
  const int fd = socket(PF_CAN, SOCK_RAW | SOCK_CLOEXEC, 1);
  if (fd >= 0) close(fd);
  return fd >= 0;
}

CanSpec spec(const std::string& interface, std::uint32_t data_bit_rate = 0) {
  CanSpec out;
  out.transport = "socketcan", out.address = interface, out.data_bit_rate = data_bit_rate;
  return out;
}

class SocketCan : public ::testing::Test {
 protected:
  void SetUp() override {
    const char* names = std::getenv("SINEW_CAN");
    if (names == nullptr || *names == '\0') GTEST_SKIP() << "SINEW_CAN names no interface: the VM bench runs this";
    const std::string all = names;
    interface_ = all.substr(0, all.find(','));
    ASSERT_TRUE(kernel_has_can()) << "SINEW_CAN is set, and the kernel has no CAN";
  }
  std::unique_ptr<SocketCanBus> open(const CanSpec& s) {
    auto bus = open_can(s, system_os(), watch_, why_);
    if (bus) return std::unique_ptr<SocketCanBus>(static_cast<SocketCanBus*>(bus->release()));
    code_ = bus.error().code;
    return nullptr;
  }
  std::unique_ptr<SocketCanBus> open() { return open(spec(interface_)); }

  std::string interface_, why_;
  Errc code_ = Errc::io;
  std::shared_ptr<FdWatch> watch_ = start_watch();
};

TEST_F(SocketCan, EveryKindOfFrameReachesTheOthersAndNotItsSender) {
  auto a = open(), b = open();
  ASSERT_TRUE(a && b) << why_;
  std::mt19937 random(8);
  for (int i = 0; i < 500; ++i) {
    const msg::CanFrame frame = wire::random_can_frame(random, true, false);
    const Time before = system_os().now();
    ASSERT_TRUE(a->send(frame, kNever));
    msg::CanFrame out;
    ASSERT_TRUE(next_frame(*b, out));
    ASSERT_TRUE(same_frame(out, frame)) << i;
    if (i >= 20) {  // the clocks have been read undisturbed by then
      EXPECT_GE(out.stamp.ns, before.ns - 100'000) << i;
    }
    EXPECT_LE(out.stamp, system_os().now());
  }
  ASSERT_TRUE(b->send(frame_of(0x77, {}), kNever));
  msg::CanFrame out;
  ASSERT_TRUE(next_frame(*a, out));
  EXPECT_EQ(out.id, 0x77u) << "none of its own came back";
  EXPECT_EQ(b->stats().received, 500u);
  EXPECT_EQ(a->stats().sent_bits, b->stats().received_bits);
  EXPECT_EQ(b->stats().state, CanState::active);
}

TEST_F(SocketCan, OwnFramesComeBackWhereTheyAreWanted) {
  CanSpec own = spec(interface_);
  own.receive_own = true;
  auto bus = open(own);
  ASSERT_TRUE(bus) << why_;
  ASSERT_TRUE(bus->send(frame_of(0x7FF, {9}), kNever));
  msg::CanFrame out;
  ASSERT_TRUE(next_frame(*bus, out));
  EXPECT_EQ(out.id, 0x7FFu);
}

TEST_F(SocketCan, FdFramesGoWhereTheInterfaceCarriesThem) {
  VirtualCan interface("sinewfd0");
  ASSERT_EQ(interface.error(), 0);
  ASSERT_TRUE(interface.mtu(CANFD_MTU) && interface.up(true));
  auto a = open(spec(interface.name(), 5'000'000)), b = open(spec(interface.name(), 5'000'000));
  auto classic = open(spec(interface.name()));
  ASSERT_TRUE(a && b && classic) << why_;
  std::mt19937 random(9);
  std::uint64_t fd_frames = 0;
  for (int i = 0; i < 300; ++i) {
    msg::CanFrame frame = wire::random_can_frame(random, true, true), out;
    if (frame.fd() && i % 2 == 0) frame.flags |= msg::kCanBitRateSwitch;
    fd_frames += frame.fd() ? 1 : 0;
    ASSERT_TRUE(a->send(frame, kNever));
    ASSERT_TRUE(next_frame(*b, out));
    ASSERT_TRUE(same_frame(out, frame)) << i;
  }
  EXPECT_GT(fd_frames, 0u);
  const Status refused = classic->send(frame_of(1, {}, msg::kCanFd), kNever);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, Errc::bad_argument);
  ASSERT_TRUE(a->send(frame_of(0x1ABCDEF0, {}, msg::kCanExtended), kNever));
  msg::CanFrame out;
  do ASSERT_TRUE(next_frame(*classic, out));
  while (out.id != 0x1ABCDEF0);
  EXPECT_EQ(classic->stats().received, 301 - fd_frames) << "classic frames only";
}

TEST_F(SocketCan, InterfaceWithoutFdIsNamed) {
  VirtualCan interface("sinewcl0");
  ASSERT_EQ(interface.error(), 0);
  ASSERT_TRUE(interface.mtu(CAN_MTU) && interface.up(true));
  EXPECT_FALSE(open(spec(interface.name(), 5'000'000)));
  EXPECT_EQ(code_, Errc::not_supported);
  EXPECT_EQ(why_, "sinewcl0: CAN FD is asked for, and the interface does not carry it: 'ip link set sinewcl0 mtu 72'");
}

TEST_F(SocketCan, FiltersAreTheKernels) {
  auto bus = open();
  ASSERT_TRUE(bus) << why_;
  const CanFilter filters[] = {{0x180, 0x780, false}, {0x0803F200, 0x00FFFF00, true}};
  ASSERT_TRUE(bus->set_filters(filters));
  RawCan other(interface_);
  ASSERT_TRUE(other.good());
  for (const std::uint32_t id :
       {0x1FFu, 0x200u, 0x0803F22Au | CAN_EFF_FLAG, 0x0804062Au | CAN_EFF_FLAG, 0x181u | CAN_EFF_FLAG})
    ASSERT_TRUE(other.put(id, {}));
  ASSERT_TRUE(other.put(0x187, {}));
  std::vector<std::uint32_t> ids;
  msg::CanFrame out;
  do {
    ASSERT_TRUE(next_frame(*bus, out));
    ids.push_back(out.id);
  } while (out.id != 0x187);
  EXPECT_EQ(ids, (std::vector<std::uint32_t>{0x1FF, 0x0803F22A, 0x187}));
  ASSERT_TRUE(bus->set_filters({}));
  ASSERT_TRUE(other.put(0x7F0, {}));
  ASSERT_TRUE(next_frame(*bus, out));
  EXPECT_EQ(out.id, 0x7F0u);
}

TEST_F(SocketCan, FullSocketBufferIsCounted) {
  auto bus = open();
  ASSERT_TRUE(bus) << why_;
  RawCan other(interface_);
  ASSERT_TRUE(other.good());
  constexpr std::uint64_t kSent = 20000;
  for (std::uint64_t i = 0; i < kSent; ++i) ASSERT_TRUE(other.put(0x100, {1, 2, 3, 4, 5, 6, 7, 8}));
  msg::CanFrame out;
  for (auto read = bus->read(out); read && *read;) read = bus->read(out);
  EXPECT_LT(bus->stats().received, kSent);
  ASSERT_TRUE(other.put(0x101, {}));  // the kernel tells its count with the next frame that fits
  ASSERT_TRUE(next_frame(*bus, out));
  EXPECT_EQ(out.id, 0x101u);
  EXPECT_EQ(bus->stats().received + bus->stats().rx_lost, kSent + 1);
}

TEST_F(SocketCan, InjectedErrorFramesMoveTheState) {
  auto bus = open();
  ASSERT_TRUE(bus) << why_;
  ASSERT_TRUE(bus->set_filters(std::vector<CanFilter>{{0x7FF, 0x7FF, false}})) << "error frames come all the same";
  RawCan other(interface_);
  ASSERT_TRUE(other.good());
  ASSERT_TRUE(other.put(CAN_ERR_FLAG | CAN_ERR_CRTL, {0, CAN_ERR_CRTL_RX_PASSIVE, 0, 0, 0, 0, 0, 0}));
  msg::CanFrame out;
  ASSERT_TRUE(next_frame(*bus, out));
  EXPECT_TRUE(out.error());
  EXPECT_EQ(bus->stats().state, CanState::passive);
  ASSERT_TRUE(other.put(CAN_ERR_FLAG | CAN_ERR_BUSOFF, {0, 0, 0, 0, 0, 0, 0, 0}));
  ASSERT_TRUE(next_frame(*bus, out));
  EXPECT_EQ(bus->stats().state, CanState::bus_off);
  const Status sent = bus->send(frame_of(1, {}), kNever);
  ASSERT_FALSE(sent);
  EXPECT_EQ(sent.error().code, Errc::closed);
  ASSERT_TRUE(other.put(CAN_ERR_FLAG | CAN_ERR_RESTARTED, {0, 0, 0, 0, 0, 0, 0, 0}));
  ASSERT_TRUE(next_frame(*bus, out));
  EXPECT_EQ(bus->stats().state, CanState::active);
  EXPECT_TRUE(bus->send(frame_of(1, {}), kNever));
  EXPECT_EQ(bus->stats().bus_offs, 1u);
  EXPECT_EQ(bus->stats().restarts, 1u);
  EXPECT_EQ(bus->stats().error_frames, 3u);
  EXPECT_EQ(bus->stats().received, 0u);
}

TEST_F(SocketCan, InterfaceThatGoesDownAndUpIsSurvived) {
  VirtualCan interface("sinewup0");
  ASSERT_EQ(interface.error(), 0);
  ASSERT_TRUE(interface.up(true));
  auto bus = open(spec(interface.name()));
  ASSERT_TRUE(bus) << why_;
  msg::CanFrame out;
  for (int round = 0; round < 2; ++round) {
    ASSERT_TRUE(interface.up(false));
    ASSERT_TRUE(eventually([&] {
      const auto read = bus->read(out);
      return !read && read.error().code == Errc::closed;
    }));
    EXPECT_EQ(bus->stats().state, CanState::stopped);
    const Status sent = bus->send(frame_of(1, {}), kNever);
    ASSERT_FALSE(sent);
    EXPECT_EQ(sent.error().code, Errc::closed);
    EXPECT_TRUE(eventually([&] {
      return bus->trouble() == "sinewup0: the interface is down: 'ip link set sinewup0 up'";
    })) << bus->trouble();
    ASSERT_TRUE(interface.up(true));
    ASSERT_TRUE(eventually([&] { return bus->send(frame_of(2, {}), kNever).has_value(); }));
    RawCan other(interface.name());
    ASSERT_TRUE(other.good() && other.put(0x123, {1}));
    ASSERT_TRUE(next_frame(*bus, out));
    EXPECT_EQ(out.id, 0x123u);
    EXPECT_TRUE(eventually([&] { return bus->stats().state == CanState::active && bus->trouble().empty(); }));
  }
}

TEST_F(SocketCan, InterfaceThatIsRemovedAndReturnsIsFoundWithItsFilters) {
  VirtualCan interface("sinewgo0");
  ASSERT_EQ(interface.error(), 0);
  ASSERT_TRUE(interface.up(true));
  auto bus = open(spec(interface.name()));
  ASSERT_TRUE(bus) << why_;
  ASSERT_TRUE(bus->set_filters(std::vector<CanFilter>{{0x200, 0x7FF, false}}));
  WakeCounter wakes;
  bus->set_wake(&wakes);
  msg::CanFrame out;
  ASSERT_TRUE(interface.remove());
  ASSERT_TRUE(eventually([&] { return !bus->read(out); }));
  EXPECT_TRUE(eventually([&] { return bus->trouble() == "sinewgo0: the interface is gone"; })) << bus->trouble();
  const auto seen = wakes.count();
  ASSERT_TRUE(interface.create() && interface.up(true));
  ASSERT_TRUE(eventually([&] { return wakes.count() > seen; })) << "whoever waits is told";
  ASSERT_TRUE(eventually([&] { return bus->send(frame_of(2, {}), kNever).has_value(); }));
  RawCan other(interface.name());
  ASSERT_TRUE(other.good() && other.put(0x100, {}) && other.put(0x200, {}));
  ASSERT_TRUE(next_frame(*bus, out));
  EXPECT_EQ(out.id, 0x200u);
  bus->set_wake(nullptr);
}

TEST_F(SocketCan, InterfaceThatIsDownAtTheStartIsOpenedAndComesUp) {
  VirtualCan interface("sinewlt0");
  ASSERT_EQ(interface.error(), 0);
  auto bus = open(spec(interface.name()));
  ASSERT_TRUE(bus) << why_;
  EXPECT_EQ(why_, "sinewlt0: the interface is down: 'ip link set sinewlt0 up'");
  EXPECT_EQ(bus->stats().state, CanState::stopped);
  ASSERT_TRUE(interface.up(true));
  ASSERT_TRUE(eventually([&] { return bus->send(frame_of(2, {}), kNever).has_value(); }));
}

TEST_F(SocketCan, WhatKeepsItFromOpeningIsSaid) {
  EXPECT_FALSE(open(spec("nowhere0")));
  EXPECT_EQ(code_, Errc::not_found);
  EXPECT_EQ(why_,
            "nowhere0: there is no such interface ('ip link' lists them); a virtual one: 'ip link add dev nowhere0 "
            "type vcan'");
  EXPECT_FALSE(open(spec("lo")));
  EXPECT_EQ(code_, Errc::bad_argument);
  EXPECT_EQ(why_, "lo: is no CAN interface");
}

TEST_F(SocketCan, FrameWhoseDeadlineIsOverIsNotSent) {
  auto a = open(), b = open();
  ASSERT_TRUE(a && b) << why_;
  const Status late = a->send(frame_of(1, {}), system_os().now());
  ASSERT_FALSE(late);
  EXPECT_EQ(late.error().code, Errc::timeout);
  ASSERT_TRUE(a->send(frame_of(2, {}), system_os().now() + kPatience));
  msg::CanFrame out;
  ASSERT_TRUE(next_frame(*b, out));
  EXPECT_EQ(out.id, 2u);
  EXPECT_EQ(a->stats().tx_lost, 1u);
}

}  // namespace
}  // namespace sinew::hal::socket_can_test
