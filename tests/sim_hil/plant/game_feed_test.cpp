#include "sim_hil/plant/game_feed.hpp"

#include <gmock/gmock.h>
#include <unistd.h>

#include "drivers/game/game_controller.hpp"
#include "hal/can_waiting.hpp"
#include "hal/linux/udp_radio.hpp"
#include "hal/platform.hpp"
#include "sim_hil/worlds/json_object.hpp"

namespace sinew::plant::game_feed_test {
namespace {

using namespace std::chrono_literals;
using msg::GameKick;
using msg::GamePenalty;
using msg::GamePhase;

/// A robot that only hears a referee.
class Listener final : public SimRobot {
 public:
  const Due& due() const override { return due_; }
  WorldTruth ground_truth() const override { return {}; }
  Scene scene(std::size_t) const override { return {}; }
  bool still() const override { return true; }
  void add_to(JsonObject&) const override {}
  Verdict verdict() const override { return {}; }
  std::string outcome() const override { return ""; }
  void say(const msg::RefereeState& said) { due_.referee = true, due_.referee_sample = said; }
  void say_nothing() { due_.referee = false; }

 private:
  Due due_;
};

/// Two blue robots and a red one.
class Field final : public World {
 public:
  Field() {
    for (std::size_t i = 0; i < 3; ++i) {
      said[i].team = i == 2 ? 1 : 0, said[i].attacks_right = i == 2 ? 0 : 1;
      said[i].half = 1, said[i].left_s = 599.2, said[i].phase = GamePhase::playing;
    }
  }
  void advance(std::span<const RobotCommand>) override {}
  msg::Time now() const override { return {}; }
  std::size_t robots() const override { return 3; }
  SimRobot& robot(std::size_t number) override { return listeners_[number]; }
  void say() {
    for (std::size_t i = 0; i < 3; ++i) listeners_[i].say(said[i]);
  }
  void say_nothing() {
    for (Listener& l : listeners_) l.say_nothing();
  }
  std::array<msg::RefereeState, 3> said{};

