// The link to a robot that speaks text, on real sockets: what goes out, what comes in, and how it fails.
#include "drivers/text/text_link.hpp"

#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <thread>

#include "drivers/board/device_board.hpp"
#include "drivers/board/driver_list.hpp"
#include "drivers/text/alturi_ini.hpp"
#include "hal/linux/devices/connectors.hpp"
#include "hal/platform.hpp"
#include "source_dir.hpp"

namespace sinew::drivers::text_link_test {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;
using Keys = std::map<std::string, rt::ParamValue>;

DeviceSpec text_table(const std::string& name, const std::string& driver, const Keys& keys) {
  DeviceSpec spec;
  spec.name = name, spec.driver = driver;
  for (const auto& [key, value] : keys) spec.keys[key] = {value, 1};
  return spec;
}

/// The simulator's side of a TCP link.
class Server {
 public:
  Server() : listener_(std::move(*hal::listen_stream("tcp:127.0.0.1:0"))) {}
  std::string endpoint() const {
    const std::string text = listener_->endpoint();
    return text.starts_with("tcp:") ? text : "tcp:" + text;
  }
  bool accept() {
    auto made = listener_->accept(10s);
    if (!made) return false;
    peer_ = std::move(*made);
    peer_->set_patience(10s);
    received_.clear();
    return true;
  }
  void say(std::string_view text) { ASSERT_TRUE(peer_->write(std::as_bytes(std::span(text)))); }
  void cut() { peer_.reset(); }
  /// Reads until `what` has come; all that came so far.
  std::string until(std::string_view what) {
    std::array<std::byte, 512> bytes{};
    while (received_.find(what) == std::string::npos) {
      const auto got = peer_->read(bytes);
      if (!got) return received_ + "<gone>";
      received_.append(reinterpret_cast<const char*>(bytes.data()), *got);
    }
    return received_;
  }
  void forget() { received_.clear(); }

 private:
  std::unique_ptr<hal::Listener> listener_;
  std::unique_ptr<hal::Stream> peer_;
  std::string received_;
};

class TextLinkTest : public ::testing::Test {
 protected:
  DeviceSpec link(const std::string& to, Keys keys = {}) {
    keys.emplace("to", to);
    keys.emplace("greeting", std::string("INIT {Name R1}"));
    keys.emplace("prefix", std::string("DRIVE "));
    keys.emplace("period_ms", 10.0);
    keys.emplace("silent_ms", 200.0);
    keys.emplace("reconnect_ms", 60000.0);
    DeviceSpec spec = text_table("drone", "text", keys);
    for (const char* side : {"Left", "Right"})
      spec.drives.push_back(text_table(
          side, "", {{"text", "{" + std::string(side) + " %1.2f}"}, {"min", -5.0}, {"max", 5.0}, {"increment", 0.01}}));
    spec.commands.push_back(text_table("zoom", "", {{"text", std::string("CAMERA {Zoom %1.1f}")}, {"max", 3.0}}));
    spec.messages.push_back(text_table("height", "",
                                       {{"message", std::string("SEN")},
                                        {"where", std::string("Type=GroundTruth")},
                                        {"key", std::string("Location")},
                                        {"index", std::int64_t{2}}}));
    spec.messages.push_back(text_table("front", "",
                                       {{"where", std::string("Type=Sonar, Name=F2")},
                                        {"key", std::string("Range")},
                                        {"scale", 2.0},
                                        {"offset", 1.0}}));
    return spec;
  }
  void open(DeviceSpec spec) {
    DeviceSpecs specs;
    specs.devices.push_back(std::move(spec));
    specs.devices.push_back(
        text_table("range", "text_range", {{"link", std::string("drone")}, {"range", std::string("front")}}));
    specs.devices.push_back(
        text_table("camera", "text_commands", {{"link", std::string("drone")}, {"commands", std::string("zoom")}}));
    for (const rt::Problem& p : check_devices(specs, all_drivers())) ADD_FAILURE() << rt::to_string(p, "r.toml");
    board = std::make_unique<DeviceBoard>(specs, all_drivers(), *connectors, hal::system_os());
    values = *board->sensor<msg::TextValues>("drone");
    drives = *board->actuators("drone");
  }
  /// Reads until a message satisfies; false: none in ten seconds.
  template <class M, class Is>
  bool wait_for(hal::Sensor<M>* sensor, M& out, Is&& is) {
    const hal::Time end = hal::system_os().now() + 10s;
    while (hal::system_os().now() < end) {
      const auto got = sensor->read(out);
      if (got && *got && is(out)) return true;
      if (!got || !*got) std::this_thread::sleep_for(2ms);
    }
    return false;
  }
  bool eventually(const std::function<bool()>& is) {
    const hal::Time end = hal::system_os().now() + 10s;
    while (!is()) {
      if (hal::system_os().now() > end) return false;
      std::this_thread::sleep_for(5ms);
    }
    return true;
  }
  hal::Status drive(double left, double right, hal::Duration lease = 10s) {
    msg::ActuatorCommand command;
    command.count = 2, command.armed = 1;
    command.value[0] = left, command.value[1] = right;
    return drives->write(command, lease);
  }
  bool is_closed() {
    msg::TextValues message;
    return eventually([&] {
      const auto got = values->read(message);
      return !got && got.error().code == hal::Errc::closed;
    });
  }
  void hear_height(Server& server, const std::string& height) {
    server.say("SEN {Type GroundTruth} {Location 1.20,2.50," + height + "}\r\n");
    ASSERT_TRUE(wait_for(values, heard, [&](const msg::TextValues& m) { return m.value[0] == std::stod(height); }));
  }
  std::string complaints() {
    std::string all;
    for (const std::string& one : board->complaints()) all += one + "\n";
    return all;
  }

