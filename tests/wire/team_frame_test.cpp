#include "wire/team_frame.hpp"

#include <gmock/gmock.h>

#include <array>
#include <random>
#include <string>
#include <vector>

namespace sinew::wire::team_frame_test {
namespace {

using Bytes = std::vector<std::uint8_t>;

constexpr TeamHead kHead{.robot = 3, .start = 0xA1B2C3D4, .sequence = 7, .sent_ns = -5, .team = 42};
constexpr TeamEcho kEcho{.robot = 9, .start = 0x01020304, .sequence = 6, .sent_ns = 1'000'000'007, .received_ns = 12};
const Bytes kCdr{0, 1, 0, 0, 0xDE, 0xAD};

TeamMessage message(std::string_view topic, std::span<const std::uint8_t> cdr = kCdr) {
  return {.topic = topic, .type_hash = 0xCAFE0001, .sequence = 0xFFFFFFFF, .stamp_ns = 123, .cdr = cdr};
}

Bytes written(const TeamHead& head, std::vector<TeamEcho> echoes, const std::vector<TeamMessage>& messages) {
  Bytes buffer(1200);
  TeamWriter frame(buffer, head);
  for (const TeamEcho& e : echoes) EXPECT_TRUE(frame.add(e));
  for (const TeamMessage& m : messages) EXPECT_TRUE(frame.add(m));
  const auto all = frame.finish();
  return {all.begin(), all.end()};
}

std::string refused(std::span<const std::uint8_t> bytes) {
  TeamReader frame;
  const char* why = frame.open(bytes);
  return why ? why : "";
}

TEST(TeamFrame, HasTheBytesOfItsPage) {
  const Bytes expected{'S',  'N',  'W',  'T',  1,    1,    1,    0,              // magic, version, counts
                       3,    0,    0,    0,    42,   0,    0,    0,              // robot, team
                       0xD4, 0xC3, 0xB2, 0xA1, 7,    0,    0,    0,              // start, sequence
                       0xFB, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF,           // sent
                       9,    0,    4,    3,    2,    1,    6,    0,    0,    0,  // echo: robot, start, sequence
                       7,    0xCA, 0x9A, 0x3B, 0,    0,    0,    0,    12,   0,    0,    0,
                       0,    0,    0,    0,                                               // sent, received
                       4,    6,    0,    1,    0,    0xFE, 0xCA, 0xFF, 0xFF, 0xFF, 0xFF,  // lengths, type, sequence
                       123,  0,    0,    0,    0,    0,    0,    0,    'b',  'a',  'l',  'l',  // stamp, topic
                       0,    1,    0,    0,    0xDE, 0xAD};
  EXPECT_EQ(written(kHead, {kEcho}, {message("ball")}), expected);
}

TEST(TeamFrame, WhatIsReadIsWhatWasWritten) {
  const Bytes other{0, 1, 0, 0};
  const Bytes bytes = written(kHead, {kEcho, {.robot = 65535}}, {message("ball.model"), message("x", other)});
  TeamReader frame;
  ASSERT_EQ(frame.open(bytes), nullptr);
  EXPECT_EQ(frame.head().robot, 3);
  EXPECT_EQ(frame.head().team, 42u);
  EXPECT_EQ(frame.head().start, 0xA1B2C3D4u);
  EXPECT_EQ(frame.head().sequence, 7u);
  EXPECT_EQ(frame.head().sent_ns, -5);
  ASSERT_EQ(frame.echoes(), 2u);
  EXPECT_EQ(frame.echo(0).start, kEcho.start);
  EXPECT_EQ(frame.echo(0).sent_ns, kEcho.sent_ns);
  EXPECT_EQ(frame.echo(0).received_ns, kEcho.received_ns);
  EXPECT_EQ(frame.echo(1).robot, 65535);
  EXPECT_EQ(frame.messages(), 2u);
  auto first = frame.next();
  ASSERT_TRUE(first);
  EXPECT_EQ(first->topic, "ball.model");
  EXPECT_EQ(first->type_hash, 0xCAFE0001u);
  EXPECT_EQ(first->sequence, 0xFFFFFFFFu);
  EXPECT_EQ(first->stamp_ns, 123);
  EXPECT_THAT(first->cdr, ::testing::ElementsAreArray(kCdr));
  auto second = frame.next();
  ASSERT_TRUE(second);
  EXPECT_EQ(second->cdr.size(), 4u);
  EXPECT_FALSE(frame.next());
}

TEST(TeamFrame, WhatDoesNotFitIsLeftOutAndTheFrameStaysWhole) {
  for (std::size_t room = 0; room < 140; ++room) {
    Bytes buffer(room, 0xEE);
    TeamWriter frame(buffer, kHead);
    const bool echo = frame.add(kEcho), one = frame.add(message("ball")), two = frame.add(message("pad"));
    const auto all = frame.finish();
    EXPECT_EQ(all.empty(), room < kTeamHeadBytes);
    EXPECT_EQ(echo, room >= kTeamHeadBytes + kTeamEchoBytes);
    if (all.empty()) continue;
    EXPECT_EQ(frame.empty(), !one && !two);
    EXPECT_EQ(refused(all), "") << room;
  }
}

TEST(TeamFrame, NothingIsWrittenThatNoReaderTakes) {
  Bytes buffer(70'000);
  TeamWriter frame(buffer, kHead);
  EXPECT_FALSE(frame.add(TeamEcho{.robot = 0}));
  EXPECT_FALSE(frame.add(message("")));
  EXPECT_FALSE(frame.add(message(std::string(kTeamMostTopicBytes + 1, 'a'))));
  EXPECT_FALSE(frame.add(message("two words")));
  EXPECT_FALSE(frame.add(message("b\xC3\xA4ll")));
  EXPECT_FALSE(frame.add(message("ball", Bytes(3))));
  EXPECT_FALSE(frame.add(message("ball", Bytes(65536))));
  EXPECT_FALSE(frame.add(TeamEcho{.robot = 1, .sent_ns = kTeamMostNs + 1}));
  EXPECT_FALSE(frame.add(TeamEcho{.robot = 1, .received_ns = -kTeamMostNs - 1}));
  TeamMessage late = message("ball");
  late.stamp_ns = kTeamMostNs + 1;
  EXPECT_FALSE(frame.add(late));
  for (std::size_t i = 0; i < kTeamMostEchoes; ++i) EXPECT_TRUE(frame.add(kEcho));
  EXPECT_FALSE(frame.add(kEcho));
  for (std::size_t i = 0; i < kTeamMostMessages; ++i) EXPECT_TRUE(frame.add(message("ball")));
  EXPECT_FALSE(frame.add(message("ball")));
  EXPECT_FALSE(frame.add(kEcho)) << "echoes are in front";
  EXPECT_EQ(refused(frame.finish()), "");
  TeamWriter nobody(buffer, {.robot = 0});
  EXPECT_FALSE(nobody.add(message("ball")));
  EXPECT_TRUE(nobody.finish().empty());
  EXPECT_TRUE(TeamWriter(buffer, {.robot = 1, .sent_ns = -kTeamMostNs - 1}).finish().empty());
}

TEST(TeamFrame, EveryFrameThatWasCutOrHasMoreIsRefused) {
  const Bytes whole = written(kHead, {kEcho}, {message("ball.model"), message("x")});
  for (std::size_t size = 0; size < whole.size(); ++size) EXPECT_NE(refused(std::span(whole).first(size)), "") << size;
  Bytes more = whole;
  more.push_back(0);
  EXPECT_EQ(refused(more), "more bytes than messages");
}

TEST(TeamFrame, SaysWhyItIsNone) {
  const Bytes whole = written(kHead, {kEcho}, {message("ball")});
  const auto changed = [&](std::size_t at, std::uint8_t to) {
    Bytes bytes = whole;
    bytes[at] = to;
    return refused(bytes);
  };
  EXPECT_EQ(changed(0, 'X'), "no team frame");
  EXPECT_EQ(changed(4, 2), "another version of the team protocol");
  EXPECT_EQ(changed(5, 16), "too many echoes");
  EXPECT_EQ(changed(6, 2), "ends within a message");
  EXPECT_EQ(changed(7, 1), "a reserved byte is not 0");
  EXPECT_EQ(changed(8, 0), "no robot has the number 0");
  EXPECT_EQ(changed(11, 1), "a reserved byte is not 0");
  EXPECT_EQ(changed(31, 0x20), "an instant that cannot be");
  EXPECT_EQ(changed(kTeamHeadBytes + 17, 0x40), "an instant that cannot be");
  EXPECT_EQ(changed(kTeamHeadBytes + 25, 0xDF), "an instant that cannot be");
  EXPECT_EQ(changed(kTeamHeadBytes + kTeamEchoBytes + 18, 0x7F), "an instant that cannot be");
  EXPECT_EQ(changed(kTeamHeadBytes, 0), "no robot has the number 0");
  EXPECT_EQ(changed(kTeamHeadBytes + kTeamEchoBytes + kTeamMessageBytes, ' '), "a topic's name that cannot be");
  EXPECT_EQ(changed(kTeamHeadBytes + kTeamEchoBytes + 1, 3), "a message without content");
}

TEST(TeamFrame, AnyBytesAreReadOrRefusedAndNothingIsReadBehindThem) {
  std::mt19937 random(5);
  const Bytes whole = written(kHead, {kEcho, kEcho}, {message("ball.model"), message("x")});
  int taken = 0;
  for (int i = 0; i < 20'000; ++i) {
    Bytes bytes = whole;
    for (int k = static_cast<int>(random() % 4); k >= 0; --k)
      bytes[random() % bytes.size()] = static_cast<std::uint8_t>(random());
    bytes.resize(random() % 3 == 0 ? random() % (whole.size() + 1) : whole.size());
    bytes.shrink_to_fit();  // so that a sanitizer sees a read behind it
    TeamReader frame;
    if (frame.open(bytes)) continue;
    ++taken;
    std::size_t messages = 0;
    for (std::size_t e = 0; e < frame.echoes(); ++e) static_cast<void>(frame.echo(e));
    while (frame.next()) ++messages;
    EXPECT_EQ(messages, frame.messages());
  }
  EXPECT_GT(taken, 100) << "most of it is content";
}

}  // namespace
}  // namespace sinew::wire::team_frame_test
