#include "hal/linux/udp_radio.hpp"

#include <arpa/inet.h>
#include <fcntl.h>
#include <gmock/gmock.h>
#include <net/if.h>
#include <sched.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <linux/if_tun.h>

#include <cstring>
#include <functional>
#include <thread>

#include "../../rt/counting_new.hpp"
#include "hal/can_waiting.hpp"
#include "qemu_user.hpp"

namespace sinew::hal::udp_radio_test {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;

using Bytes = std::vector<std::uint8_t>;

/// Tests run beside each other: each process has a group of its own.
UdpAddress own_group() {
  const auto id = static_cast<std::uint32_t>(getpid());
  return {0xEF480000 | (id & 0xFFFF), static_cast<std::uint16_t>(20000 + id % 20000)};
}

RadioSpec spec(std::string interface = "lo") {
  RadioSpec out;
  out.group = own_group(), out.interface = std::move(interface);
  return out;
}

std::unique_ptr<Radio> opened(const RadioSpec& s) {
  std::string why;
  auto radio = UdpRadio::open(s, system_os(), why);
  EXPECT_TRUE(radio) << why;
  return radio ? std::move(*radio) : nullptr;
}

std::string trouble_of(const Radio& radio) { return dynamic_cast<const SelfReport&>(radio).trouble(); }

Bytes text(std::string_view words) { return {words.begin(), words.end()}; }
Bytes bytes_of(const msg::Datagram& d) { return {d.bytes().begin(), d.bytes().end()}; }

bool next(Radio& radio, msg::Datagram& out) {
  return eventually([&] {
    const auto read = radio.read(out);
    return read && *read;
  });
}

/// What `from` sends arrives at `to`, from some time on: sends again and again, and reads all that came of it.
::testing::AssertionResult flows(Radio& from, Radio& to) {
  static int tries = 0;
  msg::Datagram out;
  const bool arrived = eventually([&] {
    if (!from.send(text("try " + std::to_string(++tries)))) return false;
    system_os().sleep_until(system_os().now() + 1ms);
    for (auto read = to.read(out); read && *read; read = to.read(out))
      if (bytes_of(out) == text("try " + std::to_string(tries))) return true;
    return false;
  });
  if (arrived) return ::testing::AssertionSuccess();
  return ::testing::AssertionFailure() << "sender: '" << trouble_of(from) << "', receiver: '" << trouble_of(to) << "'";
}

/// Sends any bytes to an address, as a foreign program.
class Foreign {
 public:
  explicit Foreign(const UdpAddress& to) {
    ip_mreqn loopback{};
    loopback.imr_address.s_addr = htonl(INADDR_LOOPBACK);
    EXPECT_EQ(setsockopt(fd_, IPPROTO_IP, IP_MULTICAST_IF, &loopback, sizeof loopback), 0);
    to_.sin_family = AF_INET, to_.sin_port = htons(to.port), to_.sin_addr.s_addr = htonl(to.ipv4);
  }
  ~Foreign() { close(fd_); }
  void put(const Bytes& bytes) {
    EXPECT_EQ(sendto(fd_, bytes.data(), bytes.size(), 0, reinterpret_cast<sockaddr*>(&to_), sizeof to_),
              static_cast<ssize_t>(bytes.size()));
  }