  std::unique_ptr<hal::Connectors> connectors = hal::LinuxConnectors::unwatched(hal::system_os());
  std::unique_ptr<DeviceBoard> board;
  hal::Sensor<msg::TextValues>* values = nullptr;
  hal::Actuators* drives = nullptr;
  msg::TextValues heard;
};

TEST_F(TextLinkTest, ItGreetsReadsValuesAndSendsDrivesWithinTheirLimits) {
  Server server;
  open(link(server.endpoint()));
  ASSERT_TRUE(server.accept());
  EXPECT_EQ(server.until("\r\n"), "INIT {Name R1}\r\n");
  hear_height(server, "2.05");
  EXPECT_EQ(heard.fresh, 1u);
  EXPECT_TRUE(std::isnan(heard.value[1])) << "it never came";
  ASSERT_TRUE(drive(1.234, -7));
  EXPECT_THAT(server.until("DRIVE {Left 1.23} {Right -5.00}\r\n"), HasSubstr("DRIVE {Left 1.23} {Right -5.00}\r\n"));
}

TEST_F(TextLinkTest, OneOfSeveralSensorsOfALineIsARangeFinder) {
  Server server;
  open(link(server.endpoint()));
  hal::Sensor<msg::RangeSample>* range = *board->sensor<msg::RangeSample>("range");
  ASSERT_TRUE(server.accept());
  server.say("SEN {Type Sonar} {Name F1 Range 0.5 Name F2 Range 0.75}\r\n");
  msg::RangeSample sample;
  ASSERT_TRUE(wait_for(range, sample, [](const auto&) { return true; }));
  EXPECT_EQ(sample.range_m, 2.5);
}

TEST_F(TextLinkTest, ACommandIsSentOnceForEachChange) {
  Server server;
  open(link(server.endpoint()));
  hal::Actuators* camera = *board->actuators("camera");
  ASSERT_TRUE(server.accept());
  hear_height(server, "1.00");
  msg::ActuatorCommand command;
  command.count = 1, command.armed = 1;
  for (const double zoom : {0.0, 1.5, 9.0}) {
    command.value[0] = zoom;
    ASSERT_TRUE(camera->write(command, 10s));
    std::this_thread::sleep_for(60ms);
  }
  const std::string all = server.until("CAMERA {Zoom 3.0}\r\n");
  EXPECT_THAT(all, HasSubstr("CAMERA {Zoom 1.5}\r\nCAMERA {Zoom 3.0}\r\n"));
  EXPECT_EQ(all.find("Zoom 0.0"), std::string::npos) << "0 from the beginning was never asked for";
}

TEST_F(TextLinkTest, ALeaseThatEndsPutsTheDrivesToRest) {
  Server server;
  open(link(server.endpoint()));
  ASSERT_TRUE(server.accept());
  hear_height(server, "1.00");
  ASSERT_TRUE(drive(2, 2, 100ms));
  server.until("{Left 2.00}");
  EXPECT_THAT(server.until("DRIVE {Left 0.00} {Right 0.00}\r\n"), HasSubstr("{Left 0.00}"));
}

TEST_F(TextLinkTest, AGroupThatIsStoppedSaysItsStopAndThenNothing) {
  Server server;
  open(link(server.endpoint(), {{"stop", std::string("LAND %q")}}));
  ASSERT_TRUE(server.accept());
  hear_height(server, "1.00");
  ASSERT_TRUE(drive(2, 2));
  server.until("{Left 2.00}");
  ASSERT_TRUE(drives->stop());
  EXPECT_THAT(server.until("LAND 5\r\n"), HasSubstr("LAND 1\r\nLAND 2\r\nLAND 3\r\nLAND 4\r\nLAND 5\r\n"));
}

TEST_F(TextLinkTest, TheLastWordOfALinkThatGoesEndsWhatItBegan) {
  Server server;
  open(link(server.endpoint()));
  ASSERT_TRUE(server.accept());
  hear_height(server, "1.00");
  ASSERT_TRUE(drive(2, 2));
  server.until("{Left 2.00}");
  board.reset();
  EXPECT_THAT(server.until("<never>"), HasSubstr("DRIVE {Left 0.00} {Right 0.00}\r\n<gone>"));
}

TEST_F(TextLinkTest, ACutConnectionIsAGoneDeviceAndComesBack) {
  Server server;
  open(link(server.endpoint()));
  ASSERT_TRUE(server.accept());
  hear_height(server, "1.00");
  server.cut();
  EXPECT_TRUE(is_closed());
  EXPECT_TRUE(eventually([&] { return drive(1, 1).error().code == hal::Errc::closed; }));
  EXPECT_THAT(complaints(), HasSubstr("drone: "));
  ASSERT_TRUE(server.accept());
  EXPECT_THAT(server.until("\r\n"), HasSubstr("INIT {Name R1}\r\n"));
  hear_height(server, "3.00");
  EXPECT_EQ(heard.connections, 2u);
  EXPECT_TRUE(eventually([&] { return drive(1, 1).has_value(); }));
  EXPECT_TRUE(eventually([&] { return complaints().find("connection") == std::string::npos; }));
}

TEST_F(TextLinkTest, HalfALineIsNotGoneOnWithInTheNextConnection) {
  Server server;
  open(link(server.endpoint()));
  ASSERT_TRUE(server.accept());
  hear_height(server, "1.00");
  server.say("SEN {Type GroundTruth} {Location 1.2");
  std::this_thread::sleep_for(50ms);
  server.cut();
  ASSERT_TRUE(server.accept());
  server.say("0,2.50,9.99}\r\n");
  hear_height(server, "4.00");
  EXPECT_GE(heard.torn, 2u) << "the cut line, and the end without a beginning";
}

TEST_F(TextLinkTest, GarbageIsCountedAndTheDeviceGoesStaleUntilMessagesAreBack) {
  Server server;
  open(link(server.endpoint()));
  ASSERT_TRUE(server.accept());
  hear_height(server, "1.00");
  std::string garbage;
  for (int i = 0; i < 5000; ++i) garbage += static_cast<char>(i * 37 % 255 + 1);
  server.say(garbage);
  EXPECT_TRUE(is_closed());
  server.say("\r\n");
  hear_height(server, "2.00");
  EXPECT_GT(heard.torn, 0u);
}

TEST_F(TextLinkTest, SilenceIsAGoneDeviceAlthoughTheConnectionStands) {
  Server server;
  open(link(server.endpoint()));
  ASSERT_TRUE(server.accept());
  hear_height(server, "1.00");
  EXPECT_TRUE(is_closed());
  EXPECT_TRUE(eventually([&] { return complaints().find("nothing comes in") != std::string::npos; }));
  EXPECT_EQ(drive(1, 1).error().code, hal::Errc::closed);
  hear_height(server, "2.00");
}

TEST_F(TextLinkTest, ASilentConnectionIsMadeAnew) {
  Server server;
  open(link(server.endpoint(), {{"reconnect_ms", 400.0}}));
  ASSERT_TRUE(server.accept());
  hear_height(server, "1.00");
  ASSERT_TRUE(server.accept()) << "it connects again by itself";
}

TEST_F(TextLinkTest, ValuesThatNeverCameAreNamed) {
  Server server;
  open(link(server.endpoint()));
  ASSERT_TRUE(server.accept());
  EXPECT_TRUE(eventually([&] {
    server.say("SEN {Type GroundTruth} {Location 1.20,2.50,1.00}\r\n");
    return complaints().find("never came: front") != std::string::npos;
  }));
}

std::string text_of(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

TEST_F(TextLinkTest, TheCapturedSessionGivesTheValuesThatAltUrisFileNames) {
  std::string session = sinew::test::source_dir() + "/../shared/data/usarsim/airrobot_session.txt";
  if (!std::filesystem::exists(session))
    session = sinew::test::source_dir() + "/../../shared/data/usarsim/airrobot_session.txt";
  if (!std::filesystem::exists(session)) GTEST_SKIP() << "shared/data/usarsim is not beside the checkout";
  Server server;
  DeviceSpecs specs;
  specs.devices.push_back(text_table("drone", "text", {}));
  std::vector<rt::Problem> problems;
  read_alturi_ini(text_of(sinew::test::source_dir() + "/robots/air_robot/airrobot.ini"), specs.devices[0], problems);
  EXPECT_TRUE(problems.empty());
  specs.devices[0].keys["to"] = {server.endpoint(), 0};
  board = std::make_unique<DeviceBoard>(specs, all_drivers(), *connectors, hal::system_os());
  values = *board->sensor<msg::TextValues>("drone");
  ASSERT_TRUE(server.accept());
  const std::string text = text_of(session);
  for (std::size_t at = 0; at < text.size(); at += 97) {  // pieces that end anywhere
    server.say(text.substr(at, 97));
    while (values->read(heard).has_value() && *values->read(heard)) {
    }
  }
  server.say("\r\nSTA {Battery 7}\r\n");
  ASSERT_TRUE(wait_for(values, heard, [](const msg::TextValues& m) { return m.value[0] == 7; }));
  EXPECT_EQ(heard.count, 4u);
  EXPECT_EQ(heard.lines, 77u) << "the session's 76, and the last";
  EXPECT_EQ(heard.torn, 9u);
  EXPECT_EQ(heard.value[1], 1.2);
  EXPECT_EQ(heard.value[2], 2.5);
  EXPECT_EQ(heard.value[3], 2.05);
  EXPECT_EQ(heard.known, 15u);
}

// ---- UDP

class Peer {
 public:
  Peer() : fd_(socket(AF_INET, SOCK_DGRAM, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    bind(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof address);
    socklen_t size = sizeof address;
    getsockname(fd_, reinterpret_cast<sockaddr*>(&address), &size);
    port = ntohs(address.sin_port);
    const timeval patience{10, 0};
    setsockopt(fd_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
  }
  ~Peer() { close(fd_); }
  std::string read() {
    std::array<char, 1500> text{};
    socklen_t size = sizeof from_;
    const ssize_t n = recvfrom(fd_, text.data(), text.size(), 0, reinterpret_cast<sockaddr*>(&from_), &size);
    return n < 0 ? "<nothing>" : std::string(text.data(), static_cast<std::size_t>(n));
  }
  std::string until(std::string_view what) {
    for (int i = 0; i < 1000; ++i)
      if (std::string text = read(); text.find(what) != std::string::npos || text == "<nothing>") return text;
    return "<never>";
  }
  void say(std::string_view text) {
    sendto(fd_, text.data(), text.size(), 0, reinterpret_cast<const sockaddr*>(&from_), sizeof from_);
  }
  std::uint16_t port = 0;

 private:
  int fd_;
  sockaddr_in from_{};
};

std::uint16_t free_port() { return Peer().port; }

TEST_F(TextLinkTest, UdpGreetsUntilItIsAnsweredAndADatagramEndsItsLine) {
  Peer peer;
  open(link(
      "udp:127.0.0.1:" + std::to_string(peer.port),
      {{"port", std::int64_t{free_port()}}, {"decoder", std::string("usarsim")}, {"line_end", std::string("none")}}));
  EXPECT_EQ(peer.read(), "INIT {Name R1}");
  EXPECT_EQ(peer.read(), "INIT {Name R1}") << "again after a second without an answer";
  peer.say("SEN {Type GroundTruth} {Location 1.20,2.50,1.50}");
  ASSERT_TRUE(wait_for(values, heard, [](const msg::TextValues& m) { return m.value[0] == 1.5; }));
  ASSERT_TRUE(drive(1, 2));
  EXPECT_EQ(peer.until("DRIVE"), "DRIVE {Left 1.00} {Right 2.00}");
  EXPECT_TRUE(is_closed()) << "silence";
  peer.say("SEN {Type GroundTruth} {Location 1.20,2.50");
  peer.say("SEN {Type GroundTruth} {Location 1.20,2.50,2.50}");
  ASSERT_TRUE(wait_for(values, heard, [](const msg::TextValues& m) { return m.value[0] == 2.5; }));
  EXPECT_EQ(heard.torn, 1u);
}

// ---- the tables

std::vector<std::string> problems_of(DeviceSpec spec) {
  DeviceSpecs specs;
  specs.devices.push_back(std::move(spec));
  std::vector<std::string> all;
  for (const rt::Problem& p : check_devices(specs, all_drivers())) all.push_back(rt::to_string(p, "r.toml"));
  return all;
}

TEST_F(TextLinkTest, WrongTablesAreNamedWithWhatIsAllowed) {
  DeviceSpec spec = link("tcp:host", {{"prefix", std::string("DRIVE %n ")}, {"state_port", std::int64_t{5}}});
  spec.drives[0].keys["text"] = {std::string("{Left %1.2f %1.2f}"), 7};
  spec.drives[1].keys["min"] = {9.0, 8};
  spec.messages[0].keys["where"] = {std::string("Type"), 9};
  spec.messages[1].name = "height";
  spec.commands[0].keys["text"] = {std::string("%s"), 10};
  const auto all = problems_of(std::move(spec));
  EXPECT_THAT(
      all, ::testing::IsSupersetOf(
               {HasSubstr("device.drone.to: "), HasSubstr("device.drone.state_port: "),
                HasSubstr("r.toml:7: device.drone.drive.Left.text: "), HasSubstr("device.drone.drive.Right.max: "),
                HasSubstr("r.toml:9: device.drone.message.height.where: "), HasSubstr("device.drone.message.height: "),
                HasSubstr("r.toml:10: device.drone.command.zoom.text: ")}));
}

TEST_F(TextLinkTest, TablesOfALinkBelongToNoOtherDriver) {
  DeviceSpec spec = text_table("imu", "published", {});
  spec.messages.push_back(text_table("height", "", {}));
  EXPECT_THAT(problems_of(std::move(spec)), ::testing::ElementsAre(HasSubstr("only the driver text has such tables")));
}

TEST(TextSpec, DegreesAndMinutesAreDegrees) {
  TextValue latitude;
  latitude.key = "Latitude";
  latitude.as = TextValue::As::degrees_minutes;
  wire::UsarLine line;
  ASSERT_EQ(wire::parse_usarsim("SEN {Type GPS} {Latitude 47,40.50,S} {Fix 1}", line), wire::UsarError::none);
  EXPECT_DOUBLE_EQ(*find_value(latitude, line, false), -47.675);
  ASSERT_EQ(wire::parse_usarsim("SEN {Type GPS} {Latitude 47,40.50} {Fix 1}", line), wire::UsarError::none);
  EXPECT_EQ(find_value(latitude, line, false), std::nullopt);
}

TEST(TextSpec, WordsAreNumbers) {
  TextValue touch;
  touch.key = "Status", touch.words = {"Open", "Closed"};
  wire::UsarLine line;
  ASSERT_EQ(wire::parse_usarsim("SEN {Status Closed}", line), wire::UsarError::none);
  EXPECT_EQ(find_value(touch, line, false), 1.0);
  ASSERT_EQ(wire::parse_usarsim("SEN {Status Jammed}", line), wire::UsarError::none);
  EXPECT_EQ(find_value(touch, line, false), std::nullopt);
}

}  // namespace
}  // namespace sinew::drivers::text_link_test
