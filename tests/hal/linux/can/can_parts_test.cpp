// The parts of SocketCanBus that need no CAN in the kernel.
#include <gtest/gtest.h>
#include <linux/can/error.h>
#include <linux/can/netlink.h>
#include <net/if.h>  // before linux/if.h, which then leaves out what both define

#include <linux/if.h>
#include <linux/if_arp.h>
#include <linux/rtnetlink.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "hal/can_waiting.hpp"
#include "hal/linux/can/can.hpp"
#include "hal/linux/can/can_error.hpp"
#include "hal/linux/can/can_link.hpp"
#include "hal/linux/can/can_stamp.hpp"
#include "hal/linux/realtime_stamps.hpp"
#include "wire/random_can_frame.hpp"

namespace sinew::hal::can_parts_test {
namespace {

using namespace std::chrono_literals;
using wire::frame_of;

msg::CanFrame error_frame(std::uint32_t what, std::uint8_t controller = 0, std::uint8_t tx = 0, std::uint8_t rx = 0) {
  return frame_of(what, {0, controller, 0, 0, 0, 0, tx, rx}, msg::kCanError);
}

TEST(CanError, FramesMoveTheStateOfTheController) {
  CanCounters c;
  count_error_frame(error_frame(CAN_ERR_CRTL | CAN_ERR_CNT, CAN_ERR_CRTL_TX_WARNING, 96, 1), c);
  EXPECT_EQ(c.state(), CanState::warning);
  EXPECT_EQ(c.snapshot().tx_errors, 96);
  EXPECT_EQ(c.snapshot().rx_errors, 1);
  count_error_frame(error_frame(CAN_ERR_CRTL, CAN_ERR_CRTL_RX_PASSIVE | CAN_ERR_CRTL_TX_WARNING), c);
  EXPECT_EQ(c.state(), CanState::passive) << "the worse of two";
  count_error_frame(error_frame(CAN_ERR_BUSERROR | CAN_ERR_PROT), c);
  EXPECT_EQ(c.state(), CanState::passive) << "an error on the bus changes none";
  count_error_frame(error_frame(CAN_ERR_BUSOFF), c);
  count_error_frame(error_frame(CAN_ERR_BUSOFF), c);
  EXPECT_EQ(c.state(), CanState::bus_off);
  EXPECT_EQ(c.snapshot().bus_offs, 1u) << "said twice, happened once";
  count_error_frame(error_frame(CAN_ERR_RESTARTED), c);
  EXPECT_EQ(c.state(), CanState::active);
  EXPECT_EQ(c.snapshot().restarts, 1u);
  EXPECT_EQ(c.snapshot().error_frames, 6u);
  EXPECT_EQ(c.snapshot().tx_errors, 96) << "frames without counters leave them alone";
}

TEST(CanError, FramesThatTheControllerLostAreCounted) {
  CanCounters c;
  count_error_frame(error_frame(CAN_ERR_CRTL, CAN_ERR_CRTL_RX_OVERFLOW), c);
  count_error_frame(error_frame(CAN_ERR_CRTL, CAN_ERR_CRTL_TX_OVERFLOW), c);
  EXPECT_EQ(c.snapshot().rx_lost, 1u);
  EXPECT_EQ(c.snapshot().tx_lost, 1u);
}

constexpr std::int64_t kWall = 1'700'000'000'000'000'000;

ClockReading clocks(std::int64_t ns, std::int64_t set_by = 0, std::int64_t kept_waiting = 0,
                    std::int64_t before_it = 0) {
  return {Time{ns}, kWall + set_by + ns + before_it, Time{ns + kept_waiting}};
}

TEST(RealtimeStamps, WallTimeBecomesMonotonic) {
  RealtimeStamps stamps(Time{0});
  stamps.begin(clocks(5'000'000'000));
  EXPECT_EQ(stamps.convert(kWall + 4'999'000'000).ns, 4'999'000'000);
}

TEST(RealtimeStamps, ClockThatIsSetWhileFramesWaitMovesNoStamp) {
  for (const std::int64_t step : {std::int64_t{3'600'000'000'000}, std::int64_t{-3'600'000'000'000}}) {
    RealtimeStamps stamps(Time{0});
    stamps.begin(clocks(1'000'000'000));
    stamps.drained(Time{1'000'000'000});
    stamps.begin(clocks(2'000'000'000, step));
    EXPECT_EQ(stamps.convert(kWall + step + 1'999'000'000).ns, 1'999'000'000) << "stamped after it was set";
    EXPECT_EQ(stamps.convert(kWall + 1'500'000'000).ns, 1'500'000'000) << "and before";
  }
}

TEST(RealtimeStamps, ThreadThatIsKeptWaitingBetweenTheClocksMovesNoStamp) {
  RealtimeStamps stamps(Time{0});
  stamps.begin(clocks(1'000'000'000));
  stamps.drained(Time{1'000'000'000});
  for (const std::int64_t late :
       {std::int64_t{0}, std::int64_t{20'000'000}}) {  // before or after the wall clock was read
    stamps.begin(clocks(2'000'000'000, 0, 20'000'000, late));
    EXPECT_EQ(stamps.convert(kWall + 1'999'000'000).ns, 1'999'000'000) << late;
  }
  RealtimeStamps fresh(Time{900'000'000});
  fresh.begin(clocks(1'000'000'000, 0, 20'000'000, 20'000'000));
  EXPECT_NEAR(static_cast<double>(fresh.convert(kWall + 990'000'000).ns), 990e6, 10e6)
      << "half the wait when it is the first";
  fresh.begin(clocks(1'050'000'000));
  EXPECT_EQ(fresh.convert(kWall + 1'040'000'000).ns, 1'040'000'000) << "nothing of it from the next reading on";
}

TEST(RealtimeStamps, StampsLieBetweenTheEmptySocketAndTheReading) {
  RealtimeStamps stamps(Time{500'000'000});
  stamps.begin(clocks(1'000'000'000, 0, 2'000'000));
  EXPECT_EQ(stamps.convert(kWall + 1'000'100'000).ns, 1'000'000'000);
  EXPECT_EQ(stamps.convert(kWall + 9'000'000'000).ns, 1'000'000'000);
  EXPECT_EQ(stamps.convert(kWall + 498'500'000).ns, 500'000'000) << "what the reading leaves open is decided by it";
  EXPECT_EQ(stamps.convert(5).ns, 1'000'000'000) << "what cannot be is the time of reading";
}

TEST(RealtimeStamps, StampsOfAClockOfAnotherPaceAreOnThatClock) {
  for (const double rate : {0.25, 0.4, 3.0}) {
    const auto shown = [rate](std::int64_t ns) { return static_cast<std::int64_t>(static_cast<double>(ns) * rate); };
    RealtimeStamps stamps(Time{0});
    for (std::int64_t s = 1; s < 100; ++s) {  // each reading narrows the difference, and none contradicts
      const std::int64_t ns = s * 1'000'000'000, wide_ns = 1000 + s * 7919 % 50'000;
      stamps.begin({Time{shown(ns)}, kWall + ns + wide_ns / 3, Time{shown(ns + wide_ns)}, rate});
      if (s < 80) continue;
      const Time stamp = stamps.convert(kWall + ns - 30'000'000);
      EXPECT_LT(std::abs(stamp.ns - shown(ns - 30'000'000)), 4000) << rate;
    }
  }
}

TEST(HardwareStamps, FollowTheControllersClockWithTheLeastDelayThatWasSeen) {
  HardwareStamps stamps;
  std::int64_t worst = 0;
  for (int i = 0; i < 5000; ++i) {
    const std::int64_t truth = 1'000'000'000 + i * std::int64_t{1'000'000};
    const std::int64_t hardware = 77'000 + i * std::int64_t{1'000'000} + i * std::int64_t{50};  // 50 ppm fast
    const std::int64_t delay = 20'000 + (i * 7919) % 500'000;  // of the way into the kernel
    const Time t = stamps.convert(hardware, Time{truth + delay});
    ASSERT_LE(t.ns, truth + delay);
    if (i > 500) worst = std::max(worst, std::abs(t.ns - truth));
  }
  EXPECT_LT(worst, 150'000) << "the least delay and two seconds of drift, not the 500 us of the way";
}

TEST(HardwareStamps, ClockThatBeginsAnewIsTakenUpAtOnce) {
  HardwareStamps stamps;
  EXPECT_EQ(stamps.convert(5'000'000'000'000, Time{1'000'000'000}).ns, 1'000'000'000);
  EXPECT_EQ(stamps.convert(0, Time{1'500'000'000}).ns, 1'500'000'000);
  EXPECT_EQ(stamps.convert(1'000'000, Time{1'501'000'000}).ns, 1'501'000'000);
}

TEST(SocketCanWithoutBus, SaysWhatIsMissingAndWhatToDo) {
  const int fd = socket(PF_CAN, SOCK_RAW | SOCK_CLOEXEC, 1);
  const bool kernel_has_can = fd >= 0;
  if (fd >= 0) close(fd);
  CanSpec spec;
  spec.transport = "socketcan", spec.address = "nowhere0";
  std::string why;
  const auto bus = open_can(spec, system_os(), start_watch(), why);
  ASSERT_FALSE(bus);
  EXPECT_EQ(bus.error().code, kernel_has_can ? Errc::not_found : Errc::not_supported);
  EXPECT_EQ(why, kernel_has_can
                     ? "nowhere0: there is no such interface ('ip link' lists them); a virtual one: 'ip link add dev "
                       "nowhere0 type vcan'"
                     : "nowhere0: this kernel has no CAN (PF_CAN): load it with 'modprobe can-raw', or use the "
                       "transport \"udp\" or \"socketcand\", which need none");
}

/// An answer of the kernel, put together by hand: attributes nest by closing what begin() opened.
class Answer {
 public:
  Answer(unsigned flags, unsigned short type) {
    nlmsghdr head{};
    head.nlmsg_type = RTM_NEWLINK;
    ifinfomsg info{};
    info.ifi_type = type, info.ifi_index = 7, info.ifi_flags = flags;
    put(head), put(info);
  }
  template <class T>
  Answer& attribute(int type, const T& value) {
    const std::size_t at = begin(type);
    put(value);
    return end(at);
  }
  std::size_t begin(int type) {
    rtattr head{};
    head.rta_type = static_cast<unsigned short>(type);
    put(head);
    return bytes_.size() - sizeof head;
  }
  Answer& end(std::size_t at) {
    const auto size = static_cast<unsigned short>(bytes_.size() - at);
    std::memcpy(&bytes_[at], &size, sizeof size);
    bytes_.resize((bytes_.size() + 3) / 4 * 4);
    return *this;
  }
  std::vector<std::byte> bytes() const {
    auto out = bytes_;
    const auto size = static_cast<std::uint32_t>(out.size());
    std::memcpy(out.data(), &size, sizeof size);
    return out;
  }

 private:
  template <class T>
  void put(const T& value) {
    const auto* p = reinterpret_cast<const std::byte*>(&value);
    bytes_.insert(bytes_.end(), p, p + sizeof value);
  }
  std::vector<std::byte> bytes_;
};

std::vector<std::byte> controller(std::uint32_t state) {
  Answer answer(IFF_UP, ARPHRD_CAN);
  answer.attribute(IFLA_IFNAME, std::array<char, 5>{"can0"}).attribute(IFLA_MTU, std::uint32_t{72});
  const auto info = answer.begin(IFLA_LINKINFO);
  answer.attribute(IFLA_INFO_KIND, std::array<char, 4>{"can"});
  const auto data = answer.begin(IFLA_INFO_DATA);
  can_bittiming timing{};
  timing.bitrate = 500'000;
  can_berr_counter errors{};
  errors.txerr = 128, errors.rxerr = 300;
  answer.attribute(IFLA_CAN_STATE, state).attribute(IFLA_CAN_RESTART_MS, std::uint32_t{100});
  answer.attribute(IFLA_CAN_BITTIMING, timing).attribute(IFLA_CAN_BERR_COUNTER, errors);
  return answer.end(data).end(info).bytes();
}

TEST(CanLink, WhatTheKernelTellsOfAControllerIsRead) {
  const auto link = parse_can_link(controller(CAN_STATE_ERROR_PASSIVE));
  ASSERT_TRUE(link);
  EXPECT_EQ(link->index, 7);
  EXPECT_TRUE(link->up && link->fd);
  EXPECT_EQ(link->kind, "can");
  EXPECT_EQ(link->state, CanState::passive);
  EXPECT_EQ(link->restart_ms, 100u);
  EXPECT_EQ(link->bit_rate, 500'000u);
  EXPECT_EQ(link->tx_errors, 128);
  EXPECT_EQ(link->rx_errors, 255) << "as many as fit";
  EXPECT_EQ(parse_can_link(controller(CAN_STATE_BUS_OFF))->state, CanState::bus_off);
}

TEST(CanLink, CutOrChangedAnswersAreRefusedOrRead) {
  const auto whole = controller(CAN_STATE_ERROR_ACTIVE);
  for (std::size_t size = 0; size < whole.size(); ++size)
    EXPECT_FALSE(parse_can_link(std::span(whole).first(size))) << size;
  std::mt19937 random(7);
  for (int i = 0; i < 20000; ++i) {
    auto bytes = whole;
    for (int k = 0; k < 3; ++k) bytes[random() % bytes.size()] = static_cast<std::byte>(random());
    const auto link = parse_can_link(bytes);  // a sanitizer watches
    if (!link) {
      EXPECT_NE(link.error().where[0], '\0');
    }
  }
}

TEST(CanLink, InterfacesThatAreNoneOrNotForCanAreNamed) {
  const auto none = read_can_link("nowhere0");
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().code, Errc::not_found);
  const auto loopback = read_can_link("lo");
  ASSERT_FALSE(loopback);
  EXPECT_EQ(loopback.error().code, Errc::bad_argument);
  EXPECT_FALSE(read_can_link("a_name_of_many_letters"));
  EXPECT_FALSE(restart_can(1)) << "the loopback interface has no controller";
}

}  // namespace
}  // namespace sinew::hal::can_parts_test