 private:
  int fd_ = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  sockaddr_in to_{};
};

std::uint16_t free_port() {
  const int fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  sockaddr_in own{};
  own.sin_family = AF_INET;
  socklen_t size = sizeof own;
  EXPECT_EQ(bind(fd, reinterpret_cast<sockaddr*>(&own), size), 0);
  EXPECT_EQ(getsockname(fd, reinterpret_cast<sockaddr*>(&own), &size), 0);
  close(fd);
  return ntohs(own.sin_port);
}

class UdpRadioTest : public ::testing::Test {
 protected:
  void SetUp() override { SINEW_SKIP_UNDER_QEMU_USER("IP_MULTICAST_IF"); }
};

TEST_F(UdpRadioTest, DatagramsReachAllOthersOfTheGroupAndNotTheirSender) {
  const auto a = opened(spec()), b = opened(spec()), c = opened(spec());
  const Time before = system_os().now();
  ASSERT_TRUE(a->send(text("a long one")));
  ASSERT_TRUE(a->send(text("short")));
  msg::Datagram first, second, out;
  ASSERT_TRUE(next(*b, first));
  EXPECT_EQ(bytes_of(first), text("a long one"));
  EXPECT_GE(first.stamp.ns, before.ns - 10'000'000);
  EXPECT_LE(first.stamp, system_os().now()) << "on the runtime's clock";
  EXPECT_EQ(first.lost, 0u);
  ASSERT_TRUE(next(*b, second));
  EXPECT_EQ(bytes_of(second), text("short"));
  EXPECT_EQ(second.data[5], 0) << "nothing is left of the one before";
  EXPECT_EQ(second.port, first.port);
  EXPECT_EQ(second.sender, 0x7F000001u);
  ASSERT_TRUE(next(*c, out));
  ASSERT_TRUE(b->send(text("from b")));
  ASSERT_TRUE(next(*a, out));
  EXPECT_EQ(bytes_of(out), text("from b")) << "its own, which were first, did not come back";
  EXPECT_NE(out.port, first.port) << "two of one machine are told apart";
  EXPECT_EQ(a->stats().sent, 2u);
  EXPECT_EQ(a->stats().sent_bytes, 15u);
  EXPECT_EQ(a->stats().received, 1u);
  EXPECT_EQ(b->stats().received_bytes, 15u);
  EXPECT_EQ(trouble_of(*a), "");
}

TEST_F(UdpRadioTest, AnotherGroupOnTheSamePortIsNotHeard) {
  RadioSpec other = spec();
  other.group.ipv4 ^= 1u << 16;
  const auto a = opened(spec()), stranger = opened(other), b = opened(spec());
  ASSERT_TRUE(stranger->send(text("not for you")));
  ASSERT_TRUE(a->send(text("for you")));
  msg::Datagram out;
  ASSERT_TRUE(next(*b, out));
  EXPECT_EQ(bytes_of(out), text("for you"));
}

TEST_F(UdpRadioTest, WhoWaitsIsWokenWhenADatagramCame) {
  const auto a = opened(spec()), b = opened(spec());
  WakeCounter wakes;
  b->set_wake(&wakes);
  EXPECT_EQ(b->ready_at(), kNever);
  ASSERT_TRUE(a->send(text("x")));
  EXPECT_TRUE(wakes.wait_for(1));
  EXPECT_LE(b->ready_at(), system_os().now());
  b->set_wake(nullptr);
}

TEST_F(UdpRadioTest, OnlyWhatFitsOneDatagramIsSent) {
  const auto a = opened(spec()), b = opened(spec());
  EXPECT_EQ(a->send({}).error().code, Errc::bad_argument);
  EXPECT_EQ(a->send(Bytes(msg::kMaxDatagramBytes + 1)).error().code, Errc::bad_argument);
  EXPECT_EQ(a->stats().tx_lost, 0u);
  Bytes most(msg::kMaxDatagramBytes, 7);
  ASSERT_TRUE(a->send(most));
  msg::Datagram out;
  ASSERT_TRUE(next(*b, out));
  EXPECT_EQ(bytes_of(out), most);
}

TEST_F(UdpRadioTest, EmptyAndTooLongDatagramsAreDroppedAndCounted) {
  const auto radio = opened(spec());
  Foreign foreign(own_group());
  foreign.put({});
  foreign.put(Bytes(msg::kMaxDatagramBytes + 1));
  foreign.put(Bytes(9000));
  foreign.put({0xFF});
  msg::Datagram out;
  ASSERT_TRUE(next(*radio, out));
  EXPECT_EQ(bytes_of(out), Bytes{0xFF}) << "what is short enough is delivered, whatever it says";
  EXPECT_EQ(radio->stats().rx_other, 3u);
  EXPECT_EQ(radio->stats().received, 1u);
}

TEST_F(UdpRadioTest, AFloodOfJunkTakesNoMoreMemoryAndEveryLossIsCounted) {
  const auto radio = opened(spec()), mate = opened(spec());
  Foreign foreign(own_group());
  const Bytes junk(300, 0xA5);
  std::uint64_t sent = 0;
  const std::uint64_t least = 20'000;  // more than socket and queue hold
  for (const Time end = system_os().now() + 1s; sent < least || system_os().now() < end; ++sent) foreign.put(junk);
  EXPECT_TRUE(eventually([&] { return radio->stats().received == UdpRadio::kWaiting; })) << "and no more";
  std::uint64_t read = 0, lost = 0;
  msg::Datagram out;
  // The last one that is received says what was lost before it.
  EXPECT_TRUE(eventually([&] {
    if (mate->send(text("after"))) ++sent;
    system_os().sleep_until(system_os().now() + 5ms);
    for (auto got = radio->read(out); got && *got; got = radio->read(out)) ++read, lost += out.lost;
    return read + lost == sent;
  })) << read
      << " were read and " << lost << " lost of " << sent;
  EXPECT_GT(lost, 0u);
  EXPECT_EQ(radio->stats().rx_lost, lost);
  EXPECT_EQ(radio->stats().received, read);
  EXPECT_TRUE(flows(*mate, *radio)) << "it goes on";
}

TEST_F(UdpRadioTest, ComplainsAsLongAsMoreComesInThanIsRead) {
  const auto radio = opened(spec());
  Foreign foreign(own_group());
  msg::Datagram out;
  EXPECT_TRUE(eventually([&] {
    for (int i = 0; i < 3000; ++i) foreign.put(Bytes(300));
    // The kernel says what it lost with the first datagram after it, and hundreds wait before that one.
    for (int i = 0; i < 64; ++i) static_cast<void>(radio->read(out));
    return trouble_of(*radio).find("more comes in than is read") != std::string::npos;
  }));
  EXPECT_TRUE(eventually([&] {
    for (auto got = radio->read(out); got && *got;) got = radio->read(out);
    return trouble_of(*radio).empty();
  }));
}

TEST_F(UdpRadioTest, ReadingAndSendingAllocateNothing) {
  const auto a = opened(spec()), b = opened(spec());
  const Bytes bytes(1000, 1);
  msg::Datagram out;
  int with = 0;
  for (int i = 0; i < 200; ++i) {
    const std::uint64_t before = test::allocations();
    static_cast<void>(a->send(bytes));
    static_cast<void>(b->read(out));
    if (test::allocations() != before) ++with;
    system_os().sleep_until(system_os().now() + 1ms);
  }
  EXPECT_LT(with, 20) << "but for the radios' own threads, which look at the network each second";
}

TEST_F(UdpRadioTest, PeersHearEachOtherWithoutAGroup) {
  RadioSpec one, two;
  one.port = free_port(), two.port = free_port();
  const std::vector<UdpAddress> team{{INADDR_LOOPBACK, one.port}, {INADDR_LOOPBACK, two.port}};
  one.peers = two.peers = team;  // the same list for all, with each robot itself
  const auto a = opened(one), b = opened(two);
  ASSERT_TRUE(a->send(text("a")));
  ASSERT_TRUE(b->send(text("b")));
  msg::Datagram out;
  ASSERT_TRUE(next(*b, out));
  EXPECT_EQ(bytes_of(out), text("a"));
  EXPECT_EQ(out.port, one.port);
  ASSERT_TRUE(next(*a, out));
  EXPECT_EQ(bytes_of(out), text("b")) << "and not its own";
  EXPECT_EQ(a->stats().sent, 2u) << "one to each";
  std::string why;
  const auto third = UdpRadio::open(one, system_os(), why);
  ASSERT_FALSE(third);
  EXPECT_EQ(third.error().code, Errc::busy);
  EXPECT_THAT(why, HasSubstr("UDP port " + std::to_string(one.port) + ": another program has this port"));
}

TEST_F(UdpRadioTest, ListenersOfOneMachineHearABroadcastAndAnswerItsSender) {
  const std::uint16_t port = free_port(), answers = free_port();
  RadioSpec listener, caller;
  listener.listens = true, listener.port = port;
  caller.peers = {{0x7FFFFFFF, port}}, caller.port = answers;  // 127.255.255.255
  const auto a = opened(listener), b = opened(listener), far = opened(caller);
  ASSERT_TRUE(a && b && far);
  ASSERT_TRUE(far->send(text("to all")));
  msg::Datagram out;
  for (Radio* radio : {a.get(), b.get()}) {
    ASSERT_TRUE(next(*radio, out));
    EXPECT_EQ(bytes_of(out), text("to all"));
    EXPECT_EQ(out.port, answers);
    ASSERT_TRUE(radio->send_to({out.sender, static_cast<std::uint16_t>(out.port)}, text("heard")));
    ASSERT_TRUE(next(*far, out));
    EXPECT_EQ(bytes_of(out), text("heard"));
    EXPECT_EQ(out.port, port);
    const Status to_all = radio->send(text("to whom?"));
    ASSERT_FALSE(to_all);
    EXPECT_EQ(to_all.error().code, Errc::not_supported);
  }
}

TEST_F(UdpRadioTest, SpecsThatCannotBeAreRefusedInWords) {
  const auto refused = [](const RadioSpec& s) {
    std::string why;
    const auto radio = UdpRadio::open(s, system_os(), why);
    EXPECT_FALSE(radio);
    EXPECT_EQ(radio.error().code, Errc::bad_argument);
    return why;
  };
  RadioSpec s;
  s.group = {0x0A000001, 4580};
  EXPECT_THAT(refused(s), HasSubstr("10.0.0.1:4580 is no group"));
  s = {}, s.ttl = 0;
  EXPECT_EQ(refused(s), "ttl is from 1 to 255");
  s = {}, s.interface = "sixteencharacter";
  EXPECT_THAT(refused(s), HasSubstr("longer than an interface's name"));
  s = {}, s.peers = {{0xEF480101, 4580}};
  EXPECT_EQ(refused(s), "239.72.1.1:4580 is no peer's address");
  s = {}, s.listens = true, s.port = 0;
  EXPECT_EQ(refused(s), "port is from 1 to 65535");
  s.port = 4580, s.peers = {{0x7F000001, 4580}};
  EXPECT_EQ(refused(s), "a radio that listens has no peers");
}

// ---- networks that come and go

/// An interface of this network namespace.
class Tun {
 public:
  explicit Tun(std::string name) : name_(std::move(name)), fd_(open("/dev/net/tun", O_RDWR | O_CLOEXEC)) {
    ifreq r = named();
    r.ifr_flags = IFF_TUN | IFF_NO_PI;
    good_ = fd_ >= 0 && ioctl(fd_, TUNSETIFF, &r) == 0;
  }
  ~Tun() {  // removes the interface
    if (fd_ >= 0) close(fd_);
    close(socket_);
  }
  bool good() const { return good_; }
  bool address(const char* text) {
    const auto set = [&](unsigned long what, const char* value) {
      ifreq r = named();
      sockaddr_in in{};
      in.sin_family = AF_INET;
      inet_pton(AF_INET, value, &in.sin_addr);
      std::memcpy(&r.ifr_addr, &in, sizeof in);
      return ioctl(socket_, what, &r) == 0;
    };
    return set(SIOCSIFADDR, text) && set(SIOCSIFNETMASK, "255.255.255.0");
  }
  bool up(bool on = true) { return up(socket_, named(), on); }
  static bool up(int socket, ifreq r, bool on) {
    if (ioctl(socket, SIOCGIFFLAGS, &r) != 0) return false;
    r.ifr_flags = static_cast<short>(on ? r.ifr_flags | IFF_UP : r.ifr_flags & ~IFF_UP);
    return ioctl(socket, SIOCSIFFLAGS, &r) == 0;
  }

