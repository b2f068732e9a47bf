#include "drivers/game/game_controller.hpp"

#include <gmock/gmock.h>

#include <deque>

#include "../no_connectors.hpp"
#include "drivers/board/device_board.hpp"
#include "drivers/board/driver_list.hpp"
#include "hal/platform.hpp"

namespace sinew::drivers::game_controller_test {
namespace {

using namespace std::chrono_literals;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using wire::GameAnswer;
using wire::GameLayout;
using wire::GamePacket;

constexpr std::uint32_t kTable = 0x0A000001;  // where the game controller runs: 10.0.0.1
using Sent = std::pair<hal::UdpAddress, std::vector<std::uint8_t>>;

/// What came in, and what was said to whom.
struct Ether {
  std::deque<msg::Datagram> in;
  std::vector<Sent> out;
  hal::RadioSpec spec;
  bool broken = false;
};

class EtherRadio final : public hal::Radio, public hal::SelfReport {
 public:
  explicit EtherRadio(Ether& ether) : ether_(ether) {}
  hal::Time ready_at() const noexcept override { return ether_.in.empty() ? hal::kNever : hal::Time{}; }
  void set_wake(hal::Wake*) noexcept override {}
  hal::Result<bool> read(msg::Datagram& out) noexcept override {
    if (ether_.in.empty()) return false;
    out = ether_.in.front();
    ether_.in.pop_front();
    return true;
  }
  hal::Status send(std::span<const std::uint8_t>) noexcept override { return {}; }
  hal::Status send_to(const hal::UdpAddress& to, std::span<const std::uint8_t> bytes) noexcept override {
    ether_.out.emplace_back(to, std::vector<std::uint8_t>(bytes.begin(), bytes.end()));
    return {};
  }
  hal::RadioStats stats() const noexcept override { return {}; }
  std::string trouble() const override { return ether_.broken ? "UDP port 3838: sending fails" : ""; }

 private:
  Ether& ether_;
};

class EtherConnectors final : public test::NoConnectors {
 public:
  hal::Result<std::unique_ptr<hal::Radio>> radio(const hal::RadioSpec& spec, std::string&) override {
    ether.spec = spec;
    return std::unique_ptr<hal::Radio>(std::make_unique<EtherRadio>(ether));
  }
  Ether ether;
};

GamePacket game(GameLayout layout = GameLayout::humanoid_soccer) {
  GamePacket p;
  p.layout = layout;
  p.state = msg::GamePhase::playing;
  p.team[0].number = 12, p.team[1].number = 34;
  return p;
}

/// A robot's device, and a clock that stands still.
class GameControllerTest : public ::testing::Test {
 protected:
  void hear(const std::vector<std::uint8_t>& bytes, std::uint32_t sender = kTable) {
    msg::Datagram d;
    d.stamp = clock_.now(), d.sender = sender, d.port = 5000;
    d.size = static_cast<std::uint32_t>(bytes.size());
    std::copy(bytes.begin(), bytes.end(), d.data.begin());
    ether_.in.push_back(d);
  }
  void hear(const GamePacket& packet, std::uint32_t sender = kTable) {
    std::vector<std::uint8_t> bytes(wire::kGameMostBytes);
    bytes.resize(wire::write_game_packet(packet, bytes));
    hear(bytes, sender);
  }
  bool read() {
    const auto got = device_.read(said_);
    EXPECT_TRUE(got);
    return got && *got;
  }
  void wait(hal::Duration d) { clock_.set(clock_.now() + d); }

