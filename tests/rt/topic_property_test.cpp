// Topics against a plain model of what they promise, slots under the worst readers, and no allocation.
#include <gtest/gtest.h>

#include <deque>
#include <random>

#include "counting_new.hpp"
#include "topic_fixture.hpp"

namespace sinew::rt::topic_property_test {
namespace {

TEST(TopicProperty, NoAllocationAfterConstruction) {
  TwoOutputs t(3);
  const auto c1 = t.plan.connect(t.a_topic, latest()), c2 = t.plan.connect(t.a_topic, drop_oldest(4)),
             c3 = t.plan.connect(t.b_topic, drop_newest(4)), c4 = t.plan.connect(t.b_topic, latest(true));
  t.start();
  In<Pair> in1, in4;
  InQueue<Pair> in2, in3;
  Latch latch(*t.segment);
  latch.bind(in1, c1);
  latch.bind(in2, c2);
  latch.bind(in3, c3);
  latch.bind(in4, c4);
  const std::uint64_t before = test::allocations();
  std::uint32_t seen = 0;
  for (std::uint32_t n = 0; n < 1000; ++n) {
    t.a.loan().number = n;
    t.a.loan().number = n;
    t.b.loan().number = n;
    n % 7 ? static_cast<void>(t.commit->commit({})) : t.commit->discard();
    Latched step(latch);
    for (const Pair& p : in2) seen += p.number <= n;
    for (const Pair& p : in3) seen += p.number <= n;
    std::int64_t origins[kMaxChains];
    latch.merge_origins(origins);
  }
  EXPECT_EQ(test::allocations(), before);
  EXPECT_EQ(seen, 3 * (1000U - 143U));
}

/// Everybody holds as much as the plan allows, all of different messages: two latest readers, a queue, a drop-newest
/// queue, the history of the tap, and the writer a full burst.
struct WorstCase : testing::Test {
  WorstCase() {
    SegmentPlan plan(SegmentOptions{kNearWrap, 16});
    const WriterId w = plan.add_writer("w");
    topic = plan.add_topic(w, {.name = "w.a", .type = &msg::type_info<Pair>(), .burst = 2, .history = 5});
    l1 = plan.connect(topic, latest());
    l2 = plan.connect(topic, latest());
    q = plan.connect(topic, drop_oldest(3));
    n = plan.connect(topic, drop_newest(4));
    sum = plan.slots(topic);
    segment = std::make_unique<Segment>(plan);
    commit = std::make_unique<Commit>(*segment, w);
    commit->bind(out, 0);
  }
  void publish(std::uint32_t count) {
    for (std::uint32_t i = 0; i < count; ++i) {
      out.loan().number = ++number;
      commit->commit({});
    }
  }
  TopicId topic = 0;
  ConnectionId l1, l2, q, n;
  SlotSum sum;
  std::unique_ptr<Segment> segment;
  std::unique_ptr<Commit> commit;
  Out<Pair> out;
  std::uint32_t number = 0;
};

TEST_F(WorstCase, SumOfSlotsIsWhatEachMayHold) {
  EXPECT_EQ(sum.burst, 2U);
  EXPECT_EQ(sum.keep, 5U);
  EXPECT_EQ(sum.pins, 1U + 1U + 3U);
  EXPECT_EQ(sum.pending, 4U);
  EXPECT_EQ(segment->entry(topic).slot_count, 16U);
}

TEST_F(WorstCase, WriterNeverRunsOutOfSlots) {
  In<Pair> in1, in2;
  InQueue<Pair> queue;
  Latch first(*segment), second(*segment), third(*segment);
  first.bind(in1, l1);
  second.bind(in2, l2);
  third.bind(queue, q);
  publish(5);  // four fill the drop-newest queue, whose reader never comes
  Latched a(first);
  publish(6);
  Latched b(second);
  publish(6);
  Latched c(third);
  publish(1000);
  Pair& held = out.loan();
  out.loan().number = 2;
  EXPECT_EQ(held.number, 0U);
  EXPECT_EQ(in1.get()->number, 5U);
  EXPECT_EQ(in2.get()->number, 11U);
  EXPECT_EQ(numbers(queue), (std::vector<std::uint32_t>{15, 16, 17}));
}

TEST_F(WorstCase, OnePinBeyondThePlanIsFoundOut) {
  In<Pair> in1, in2, in3;
  InQueue<Pair> queue;
  Latch first(*segment), second(*segment), third(*segment), rogue(*segment);
  first.bind(in1, l1);
  second.bind(in2, l2);
  third.bind(queue, q);
  rogue.bind(in3, l1);
  publish(5);
  Latched a(first);
  publish(6);
  Latched b(second);
  publish(6);
  Latched c(third);
  publish(6);
  Latched d(rogue);
  EXPECT_DEATH(
      {
        publish(10);
        out.loan();
        out.loan();
      },
      "w.a: out of slots");
}

TEST_F(WorstCase, HistoryOfTheTapIsNotLoanedAgain) {
  std::deque<const SlotHeader*> newest;
  for (int i = 0; i < 200; ++i) {
    publish(1);
    newest.push_back(commit->committed(0).back());
    if (newest.size() > sum.keep) newest.pop_front();
    out.loan().number = 0;
    out.loan().number = 0;
    for (std::size_t k = 0; k < newest.size(); ++k)
      ASSERT_EQ(static_cast<const Pair*>(newest[k]->message())->number, number - newest.size() + 1 + k);
    commit->discard();
  }
}

/// The promises of topics as a plain model: every message ever published, and per reader the messages that it has
/// consumed.
struct Reference {
  std::vector<std::uint32_t> published;
  struct Reader {
    ConnectionPlan plan;
    std::size_t consumed = 0;           // messages
    std::deque<std::uint32_t> pending;  // drop_newest
    std::vector<std::uint32_t> held;
    std::uint32_t lost = 0;
  };
  std::vector<Reader> readers;