 private:
  ifreq named() const {
    ifreq r{};
    std::strncpy(r.ifr_name, name_.c_str(), IFNAMSIZ - 1);
    return r;
  }
  std::string name_;
  int fd_, socket_ = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  bool good_ = false;
};

bool loopback_up() {
  const int fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  ifreq r{};
  std::strcpy(r.ifr_name, "lo");
  const bool up = Tun::up(fd, r, true);
  close(fd);
  return up;
}

class UdpRadioNetwork : public UdpRadioTest {
 protected:
  /// Runs the test on a network without any interface but a loopback that is down.
  void alone(const std::function<void()>& body) {
    bool permitted = true;
    std::thread([&] {
      permitted = unshare(CLONE_NEWNET) == 0 && access("/dev/net/tun", R_OK | W_OK) == 0 && Tun("try0").good();
      if (permitted) body();
    }).join();
    if (!permitted) GTEST_SKIP() << "network namespaces and TUN devices are for root";
  }
};

TEST_F(UdpRadioNetwork, RobotsStartWithoutANetworkAndHearEachOtherWhenItComes) {
  alone([] {
    const auto a = opened(spec("air0")), b = opened(spec("air0"));
    const Status nothing = a->send(text("x"));
    ASSERT_FALSE(nothing);
    EXPECT_EQ(nothing.error().code, Errc::closed);
    EXPECT_EQ(a->stats().tx_lost, 1u);
    EXPECT_EQ(trouble_of(*a),
              "group " + to_text(own_group()) + ": there is no interface 'air0' ('ip link' lists them)");
    Tun air("air0");
    EXPECT_TRUE(eventually([&] { return trouble_of(*a).ends_with("'air0' is down"); })) << trouble_of(*a);
    ASSERT_TRUE(air.up());
    EXPECT_TRUE(eventually([&] { return trouble_of(*a).ends_with("has no IPv4 address"); })) << trouble_of(*a);
    ASSERT_TRUE(air.address("10.9.0.1"));
    EXPECT_TRUE(flows(*a, *b));
    EXPECT_TRUE(flows(*b, *a));
    EXPECT_EQ(trouble_of(*a), "");
  });
}

TEST_F(UdpRadioNetwork, AnInterfaceThatGoesDownAndUpIsUsedAgain) {
  alone([] {
    Tun air("air0");
    ASSERT_TRUE(air.address("10.9.0.1") && air.up());
    const auto a = opened(spec("air0")), b = opened(spec("air0"));
    for (int i = 0; i < 5; ++i) {
      ASSERT_TRUE(flows(*a, *b)) << i;
      ASSERT_TRUE(air.up(false));
      EXPECT_TRUE(eventually([&] { return !a->send(text("x")); })) << i;
      EXPECT_TRUE(eventually([&] { return trouble_of(*a).ends_with("'air0' is down"); })) << trouble_of(*a);
      ASSERT_TRUE(air.up());
    }
    EXPECT_TRUE(flows(*a, *b));
  });
}

// More often than a socket may have memberships (igmp_max_memberships, 20).
TEST_F(UdpRadioNetwork, AnInterfaceThatIsReplacedOftenIsAlwaysJoined) {
  alone([] {
    const auto a = opened(spec("air0")), b = opened(spec("air0"));
    for (int i = 0; i < 45; ++i) {
      Tun air("air0");
      ASSERT_TRUE(air.address("10.9.0.1") && air.up());
      ASSERT_TRUE(flows(*a, *b)) << i;
    }
  });
}

TEST_F(UdpRadioNetwork, AnotherAddressIsTheSendersFromThenOnAndOwnDatagramsStayOut) {
  alone([] {
    Tun air("air0");
    ASSERT_TRUE(air.address("10.9.0.1") && air.up());
    const auto a = opened(spec("air0")), b = opened(spec("air0"));
    msg::Datagram out;
    for (std::uint32_t i = 1; i < 20; ++i) {
      ASSERT_TRUE(air.address(("10.9.0." + std::to_string(i)).c_str()));
      EXPECT_TRUE(eventually([&] {
        static_cast<void>(a->send(text("x")));
        for (auto got = b->read(out); got && *got; got = b->read(out))
          if (out.sender == (0x0A090000 | i)) return true;
        return false;
      })) << i;
    }
    ASSERT_TRUE(b->send(text("the first for a")));
    ASSERT_TRUE(next(*a, out));
    EXPECT_EQ(bytes_of(out), text("the first for a"));
  });
}

TEST_F(UdpRadioNetwork, WithoutAnInterfaceInTheSpecTheMachinesOwnRobotsAreHeardUntilThereIsANetwork) {
  alone([] {
    const auto a = opened(spec("")), b = opened(spec(""));
    EXPECT_THAT(trouble_of(*a), HasSubstr("no network"));
    ASSERT_TRUE(loopback_up());
    EXPECT_TRUE(flows(*a, *b));
    EXPECT_THAT(trouble_of(*a), HasSubstr("no network: only robots of this machine are heard"));
    {
      Tun air("air7");
      ASSERT_TRUE(air.address("10.9.0.7") && air.up());
      EXPECT_TRUE(eventually([&] { return trouble_of(*a).empty() && trouble_of(*b).empty(); })) << trouble_of(*a);
      msg::Datagram out;
      EXPECT_TRUE(eventually([&] {
        static_cast<void>(a->send(text("x")));
        return next(*b, out) && out.sender == 0x0A090007;
      }));
    }
    EXPECT_TRUE(eventually([&] { return !trouble_of(*a).empty() && !trouble_of(*b).empty(); }));
    EXPECT_TRUE(flows(*a, *b));
  });
}

TEST_F(UdpRadioNetwork, PeersThatCannotBeReachedAreSaid) {
  alone([] {
    RadioSpec s;
    s.peers = {{0x0A090002, 4580}};
    const auto radio = opened(s);
    const Status nothing = radio->send(text("x"));
    ASSERT_FALSE(nothing);
    EXPECT_EQ(nothing.error().code, Errc::closed);
    EXPECT_THAT(trouble_of(*radio), HasSubstr("UDP port 4580: sending fails: "));
    Tun air("air0");
    ASSERT_TRUE(air.address("10.9.0.1") && air.up());
    EXPECT_TRUE(eventually([&] { return static_cast<bool>(radio->send(text("x"))); }));
    EXPECT_EQ(trouble_of(*radio), "");
  });
}

}  // namespace
}  // namespace sinew::hal::udp_radio_test