  hal::ManualClock clock_;
  Ether ether_;
  GameController device_{std::make_unique<EtherRadio>(ether_), clock_, {.team = 12, .player = 3}};
  msg::RefereeState said_;
};

TEST_F(GameControllerTest, APacketAboutTheOwnTeamIsWhatTheRefereeSays) {
  EXPECT_FALSE(read());
  EXPECT_EQ(device_.ready_at(), hal::kNever);
  GamePacket p = game();
  p.team[0].score = 2, p.team[0].player[2].penalty = 9, p.team[0].player[2].seconds_left = 30;
  hear(p);
  EXPECT_LE(device_.ready_at(), clock_.now());
  const hal::Time came = clock_.now();
  wait(5ms);
  ASSERT_TRUE(read());
  EXPECT_EQ(said_.stamp, came);
  EXPECT_EQ(said_.phase, msg::GamePhase::playing);
  EXPECT_EQ(said_.own_goals, 2u);
  EXPECT_EQ(said_.penalty, msg::GamePenalty::pushing);
  EXPECT_EQ(said_.penalty_left_s, 30);
  EXPECT_FALSE(read());
}

TEST_F(GameControllerTest, TheOtherLeaguesPacketsAreHeardAndAnsweredInTheirOwnWay) {
  hear(game(GameLayout::humanoid));
  ASSERT_TRUE(read());
  ASSERT_EQ(ether_.out.size(), 1u);
  EXPECT_EQ(ether_.out[0].first, (hal::UdpAddress{kTable, 3939}));
  EXPECT_THAT(ether_.out[0].second, ElementsAre('R', 'G', 'r', 't', 2, 12, 3, 2));
  wait(1s);
  hear(game(GameLayout::humanoid_soccer));
  ASSERT_TRUE(read());
  GameAnswer answer;
  ASSERT_EQ(ether_.out.size(), 2u);
  ASSERT_EQ(wire::read_game_answer(ether_.out[1].second, answer), nullptr);
  EXPECT_EQ(answer.layout, GameLayout::humanoid_soccer);
  EXPECT_EQ(answer.team, 12);
  EXPECT_EQ(answer.player, 3);
  EXPECT_LT(answer.ball_age_s, 0) << "it does not know the ball";
}

TEST_F(GameControllerTest, OtherGamesAndJunkArePassedOverAndNotAnswered) {
  GamePacket others = game();
  others.team[0].number = 13;
  hear(others, kTable + 1);
  hear({1, 2, 3});
  hear(game());
  hear(others, kTable + 1);
  ASSERT_TRUE(read()) << "one read goes past what is not for this robot";
  EXPECT_FALSE(read());
  ASSERT_EQ(ether_.out.size(), 1u);
  EXPECT_EQ(ether_.out[0].first.ipv4, kTable);
}

TEST_F(GameControllerTest, SaysTwiceASecondThatItIsThereAlsoWhenAPacketIsLost) {
  hear(game());
  ASSERT_TRUE(read());
  for (int i = 0; i < 400; ++i) {  // 4 s, of which only the first 2 s bring packets, five a second
    wait(10ms);
    if (i < 200 && i % 20 == 0) hear(game());
    static_cast<void>(read());
  }
  EXPECT_EQ(ether_.out.size(), 9u);
}

TEST_F(GameControllerTest, AnswersEndWhenTheGameControllerIsGone) {
  hear(game());
  ASSERT_TRUE(read());
  wait(GameController::kAnswers + 1ms);
  EXPECT_FALSE(read());
  EXPECT_EQ(ether_.out.size(), 1u);
  hear(game());
  ASSERT_TRUE(read());
  EXPECT_EQ(ether_.out.size(), 2u);
}

TEST_F(GameControllerTest, AFloodOfJunkEndsARead) {
  for (int i = 0; i < 1000; ++i) hear({0});
  EXPECT_FALSE(read());
  EXPECT_EQ(ether_.in.size(), 936u);
}

TEST_F(GameControllerTest, ComplainsInWordsAboutWhatItHearsInstead) {
  EXPECT_EQ(device_.trouble(), "");
  wait(GameController::kSilent + 1ms);
  EXPECT_EQ(device_.trouble(), "hears no game controller on UDP port 3838");
  std::vector<std::uint8_t> newer(200, 0);
  for (std::size_t i = 0; i < 4; ++i) newer[i] = static_cast<std::uint8_t>("RGme"[i]);
  newer[4] = 20;
  hear(newer);
  EXPECT_FALSE(read());
  EXPECT_EQ(device_.trouble(),
            "hears no game controller of team 12, but on its port comes: a version other than 12 and 19");
  GamePacket others = game();
  others.team[0].number = 13;
  hear(others);
  EXPECT_FALSE(read());
  EXPECT_EQ(device_.trouble(), "hears only the game of the teams 13 and 34, and is in team 12");
  hear(game());
  EXPECT_TRUE(read());
  EXPECT_EQ(device_.trouble(), "");
  ether_.broken = true;
  EXPECT_EQ(device_.trouble(), "UDP port 3838: sending fails");
  wait(GameController::kSilent + 1ms);
  EXPECT_EQ(device_.trouble(), "UDP port 3838: sending fails\nhears no game controller on UDP port 3838");
}

TEST_F(GameControllerTest, APlayerThatTheVersionDoesNotHaveIsSaid) {
  GameController device(std::make_unique<EtherRadio>(ether_), clock_, {.team = 12, .player = 12});
  wait(GameController::kSilent + 1ms);
  hear(game(GameLayout::humanoid));
  const auto got = device.read(said_);
  ASSERT_TRUE(got);
  EXPECT_FALSE(*got);
  EXPECT_EQ(device.trouble(), "the game controller's version 12 has no player 12");
}

DeviceSpec referee(std::int64_t team, std::int64_t player) {
  DeviceSpec spec;
  spec.name = "referee", spec.driver = "gamecontroller", spec.line = 1;
  spec.keys["team"] = {rt::ParamValue{team}, 2};
  spec.keys["player"] = {rt::ParamValue{player}, 3};
  return spec;
}

TEST(GameControllerDriver, IsTheRefereeOfARobotFileAndListensOnItsPort) {
  EtherConnectors connectors;
  DeviceSpecs specs;
  specs.devices = {referee(12, 3)};
  ASSERT_THAT(check_devices(specs, all_drivers()), IsEmpty());
  DeviceBoard board(specs, all_drivers(), connectors, hal::system_os());
  const auto device = board.sensor<msg::RefereeState>("referee");
  ASSERT_TRUE(device) << board.problem();
  EXPECT_TRUE(connectors.ether.spec.listens);
  EXPECT_EQ(connectors.ether.spec.port, 3838);
}

TEST(GameControllerDriver, NamesWhatItsKeysMayBe) {
  const auto texts = [](const DeviceSpec& spec) {
    DeviceSpecs specs;
    specs.devices = {spec};
    std::vector<std::string> out;
    for (const auto& p : check_devices(specs, all_drivers())) out.push_back(rt::to_string(p, "r.toml"));
    return out;
  };
  EXPECT_THAT(texts(referee(0, 3)), ElementsAre("r.toml:2: device.referee.team: 0: an integer from 1 to 254"));
  EXPECT_THAT(texts(referee(12, 21)), ElementsAre("r.toml:3: device.referee.player: 21: an integer from 1 to 20"));
  DeviceSpec bare = referee(12, 3);
  bare.keys.clear();
  EXPECT_THAT(texts(bare), ElementsAre(HasSubstr("team"), HasSubstr("player")));
}

}  // namespace
}  // namespace sinew::drivers::game_controller_test
