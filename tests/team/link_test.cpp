// Robots that hear each other through an air that loses, delays, repeats and reorders, each with a clock of its own.
#include "team/link.hpp"

#include <gtest/gtest.h>

#include <deque>
#include <map>
#include <set>

#include "math/hash.hpp"
#include "math/random.hpp"
#include "msg/cdr.hpp"
#include "msg/flight.hpp"
#include "msg/operator.hpp"
#include "msg/ros2msg.hpp"
#include "rt/exec/module_rig.hpp"

namespace sinew::team::link_test {
namespace {

using namespace std::chrono_literals;
using hal::Duration;
using hal::Time;
using Heard = msg::FromMate<msg::OperatorLink>;

constexpr std::int64_t kPeriodNs = 20'000'000;

/// A clock as a function of true time.
struct OwnClock {
  std::int64_t offset_ns = 0, drift_ppm = 0;
  Time at(std::int64_t true_ns) const { return Time{true_ns + offset_ns + true_ns / 1'000'000 * drift_ppm}; }
};

/// What the air puts into a robot, and takes out of it.
class FakeRadio final : public hal::EmptyBoard, public hal::Radio {
 public:
  hal::Result<hal::Radio*> radio(std::string_view name) override {
    if (name != "radio") return hal::Error{hal::Errc::not_found, "radio"};
    return static_cast<hal::Radio*>(this);
  }
  Time ready_at() const noexcept override { return {}; }
  void set_wake(hal::Wake*) noexcept override {}
  hal::Result<bool> read(msg::Datagram& out) noexcept override {
    if (arrived.empty()) return false;
    out = arrived.front();
    arrived.pop_front();
    return true;
  }
  hal::Status send(std::span<const std::uint8_t> bytes) noexcept override {
    sent.emplace_back(bytes.begin(), bytes.end());
    return {};
  }
  hal::RadioStats stats() const noexcept override { return {}; }

  std::deque<msg::Datagram> arrived;
  std::vector<std::vector<std::uint8_t>> sent;
};

msg::Datagram datagram(std::span<const std::uint8_t> bytes, Time stamp) {
  msg::Datagram d;
  d.stamp = stamp;
  d.size = static_cast<std::uint32_t>(bytes.size());
  std::copy(bytes.begin(), bytes.end(), d.data.begin());
  return d;
}

/// A robot that says "op.link" and hears that of all mates, and of one mate by name.
struct Robot {
  Robot(std::uint16_t number, OwnClock its, LinkOptions options)
      : robot(number), clock(its), link(std::move(options)), rig(link, {.board = &radio}) {
    rig.carries<msg::OperatorLink>("say_op_link");
    rig.carries<Heard>("mates/op.link");
    rig.carries<msg::OperatorLink>("ant/op.link");
  }
  /// One step at true time `t`. With a message whose sequence is the number of the step.
  void step(std::int64_t t) {
    const Time now = clock.at(t);
    if (speaks) {
      msg::OperatorLink message;
      message.stamp = now - 3ms;
      message.sequence = ++steps;
      true_stamp[steps] = t - 3'000'000;
      rig.put("say_op_link", message);
    }
    EXPECT_EQ(rig.step(now, Duration(kPeriodNs)), rt::StepStatus::ok);
    if (const auto* told = rig.get<msg::TeamState>("state")) state = *told;
  }

  /// Steps without hearing or saying anything more, until its state tells all that was heard before.
  std::int64_t settle(std::int64_t t) {
    speaks = false;
    for (int i = 0; i < 12; ++i, t += kPeriodNs) {
      step(t);
      EXPECT_TRUE(rig.all<Heard>("mates/op.link").empty() || i == 0);
    }
    return t;
  }

  std::uint16_t robot;
  OwnClock clock;
  FakeRadio radio;
  Link link;
  rt::ModuleRig rig;
  msg::TeamState state;
  bool speaks = true;
  std::uint32_t steps = 0;
  std::map<std::uint32_t, std::int64_t> true_stamp;  // of the messages that it said
};

LinkOptions options_of(std::uint16_t robot) {
  LinkOptions o;
  o.robot = robot;
  o.team = 7;
  o.bytes_per_s = 100'000;
  for (const auto& [name, number] : std::map<std::string, std::uint16_t>{{"ant", 1}, {"bee", 2}, {"cat", 3}})
    if (number != robot) o.mates.push_back({name, number});
  o.said = {{"op.link", 25, 0}};
  o.heard = {"mates/op.link", "ant/op.link"};
  return o;
}

/// All robots hear all others.
struct Air {
  struct OnTheWay {
    std::int64_t at;
    std::size_t to;
    std::vector<std::uint8_t> bytes;
  };
  explicit Air(std::uint64_t seed) : random(seed) {}