 private:
  std::array<Listener, 3> listeners_;
};

/// Keeps the last packet.
class Kept final : public hal::Radio {
 public:
  hal::Time ready_at() const noexcept override { return hal::kNever; }
  void set_wake(hal::Wake*) noexcept override {}
  hal::Result<bool> read(msg::Datagram&) noexcept override { return false; }
  hal::Status send(std::span<const std::uint8_t> bytes) noexcept override {
    EXPECT_EQ(wire::read_game_packet(bytes, packet), nullptr);
    ++packets;
    return {};
  }
  hal::RadioStats stats() const noexcept override { return {}; }
  wire::GamePacket packet;
  int packets = 0;
};

msg::RefereeState heard(const wire::GamePacket& packet, std::uint8_t team, std::uint8_t player) {
  msg::RefereeState out;
  EXPECT_TRUE(wire::said_by_packet(packet, team, player, out));
  return out;
}

TEST(GameFeed, EachRobotHearsFromThePacketWhatTheRefereeSaidToIt) {
  for (const auto layout : {wire::GameLayout::humanoid, wire::GameLayout::humanoid_soccer}) {
    Kept radio;
    Field field;
    GameFeed feed(radio, {layout, {12, 34}}, 3);
    for (auto& said : field.said) said.own_goals = 1;
    field.said[2].own_goals = 1, field.said[2].kick = GameKick::own;
    field.said[0].kick = field.said[1].kick = GameKick::other;
    for (auto& said : field.said) said.other_goals = 1;
    field.said[1].penalty = GamePenalty::pushing, field.said[1].penalty_left_s = 12.5;
    field.say();
    feed.step(field);
    ASSERT_EQ(radio.packets, 1);
    const struct { std::uint8_t team, player; } who[] = {{12, 1}, {12, 2}, {34, 1}};
    for (std::size_t i = 0; i < 3; ++i) {
      const msg::RefereeState got = heard(radio.packet, who[i].team, who[i].player), &said = field.said[i];
      EXPECT_EQ(got.phase, said.phase);
      EXPECT_EQ(got.penalty, said.penalty);
      EXPECT_EQ(got.kick, said.kick);
      EXPECT_EQ(got.half, said.half);
      EXPECT_EQ(got.own_goals, said.own_goals);
      EXPECT_EQ(got.other_goals, said.other_goals);
      EXPECT_EQ(got.team, said.team);
      EXPECT_EQ(got.attacks_right, said.attacks_right);
      EXPECT_EQ(got.left_s, 600) << "whole seconds, what has begun counts";
      EXPECT_EQ(got.penalty_left_s, i == 1 ? 13 : 0);
    }
    EXPECT_EQ(radio.packet.players_per_team, 2);
  }
}

TEST(GameFeed, TheTeamsChangeTheirPlacesWithTheSides) {
  Kept radio;
  Field field;
  GameFeed feed(radio, {.teams = {12, 34}}, 3);
  for (auto& said : field.said) said.attacks_right = 1 - said.attacks_right, said.half = 2;
  field.said[0].own_goals = field.said[1].own_goals = 3, field.said[2].other_goals = 3;
  field.say();
  feed.step(field);
  EXPECT_EQ(radio.packet.team[0].number, 34);
  EXPECT_EQ(heard(radio.packet, 34, 1).attacks_right, 1u);
  EXPECT_EQ(heard(radio.packet, 12, 1).attacks_right, 0u);
  EXPECT_EQ(heard(radio.packet, 12, 2).own_goals, 3u);
  EXPECT_EQ(heard(radio.packet, 34, 1).other_goals, 3u);
  EXPECT_EQ(heard(radio.packet, 12, 1).half, 2u);
}

TEST(GameFeed, APacketGoesOutWhenTheRefereeSpeaks) {
  Kept radio;
  Field field;
  GameFeed feed(radio, {}, 3);
  field.say();
  feed.step(field);
  field.say_nothing();
  for (int i = 0; i < 100; ++i) feed.step(field);
  EXPECT_EQ(radio.packets, 1);
  field.say();
  feed.step(field);
  EXPECT_EQ(radio.packets, 2);
  EXPECT_EQ(radio.packet.number, 1);
}

std::unique_ptr<hal::Radio> opened(const hal::RadioSpec& spec) {
  std::string why;
  auto radio = hal::UdpRadio::open(spec, hal::system_os(), why);
  EXPECT_TRUE(radio) << why;
  return radio ? std::move(*radio) : nullptr;
}

TEST(GameFeed, ARobotsDriverHearsItOverTheLoopbackInterfaceAndAnswers) {
  // Tests run beside each other: each process has ports of its own.
  const auto port = static_cast<std::uint16_t>(20000 + 2 * (getpid() % 10000));
  const auto answers = static_cast<std::uint16_t>(port + 1);
  hal::RadioSpec far, near;
  far.peers = {{0x7FFFFFFF, port}}, far.port = answers;
  near.listens = true, near.port = port;
  const auto radio = opened(far);
  auto first = opened(near), second = opened(near);
  ASSERT_TRUE(radio && first && second);
  drivers::GameControllerConfig config{.team = 12, .player = 2, .port = port, .answer_port = answers};
  drivers::GameController blue(std::move(first), hal::system_os(), config);
  config.team = 34, config.player = 1;
  drivers::GameController red(std::move(second), hal::system_os(), config);
  Field field;
  GameFeed feed(*radio, {.teams = {12, 34}}, 3);
  field.said[1].penalty = GamePenalty::incapable;
  msg::RefereeState to_blue, to_red;
  const bool both = hal::eventually([&] {
    field.say();
    feed.step(field);
    const auto b = blue.read(to_blue), r = red.read(to_red);
    return feed.answers(0, 2) > 0 && feed.answers(1, 1) > 0 && b && r;
  });
  ASSERT_TRUE(both) << feed.text();
  EXPECT_EQ(to_blue.penalty, GamePenalty::incapable);
  EXPECT_EQ(to_blue.team, 0u);
  EXPECT_EQ(to_red.penalty, GamePenalty::none);
  EXPECT_EQ(to_red.team, 1u);
  EXPECT_EQ(feed.answers(0, 1), 0u);
  EXPECT_EQ(feed.others(), 0u);
  EXPECT_THAT(feed.text(),
              ::testing::MatchesRegex("game controller: [0-9]+ packets sent; answers of team 12: 0 of robot "
                                      "1, [0-9]+ of robot 2; answers of team 34: [0-9]+ of robot 1"));
}

}  // namespace
}  // namespace sinew::plant::game_feed_test