  void publish(std::uint32_t number) {
    published.push_back(number);
    for (Reader& r : readers)
      if (r.plan.kind == ConnectionPlan::Kind::drop_newest && r.pending.size() < r.plan.depth)
        r.pending.push_back(number);
  }
  static void latch(Reader& r, const std::vector<std::uint32_t>& all) {
    r.held.clear();
    const std::size_t fresh = all.size() - r.consumed;
    switch (r.plan.kind) {
      case ConnectionPlan::Kind::latest:
        if (!all.empty()) r.held = {all.back()};
        r.lost = 0;
        break;
      case ConnectionPlan::Kind::drop_oldest:
        r.held.assign(all.end() - std::min<std::ptrdiff_t>(std::ptrdiff_t(fresh), r.plan.depth), all.end());
        r.lost = static_cast<std::uint32_t>(fresh - r.held.size());
        break;
      case ConnectionPlan::Kind::drop_newest:
        r.held.assign(r.pending.begin(), r.pending.end());
        r.lost = static_cast<std::uint32_t>(fresh - r.held.size());
        break;
    }
    r.consumed = all.size();
  }
  static void release(Reader& r) {
    r.pending.erase(r.pending.begin(), r.pending.begin() + std::ptrdiff_t(r.held.size()));
  }
};

class Random : public testing::TestWithParam<std::uint32_t> {};

TEST_P(Random, TopicsDoWhatThePlainModelSays) {
  std::mt19937 rng(GetParam());
  const auto dice = [&rng](std::uint32_t n) { return static_cast<std::uint32_t>(rng() % n); };
  const std::uint32_t burst = 1 + dice(3);
  TwoOutputs t(burst);
  Reference reference;
  std::vector<ConnectionId> ids;
  for (std::uint32_t r = 0, count = 1 + dice(5); r < count; ++r) {
    const ConnectionPlan plan = dice(3) == 0 ? latest() : dice(2) ? drop_oldest(1 + dice(5)) : drop_newest(1 + dice(5));
    ids.push_back(t.plan.connect(t.a_topic, plan));
    reference.readers.push_back({plan, 0, {}, {}, 0});
  }
  t.start();
  std::deque<InQueue<Pair>> ports(ids.size());  // a queue port shows a latest connection, too
  std::deque<Latch> latches;
  std::vector<bool> open(ids.size(), false);
  for (std::size_t r = 0; r < ids.size(); ++r) latches.emplace_back(*t.segment).bind(ports[r], ids[r]);

  std::uint32_t number = 0;
  for (int i = 0; i < 3000; ++i) {
    const auto r = dice(static_cast<std::uint32_t>(ids.size()));
    if (dice(3) != 0) {  // a step of the writer
      std::vector<std::uint32_t> step;
      for (std::uint32_t k = 0, count = dice(burst + 1); k < count; ++k) {
        t.a.loan().number = ++number;
        step.push_back(number);
        if (dice(5) == 0) t.a.cancel(), step.pop_back();
      }
      if (dice(4) == 0) {
        t.commit->discard();
      } else {
        ASSERT_EQ(t.commit->commit({}), step.empty() ? 0U : 1U);
        for (const std::uint32_t n : step) reference.publish(n);
      }
    } else if (open[r]) {
      ASSERT_EQ(numbers(ports[r]), reference.readers[r].held) << "held messages changed while pinned";
      latches[r].release();
      if (reference.readers[r].plan.kind == ConnectionPlan::Kind::drop_newest) Reference::release(reference.readers[r]);
      open[r] = false;
    } else {
      latches[r].latch();
      Reference::latch(reference.readers[r], reference.published);
      ASSERT_EQ(numbers(ports[r]), reference.readers[r].held);
      ASSERT_EQ(ports[r].dropped(), reference.readers[r].lost);
      open[r] = true;
    }
  }
  EXPECT_GT(reference.published.size(), 256U) << "did not reach the wrap of the sequence";
}
INSTANTIATE_TEST_SUITE_P(Topic, Random, testing::Range(1U, 101U));

}  // namespace
}  // namespace sinew::rt::topic_property_test