  /// What was sent at true time `t` arrives later, or never, or twice.
  void carry(std::vector<Robot*> robots, std::int64_t t) {
    for (std::size_t from = 0; from < robots.size(); ++from) {
      for (const auto& bytes : robots[from]->radio.sent)
        for (std::size_t to = 0; to < robots.size(); ++to) {
          if (to == from) continue;
          const int copies = random.uniform() < loss ? 0 : random.uniform() < twice ? 2 : 1;
          for (int c = 0; c < copies; ++c)
            flying.push_back({t + delay_ns + static_cast<std::int64_t>(random.uniform() * jitter_ns), to, bytes});
        }
      robots[from]->radio.sent.clear();
    }
  }
  void deliver(std::vector<Robot*> robots, std::int64_t t) {
    std::stable_sort(flying.begin(), flying.end(), [](const auto& a, const auto& b) { return a.at < b.at; });
    while (!flying.empty() && flying.front().at <= t) {
      Robot& to = *robots[flying.front().to];
      to.radio.arrived.push_back(datagram(flying.front().bytes, to.clock.at(flying.front().at)));
      flying.pop_front();
    }
  }

  math::Random random;
  double loss = 0, twice = 0;
  std::int64_t delay_ns = 2'000'000;
  double jitter_ns = 0;
  std::deque<OnTheWay> flying;
};

/// Runs robots from one true time to another; `look` after each step of each.
template <class Look>
void run(std::vector<Robot*> robots, Air& air, std::int64_t from, std::int64_t to, Look look) {
  for (std::int64_t t = from; t < to; t += kPeriodNs) {
    air.deliver(robots, t);
    for (Robot* r : robots) {
      r->step(t);
      look(*r);
    }
    air.carry(robots, t);
  }
}

constexpr std::int64_t kSecond = 1'000'000'000;

class ATeam : public ::testing::Test {
 protected:
  Robot ant{1, {3 * kSecond, 0}, options_of(1)};
  Robot bee{2, {7200 * kSecond, 80}, options_of(2)};
  Robot cat{3, {-1 * kSecond, -60}, options_of(3)};
  std::vector<Robot*> all{&ant, &bee, &cat};
  Air air{5};
};

TEST_F(ATeam, MessagesOfMatesCarryTheirSenderAndAreOnTheOwnClockWithinTheirBound) {
  air.loss = 0.3, air.delay_ns = 20'000'000, air.jitter_ns = 150e6;
  std::map<std::uint32_t, int> from;
  run(all, air, 10 * kSecond, 60 * kSecond, [&](Robot& r) {
    for (const Heard* heard : r.rig.all<Heard>("mates/op.link")) {
      Robot& said = *all[heard->robot - 1];
      ASSERT_NE(&said, &r);
      const Time truth = r.clock.at(said.true_stamp.at(heard->message.sequence));
      const Duration wrong = heard->stamp - truth;
      EXPECT_LE(std::abs(wrong.count()), heard->stamp_bound_ns + 2000)
          << "the clock of this test drifts in steps of 1 ms";
      EXPECT_EQ(heard->message.stamp, heard->stamp);
      EXPECT_LE(heard->stamp, heard->received);
      ++from[heard->robot];
    }
  });
  for (const std::uint32_t robot : {1u, 2u, 3u}) EXPECT_GT(from[robot], 500);
  for (const msg::MateState& mate : {bee.state.mate[0], bee.state.mate[1]}) {
    EXPECT_GT(mate.lost, 100u);
    EXPECT_GT(mate.reordered, 100u);
    EXPECT_LT(mate.clock_bound_ns, 60'000'000) << "the fastest of the exchanges decide";
  }
}

TEST_F(ATeam, DriftOfClocksIsFoundAndTheTrueOffsetIsWithinTheBound) {
  run(all, air, 10 * kSecond, 40 * kSecond, [](Robot&) {});
  ASSERT_EQ(bee.state.mate[0].robot, 1u);
  ASSERT_EQ(bee.state.mate[1].robot, 3u);
  EXPECT_NEAR(bee.state.mate[0].clock_drift, 80e-6, 5e-6);
  EXPECT_NEAR(bee.state.mate[1].clock_drift, 140e-6, 5e-6);
  for (const msg::MateState& mate : {bee.state.mate[0], bee.state.mate[1]}) {
    const std::int64_t true_ns = mate.heard.ns - bee.clock.at(40 * kSecond).ns + 40 * kSecond;  // to a few microseconds
    const Duration offset = mate.heard - all[mate.robot - 1]->clock.at(true_ns);
    EXPECT_LE(std::abs(offset.count() - mate.clock_offset_ns), mate.clock_bound_ns + 100'000);
    EXPECT_LT(mate.clock_bound_ns, 25'000'000) << "a step of 20 ms, and the air's 2 ms twice";
  }
}

TEST_F(ATeam, NothingGoesBackAndNothingComesTwice) {
  air.loss = 0.1, air.twice = 0.4, air.jitter_ns = 200e6;
  std::map<std::uint32_t, std::uint32_t> last;
  run(all, air, 10 * kSecond, 40 * kSecond, [&](Robot& r) {
    if (&r != &bee) return;
    for (const Heard* heard : r.rig.all<Heard>("mates/op.link")) {
      EXPECT_GT(heard->message.sequence, last[heard->robot]);
      last[heard->robot] = heard->message.sequence;
    }
  });
  EXPECT_GT(bee.state.mate[0].duplicated, 100u);
  EXPECT_GT(bee.state.mate[0].dropped, 100u);
}

TEST_F(ATeam, OneMatesTopicHoldsItsNewestMessageOfAStep) {
  int heard = 0;
  run(all, air, 10 * kSecond, 20 * kSecond, [&](Robot& r) {
    const auto of_ant = r.rig.all<msg::OperatorLink>("ant/op.link");
    ASSERT_LE(of_ant.size(), 1u);
    if (&r == &ant) {
      EXPECT_TRUE(of_ant.empty()) << "its own messages do not come back";
    }
    if (of_ant.empty()) return;
    ++heard;
    EXPECT_EQ(ant.true_stamp.count(of_ant[0]->sequence), 1u);
  });
  EXPECT_GT(heard, 300);
}

TEST_F(ATeam, UntilTheClockOfAMateIsKnownItsMessagesAreCountedAndNotPublished) {
  bee.rig.step(bee.clock.at(9 * kSecond), 20ms);
  Robot deaf{1, {}, options_of(1)};  // hears nobody, so that nobody learns its clock
  for (std::int64_t t = 10 * kSecond; t < 12 * kSecond; t += kPeriodNs) {
    deaf.step(t);
    for (const auto& bytes : deaf.radio.sent) bee.radio.arrived.push_back(datagram(bytes, bee.clock.at(t + 1'000'000)));
    deaf.radio.sent.clear();
    bee.step(t);
    EXPECT_TRUE(bee.rig.all<Heard>("mates/op.link").empty());
  }
  EXPECT_GT(bee.state.mate[0].unclocked, 20u);
  EXPECT_EQ(bee.state.mate[0].clock_bound_ns, -1);
  EXPECT_EQ(bee.state.mate[0].messages, 0u);
}

TEST_F(ATeam, AMateThatStartsAnewIsHeardAgainAndItsFormerFramesAreNot) {
  run(all, air, 10 * kSecond, 15 * kSecond, [](Robot&) {});
  const auto old_frames = [&] {
    ant.step(15 * kSecond);
    return ant.radio.sent;
  }();
  Robot again{1, {90 * kSecond, 0}, options_of(1)};  // another clock, sequences from the beginning
  std::vector<Robot*> now{&again, &bee, &cat};
  air.flying.clear();
  int heard = 0;
  run(now, air, 16 * kSecond, 20 * kSecond, [&](Robot& r) {
    if (&r != &bee) return;
    for (const Heard* h : r.rig.all<Heard>("mates/op.link")) {
      if (h->robot != 1) continue;
      ++heard;
      EXPECT_LE(std::abs((h->stamp - bee.clock.at(again.true_stamp.at(h->message.sequence))).count()),
                h->stamp_bound_ns + 2000);
    }
  });
  EXPECT_EQ(bee.state.mate[0].starts, 2u);
  EXPECT_GT(heard, 60);
  const std::int64_t later = bee.settle(20 * kSecond);
  const std::uint32_t frames = bee.state.mate[0].frames;
  ASSERT_FALSE(old_frames.empty());
  for (const auto& bytes : old_frames) bee.radio.arrived.push_back(datagram(bytes, bee.clock.at(later)));
  bee.settle(later);
  EXPECT_EQ(bee.state.mate[0].starts, 2u) << "a late frame of before the restart is no third start";
  EXPECT_EQ(bee.state.mate[0].frames, frames);
}

/// A frame of `head` with one message of "op.link".
std::vector<std::uint8_t> frame_of(const wire::TeamHead& head, std::uint32_t hash, std::span<const std::uint8_t> cdr) {
  std::vector<std::uint8_t> bytes(msg::kMaxDatagramBytes);
  wire::TeamWriter frame(bytes, head);
  EXPECT_TRUE(frame.add(wire::TeamMessage{"op.link", hash, 1'000'000, 5, cdr}));
  bytes.resize(frame.finish().size());
  return bytes;
}

TEST_F(ATeam, JunkStrangersAndOtherBuildsAreNamedAndNeverMisread) {
  run(all, air, 10 * kSecond, 12 * kSecond, [](Robot&) {});
  const std::int64_t t = bee.settle(12 * kSecond);
  const auto& type = msg::type_info<msg::OperatorLink>();
  const auto hash = static_cast<std::uint32_t>(math::fnv1a64(msg::ros2msg_schema(type)));
  std::vector<std::uint8_t> cdr(100);
  const msg::OperatorLink message;
  cdr.resize(msg::cdr_encode(type, &message, cdr));
  const wire::TeamHead as_ant{1, bee.state.mate[0].start, bee.state.mate[0].sequence + 1, 0, 7};
  const Time now = bee.clock.at(t);
  const msg::TeamState before = bee.state;
  const auto arrives = [&](wire::TeamHead head, std::uint32_t h, std::span<const std::uint8_t> c) {
    bee.radio.arrived.push_back(datagram(frame_of(head, h, c), now));
  };
  arrives(as_ant, hash ^ 1, cdr);  // another definition of the type
  arrives({1, as_ant.start, as_ant.sequence + 1, 0, 7}, hash, std::span(cdr).first(cdr.size() - 1));  // cut
  arrives({1, as_ant.start, as_ant.sequence + 2, 0, 8}, hash, cdr);                                   // another team
  arrives({9, 1, 1, 0, 7}, hash, cdr);                                                                // nobody we know
  const std::array<std::uint8_t, 40> junk{1, 2, 3};
  bee.radio.arrived.push_back(datagram(junk, now));
  bee.radio.arrived.push_back(datagram({}, now));
  bee.step(t);
  EXPECT_TRUE(bee.rig.all<Heard>("mates/op.link").empty());
  bee.settle(t + kPeriodNs);
  EXPECT_EQ(bee.state.mate[0].foreign, before.mate[0].foreign + 1);
  EXPECT_EQ(bee.state.mate[0].dropped, before.mate[0].dropped + 1);
  EXPECT_EQ(bee.state.other_teams, before.other_teams + 1);
  EXPECT_EQ(bee.state.strangers, before.strangers + 1);
  EXPECT_EQ(bee.state.last_stranger, 9u);
  EXPECT_EQ(bee.state.garbage, before.garbage + 2);
}

TEST_F(ATeam, FramesWithAnyBytesChangedHarmNothing) {
  run(all, air, 10 * kSecond, 12 * kSecond, [](Robot&) {});
  std::vector<std::vector<std::uint8_t>> frames;
  for (std::int64_t t = 12 * kSecond; t < 13 * kSecond; t += kPeriodNs) {
    ant.step(t);
    frames.insert(frames.end(), ant.radio.sent.begin(), ant.radio.sent.end());
    ant.radio.sent.clear();
  }
  math::Random random(3);
  const auto below = [&](std::size_t n) { return static_cast<std::size_t>(random.uniform() * static_cast<double>(n)); };
  for (std::int64_t t = 13 * kSecond; t < 60 * kSecond; t += kPeriodNs) {
    for (int i = 0; i < 4; ++i) {
      std::vector<std::uint8_t> bytes = frames[below(frames.size())];
      for (std::size_t changes = below(4); changes > 0; --changes)
        bytes[below(bytes.size())] = static_cast<std::uint8_t>(below(256));
      if (below(4) == 0) bytes.resize(below(bytes.size() + 1));
      bee.radio.arrived.push_back(datagram(bytes, bee.clock.at(t)));
    }
    bee.step(t);
    for (const Heard* heard : bee.rig.all<Heard>("mates/op.link")) {
      EXPECT_TRUE(heard->robot == 1 || heard->robot == 3);
      EXPECT_LE(heard->stamp, heard->received);
    }
  }
  EXPECT_GT(bee.state.garbage, 1000u);
}

/// What a robot sends in 20 s that says a small and a large topic, in this budget.
struct Speech {
  explicit Speech(double bytes_per_s) {
    LinkOptions o = options_of(1);
    o.heard.clear();
    o.bytes_per_s = bytes_per_s;
    o.said = {{"nav.state", 50, 1}, {"op.link", 10, 5}};
    FakeRadio radio;
    Link link(o);
    rt::ModuleRig rig(link, {.board = &radio});
    rig.carries<msg::NavState>("say_nav_state");
    rig.carries<msg::OperatorLink>("say_op_link");
    for (std::int64_t t = kPeriodNs; t < 20 * kSecond; t += kPeriodNs) {
      msg::NavState nav;
      nav.stamp = Time{t};
      msg::OperatorLink op;
      op.stamp = Time{t};
      rig.put("say_nav_state", nav);
      rig.put("say_op_link", op);
      EXPECT_EQ(rig.step(Time{t}, Duration(kPeriodNs)), rt::StepStatus::ok);
      std::size_t bytes = 0;
      for (const auto& frame : radio.sent) {
        bytes += frame.size();
        wire::TeamReader reader;
        EXPECT_EQ(reader.open(frame), nullptr);
        while (const auto message = reader.next()) {
          ++messages[std::string(message->topic)];
          EXPECT_LE(t - message->stamp_ns, 0) << "the newest message goes, however long its topic waited";
        }
      }
      EXPECT_LE(radio.sent.size(), 1u);
      radio.sent.clear();
      sent.push_back(bytes);
      if (const auto* told = rig.get<msg::TeamState>("state")) starved = told->starved;
    }
    for (std::size_t from = 0; from < sent.size(); ++from)
      for (std::size_t to = from, sum = 0; to < sent.size(); ++to) {
        sum += sent[to];
        const double allowed = msg::kMaxDatagramBytes +
                               bytes_per_s * 1e-9 * static_cast<double>(kPeriodNs) * static_cast<double>(to - from + 1);
        most_over = std::max(most_over, static_cast<double>(sum) - allowed);
      }
  }
  std::map<std::string, int> messages;
  std::vector<std::size_t> sent;
  double most_over = -1e9;
  std::uint32_t starved = 0;
};

TEST(TeamBudget, IsNeverExceededAndTheHigherPriorityGoesFirst) {
  const Speech rich(100'000);
  EXPECT_NEAR(rich.messages.at("op.link"), 200, 2);
  EXPECT_GT(rich.messages.at("nav.state"), 970);
  EXPECT_EQ(rich.starved, 0u);
  const Speech poor(2'000);
  EXPECT_LE(poor.most_over, 0);
  EXPECT_NEAR(poor.messages.at("op.link"), 200, 2) << "it is small, and goes before the other";
  EXPECT_LT(poor.messages.at("nav.state"), 200);
  EXPECT_GT(poor.messages.at("nav.state"), 10);
  EXPECT_GT(poor.starved, 10u);
}

TEST(TeamCost, IsWhatAFrameGetsLonger) {
  const Said said{"nav.state", 10, 0};
  const auto& type = msg::type_info<msg::NavState>();
  const msg::NavState message;
  std::vector<std::uint8_t> cdr(1000), bytes(msg::kMaxDatagramBytes);
  cdr.resize(msg::cdr_encode(type, &message, cdr));
  wire::TeamWriter frame(bytes, {.robot = 1});
  const std::size_t before = frame.finish().size();
  ASSERT_TRUE(frame.add(wire::TeamMessage{said.topic, 1, 1, 0, cdr}));
  const SaidCost cost = cost_of(said, type);
  EXPECT_EQ(cost.message_bytes, frame.finish().size() - before);
  EXPECT_EQ(cost.bytes_per_s, 10.0 * static_cast<double>(cost.message_bytes));
}

}  // namespace
}  // namespace sinew::team::link_test
