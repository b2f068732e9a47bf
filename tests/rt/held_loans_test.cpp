// Slots that a driver holds over its steps: docs/decisions/0010-held-loans.md.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <deque>
#include <random>
#include <thread>

#include "counting_new.hpp"
#include "rt/exec/module_rig.hpp"
#include "topic_fixture.hpp"

namespace sinew::rt::held_loans_test {
namespace {

using std::chrono_literals::operator""ms;
using testing::ElementsAre;

/// One raw topic whose writer may hold slots; connect() before start().
struct HeldTopic {
  static constexpr std::uint32_t kHeld = 3, kBurst = 2;
  HeldTopic() {
    writer = plan.add_writer("camera.raw");
    topic = plan.add_topic(
        writer, {.name = "camera.raw", .type = &msg::type_info<Pair>(), .burst = kBurst, .held = kHeld, .history = 2});
  }
  void start() {
    segment = std::make_unique<Segment>(plan);
    commit = std::make_unique<Commit>(*segment, writer);
    commit->bind(raw, 0);
  }
  Pair& hold(std::uint32_t number) {
    Pair* held = raw.hold();
    EXPECT_NE(held, nullptr);
    fill(*held, number);
    return *held;
  }
  void publish(Pair& held) {
    EXPECT_TRUE(raw.publish(held));
    EXPECT_EQ(commit->commit({}), 1u);
  }
  static void fill(Pair& pair, std::uint32_t number) {
    pair.number = number;
    pair.value.fill(number);
  }
  static bool whole(const Pair& pair) {
    return std::all_of(pair.value.begin(), pair.value.end(), [&](double v) { return v == pair.number; });
  }

  SegmentPlan plan{SegmentOptions{kNearWrap, 16}};
  WriterId writer;
  TopicId topic;
  std::unique_ptr<Segment> segment;
  std::unique_ptr<Commit> commit;
  Raw<Pair> raw;
};

struct HeldLoans : testing::Test, HeldTopic {};

TEST_F(HeldLoans, AreCountedInTheSlotsOfTheTopic) {
  const SlotSum sum = plan.slots(topic);
  EXPECT_EQ(sum.held, kHeld);
  EXPECT_EQ(sum.total(), kBurst + kHeld + 2);
}

TEST_F(HeldLoans, ReaderSeesTheHeldSlotItselfWhereverItRuns) {
  for (const bool same_thread : {false, true}) {
    HeldTopic t;
    const auto c = t.plan.connect(t.topic, latest(same_thread));
    t.start();
    In<Pair> in;
    Latch latch(*t.segment);
    latch.bind(in, c);
    Pair& held = t.hold(7);
    {
      Latched step(latch);
      EXPECT_EQ(in.get(), nullptr) << "held is not published";
    }
    t.publish(held);
    Latched step(latch);
    EXPECT_EQ(in.get(), &held);
    EXPECT_EQ(in.get()->number, 7u);
  }
}

TEST_F(HeldLoans, AreNoMoreThanWereAskedForAndEachComesBackOnce) {
  start();
  Pair &a = hold(1), &b = hold(2);
  hold(3);
  EXPECT_EQ(raw.hold(), nullptr);
  raw.put_back(a);
  EXPECT_EQ(commit->held(0), 2u);
  EXPECT_EQ(raw.hold(), &a) << "what was put back is the first to go out again";
  publish(b);
  EXPECT_NE(raw.hold(), nullptr);
  EXPECT_EQ(raw.hold(), nullptr);
}

TEST_F(HeldLoans, TakeTheirTurnAmongLoansAndShareTheirBurst) {
  const auto c = plan.connect(topic, drop_oldest(8));
  start();
  InQueue<Pair> queue;
  Latch latch(*segment);
  latch.bind(queue, c);
  Pair &second = hold(2), &third = hold(3);
  fill(*raw.loan(), 1);
  EXPECT_TRUE(raw.publish(second));
  EXPECT_FALSE(raw.publish(third)) << "the burst is used up";
  EXPECT_EQ(commit->held(0), 1u) << "and it is still held";
  commit->commit({});
  EXPECT_TRUE(raw.publish(third));
  fill(*raw.loan(), 4);
  commit->commit({});
  Latched step(latch);
  EXPECT_THAT(numbers(queue), ElementsAre(1, 2, 3, 4));
}

TEST_F(HeldLoans, DiscardedCommitGivesThemBackUnpublished) {
  const auto c = plan.connect(topic, latest());
  start();
  In<Pair> in;
  Latch latch(*segment);
  latch.bind(in, c);
  for (std::uint32_t round = 0; round < 20; ++round) {
    Pair &a = hold(1), &b = hold(2);
    ASSERT_TRUE(raw.publish(a) && raw.publish(b));
    commit->discard();
    ASSERT_EQ(commit->held(0), 0u);
  }
  Latched step(latch);
  EXPECT_EQ(in.get(), nullptr);
}

TEST_F(HeldLoans, PublishingNeverRunsDryWhileEverythingIsHeldAndNothingHeldIsTouched) {
  const auto l = plan.connect(topic, latest()), q = plan.connect(topic, drop_oldest(3));
  const auto n = plan.connect(topic, drop_newest(4));
  start();
  std::uint32_t number = 0;
  const auto publish_loans = [&](std::uint32_t count) {
    for (std::uint32_t i = 0; i < count; ++i) {
      fill(*raw.loan(), ++number);
      commit->commit({});
    }
  };
  In<Pair> in;
  InQueue<Pair> queue, newest;
  Latch latch(*segment), queue_latch(*segment);
  latch.bind(in, l);
  latch.bind(newest, n);
  queue_latch.bind(queue, q);
  publish_loans(4);
  Latched reader(latch);
  publish_loans(3);
  Latched queue_reader(queue_latch);
  std::vector<Pair*> held;
  for (std::uint32_t i = 0; i < kHeld; ++i) {
    held.push_back(&hold(1000 + i));
    publish_loans(1);
  }
  publish_loans(100);
  for (std::uint32_t i = 0; i < kHeld; ++i) {
    EXPECT_EQ(held[i]->number, 1000 + i);
    EXPECT_TRUE(whole(*held[i]));
  }
  for (const Pair& p : queue) EXPECT_TRUE(whole(p));
  EXPECT_EQ(in.get()->number, 4u);
}

TEST_F(HeldLoans, AnyOrderOfHoldingPublishingAndPuttingBackShowsReadersWhatWasPublishedOnly) {
  const auto c = plan.connect(topic, drop_oldest(2)), s = plan.connect(topic, latest(true));
  start();
  InQueue<Pair> queue;
  In<Pair> same;
  Latch latch(*segment), same_latch(*segment);
  latch.bind(queue, c);
  same_latch.bind(same, s);
  std::mt19937 random(7);
  std::vector<Pair*> held;
  std::deque<std::uint32_t> published;
  std::uint32_t number = 0;
  for (std::uint32_t round = 0; round < 20'000; ++round) {
    const auto pick = [&] {
      const std::size_t at = random() % held.size();
      Pair* p = held[at];
      held.erase(held.begin() + static_cast<std::ptrdiff_t>(at));
      return p;
    };
    switch (random() % 4) {
      case 0:
        if (Pair* p = raw.hold()) {
          fill(*p, 0xFFFF'0000);  // as a device that is still writing
          held.push_back(p);
        }
        break;
      case 1:
        if (!held.empty()) raw.put_back(*pick());
        break;
      default: {
        std::uint32_t loans = 0;
        while (loans < kBurst && random() % 2 == 0) {
          Pair* p = held.empty() || random() % 3 == 0 ? raw.loan() : pick();
          fill(*p, ++number);
          if (std::uint32_t before = commit->held(0); commit->loans(0) == loans) {  // it was held
            ASSERT_TRUE(raw.publish(*p));
            ASSERT_EQ(commit->held(0), before - 1);
          }
          ++loans;
        }
        const bool discards = random() % 8 == 0;
        if (discards)
          commit->discard();
        else
          commit->commit({});
        for (std::uint32_t i = 0; i < loans && !discards; ++i) published.push_back(number - loans + 1 + i);
      }
    }
    ASSERT_EQ(commit->held(0), held.size());
    if (random() % 3 != 0) continue;
    Latched step(latch);
    Latched same_step(same_latch);
    for (const Pair& p : queue) {
      while (!published.empty() && published.front() < p.number) published.pop_front();  // dropped
      ASSERT_FALSE(published.empty());
      ASSERT_EQ(p.number, published.front());
      ASSERT_TRUE(whole(p));
      published.pop_front();
    }
    ASSERT_TRUE(published.empty()) << "the newest is among what is held";
    if (number && same.get()) {
      ASSERT_TRUE(whole(*same.get()));
    }
  }
  EXPECT_GT(number, 5'000u);
}

TEST_F(HeldLoans, MessageThatIsNotHeldIsABugNotAMessage) {
  start();
  Pair& held = hold(1);
  publish(held);
  EXPECT_DEATH(raw.put_back(held), "camera.raw: publishes or puts back a message that it does not hold");
  Pair stranger;
  EXPECT_DEATH(static_cast<void>(raw.publish(stranger)), "does not hold");
}

TEST_F(HeldLoans, HoldingAndPublishingAllocatesNothing) {
  plan.connect(topic, latest());
  start();
  const std::uint64_t before = test::allocations();
  for (std::uint32_t i = 0; i < 100; ++i) {
    Pair *a = raw.hold(), *b = raw.hold();
    raw.put_back(*a);
    static_cast<void>(raw.publish(*b));
    commit->commit({});
  }
  EXPECT_EQ(test::allocations(), before);
}

TEST_F(HeldLoans, ReadersInOtherThreadsNeverSeeAHeldSlotChange) {
  constexpr std::uint32_t kMessages = 20'000;
  const auto c1 = plan.connect(topic, latest()), c2 = plan.connect(topic, drop_oldest(3));
  start();
  std::atomic<bool> done{false};
  std::atomic<std::uint32_t> torn{0}, seen{0};
  const auto read = [&](ConnectionId id) {
    InQueue<Pair> queue;
    In<Pair> in;
    Latch latch(*segment);
    if (id == c1)
      latch.bind(in, id);
    else
      latch.bind(queue, id);
    std::uint32_t last = 0;
    const auto look = [&](const Pair& p) {
      if (!whole(p) || p.number < last) ++torn;
      if (p.number != last) ++seen;
      last = p.number;
    };
    while (!done.load()) {
      Latched step(latch);
      if (in.get()) look(*in.get());
      for (const Pair& p : queue) look(p);
    }
  };
  std::thread first(read, c1), second(read, c2);
  std::deque<Pair*> filling;
  for (std::uint32_t n = 1; n <= kMessages; ++n) {
    while (Pair* p = raw.hold()) {
      fill(*p, 0xFFFF'0000 + n);
      filling.push_back(p);
    }
    fill(*filling.front(), n);
    EXPECT_TRUE(raw.publish(*filling.front()));
    filling.pop_front();
    commit->commit({});
  }
  while (seen.load() == 0) std::this_thread::yield();
  done = true;
  first.join(), second.join();
  EXPECT_EQ(torn, 0u);
}

// ---- in the life of a module

/// Lends two slots to a device that never fills them, and one that it fills at once.
class Holder final : public DriverModule {
 public:
  void declare(Declaration& d) override { d.raw("raw", raw_, {.burst = 1}); }
  hal::Status configure(Setup& setup) override {
    setup.hold(raw_, 2);
    return hal::Status();
  }
  void collect(Time) noexcept override {
    while (Pair* p = raw_.hold()) held_.push_back(p);
    if (!publishes) return;
    HeldTopic::fill(*held_.front(), ++number_);
    published = held_.front();
    static_cast<void>(raw_.publish(*held_.front()));
    held_.erase(held_.begin());
  }
  void rest(Time) noexcept override {
    ++rests;
    put_back();
  }
  void end() noexcept override {
    if (tidy) put_back();
  }
  StepStatus step(const Step&) noexcept override { return raw_.empty() ? StepStatus::stale : StepStatus::ok; }
  std::size_t held() const { return held_.size(); }

  bool publishes = true, tidy = true;
  std::uint32_t rests = 0;
  const Pair* published = nullptr;

 private:
  void put_back() {
    for (Pair* p : held_) raw_.put_back(*p);
    held_.clear();
  }
  Raw<Pair> raw_;
  std::vector<Pair*> held_;
  std::uint32_t number_ = 0;
};

TEST(HeldLoansOfAModule, AreAskedForInConfigureAndGoOnFromStepToStep) {
  Holder holder;
  ModuleRig rig(holder);
  for (std::uint32_t n = 1; n <= 100; ++n) {
    ASSERT_EQ(rig.step(Time{n}, 1ms), StepStatus::ok);
    ASSERT_EQ(rig.get<Pair>("raw"), holder.published);
    ASSERT_EQ(rig.get<Pair>("raw")->number, n);
  }
  EXPECT_EQ(holder.rests, 0u);
}

TEST(HeldLoansOfAModule, GoBackWhenItIsSwitchedOffAndOutAgainAfterwards) {
  Holder holder;
  holder.publishes = false;
  ModuleRig rig(holder);
  EXPECT_EQ(rig.step(Time{1}, 1ms), StepStatus::stale);
  EXPECT_EQ(holder.held(), 2u);
  rig.rest(Time{2}), rig.rest(Time{3});
  EXPECT_EQ(holder.rests, 2u);
  EXPECT_EQ(holder.held(), 0u);
  holder.publishes = true;
  EXPECT_EQ(rig.step(Time{4}, 1ms), StepStatus::ok);
}

TEST(HeldLoansOfAModule, LeftBehindAtTheEndAreABugOfTheModule) {
  EXPECT_DEATH(
      {
        Holder holder;
        ModuleRig rig(holder);
        static_cast<void>(rig.step(Time{1}, 1ms));
        holder.tidy = false;
      },
      "still holds slots of its raw topic after end\\(\\)");
}

}  // namespace
}  // namespace sinew::rt::held_loans_test
