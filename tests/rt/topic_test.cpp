// Topics within one thread: what a commit makes visible, what queues hold and count, whose slots are whose.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>

#include "graph_fixture.hpp"
#include "msg/image.hpp"

namespace sinew::rt::topic_test {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

struct Topic : testing::Test, TwoOutputs {};

TEST_F(Topic, NothingIsThereBeforeTheFirstCommit) {
  const auto c = plan.connect(a_topic, latest()), q = plan.connect(a_topic, drop_oldest(2));
  start();
  In<Pair> in;
  InQueue<Pair> queue;
  Latch latch(*segment);
  latch.bind(in, c);
  latch.bind(queue, q);
  Latched step(latch);
  EXPECT_EQ(in.get(), nullptr);
  EXPECT_FALSE(in.updated());
  EXPECT_TRUE(queue.empty());
  EXPECT_EQ(queue.dropped(), 0U);
}

TEST_F(Topic, AnInputThatExpiresHoldsNothingOlder) {
  const ConnectionId near = plan.connect(a_topic, latest(true)), far = plan.connect(a_topic, latest());
  start();
  Latch latch(*segment);
  In<Pair> in, in_thread;
  latch.bind(in, far, Duration{INT64_MAX}, ~0U, Duration{100});
  latch.bind(in_thread, near, Duration{INT64_MAX}, ~0U, Duration{100});
  a.loan().stamp = Time{1000};
  commit->commit({Time{1000}});
  const auto held_at = [&](std::int64_t now) {
    latch.latch(Time{now});
    const bool both = in.get() != nullptr;
    EXPECT_EQ(in_thread.get() != nullptr, both);
    latch.release();
    return both;
  };
  EXPECT_TRUE(held_at(1100));
  EXPECT_FALSE(held_at(1101));
  EXPECT_TRUE(held_at(1050)) << "it is only not shown";
  for (int i = 0; i < 100; ++i) {  // a slot that was put back is free: the topic does not run dry
    EXPECT_FALSE(held_at(2000));
    publish_a(7);
  }
}

TEST_F(Topic, OutputsOfOneStepBecomeVisibleTogetherAtTheCommit) {
  const auto ca = plan.connect(a_topic, latest()), cb = plan.connect(b_topic, latest());
  start();
  In<Pair> in_a, in_b;
  Latch latch(*segment);
  latch.bind(in_a, ca);
  latch.bind(in_b, cb);
  publish(1);
  a.loan().number = 2;
  {
    Latched step(latch);
    EXPECT_EQ(in_a.get()->number, 1U);
  }
  b.loan().number = 2;
  {
    Latched step(latch);
    EXPECT_EQ(in_a.get()->number, 1U);
    EXPECT_EQ(in_b.get()->number, 1U);
  }
  EXPECT_EQ(commit->commit({Time{7}}), 0b11U);
  Latched step(latch);
  EXPECT_EQ(in_a.get()->number, 2U);
  EXPECT_EQ(in_b.get()->number, 2U);
  EXPECT_EQ(in_a.header(0)->commit, in_b.header(0)->commit);
  EXPECT_EQ(in_a.header(0)->published, Time{7});
}

TEST_F(Topic, CommitTellsWhichOutputsGotMessages) {
  start();
  EXPECT_EQ(commit->commit({}), 0U);
  EXPECT_EQ(commit->number(), 0U);
  b.loan();
  EXPECT_EQ(commit->commit({}), 0b10U);
  EXPECT_EQ(commit->number(), 1U);
  EXPECT_EQ(a.committed(), nullptr);
  EXPECT_NE(b.committed(), nullptr);
  EXPECT_EQ(commit->commit({}), 0U);
  EXPECT_EQ(b.committed(), nullptr);
}

TEST_F(Topic, ReaderSeesTheLoanItself) {
  for (const bool same_thread : {false, true}) {
    TwoOutputs t;
    const auto c = t.plan.connect(t.a_topic, latest(same_thread));
    t.start();
    In<Pair> in;
    Latch latch(*t.segment);
    latch.bind(in, c);
    const Pair* written = &t.a.loan();
    t.commit->commit({});
    EXPECT_EQ(t.a.committed(), written);
    Latched step(latch);
    EXPECT_EQ(in.get(), written);
  }
}

TEST_F(Topic, DiscardPublishesNothingAndGivesSequenceNumbersBack) {
  const auto c = plan.connect(a_topic, drop_oldest(8));
  start();
  InQueue<Pair> queue;
  Latch latch(*segment);
  latch.bind(queue, c);
  publish(1);
  a.loan().number = 99;
  b.loan();
  commit->discard();
  publish(2);
  Latched step(latch);
  EXPECT_THAT(numbers(queue), ElementsAre(1, 2));
  EXPECT_EQ(queue.header(1)->sequence, queue.header(0)->sequence + 1);
}

TEST_F(Topic, DiscardedLoansNeverRunTheTopicDry) {
  const auto c = plan.connect(a_topic, latest());
  start();
  In<Pair> in;
  Latch latch(*segment);
  latch.bind(in, c);
  publish(1);
  for (int i = 0; i < 100; ++i) {
    a.loan().number = 99;
    commit->discard();
    Latched step(latch);
    ASSERT_EQ(in.get()->number, 1U);
  }
}

TEST_F(Topic, CancelTakesTheNewestLoanBack) {
  TwoOutputs t(3);
  const auto c = t.plan.connect(t.a_topic, drop_oldest(8));
  t.start();
  InQueue<Pair> queue;
  Latch latch(*t.segment);
  latch.bind(queue, c);
  t.a.loan().number = 1;
  t.a.loan().number = 2;
  t.a.cancel();
  t.a.loan().number = 3;
  t.b.loan();
  t.b.cancel();
  EXPECT_EQ(t.commit->commit({}), 0b01U);
  Latched step(latch);
  EXPECT_THAT(numbers(queue), ElementsAre(1, 3));
}

TEST_F(Topic, LoanBeyondTheBurstIsAnAbort) {
  start();
  a.loan();
  EXPECT_DEATH(a.loan(), "burst");
}

TEST_F(Topic, LoanResetsEveryFieldButTheBulk) {
  SegmentPlan images;
  const WriterId w = images.add_writer("camera");
  const TopicId raw =
      images.add_topic(w, {.name = "camera.raw", .type = &msg::type_info<msg::Image>(), .bulk_bytes = 64});
  images.connect(raw, latest(true));
  Segment memory(images);
  Commit writer(memory, w);
  Out<msg::Image> out;
  writer.bind(out, 0);
  std::vector<msg::Image*> seen;
  for (int round = 0; round < 2; ++round)
    for (std::uint32_t i = 0; i < images.slots(raw).total(); ++i) {
      msg::Image& image = out.loan();
      EXPECT_EQ(image.stamp.ns, 0);
      EXPECT_EQ(image.format, msg::PixelFormat::none);
      EXPECT_EQ(image.width, 0U);
      EXPECT_EQ(image.frame_number, 0U);
      EXPECT_EQ(image.capacity_bytes, 64U);
      EXPECT_EQ(image.pixels()[63], round == 0 ? 0 : 0xAB);
      image.stamp.ns = 5;
      image.frame_number = 6;
      ASSERT_TRUE(image.format_as(msg::PixelFormat::mono8, 8, 8));
      std::memset(image.pixels(), 0xAB, 64);
      writer.commit({});
    }
}

TEST_F(Topic, NanIsCanonicalAtTheCommit) {
  start();
  Pair& p = a.loan();
  const std::uint64_t odd_nan = 0xFFF8000000000123;
  std::memcpy(&p.value[2], &odd_nan, 8);
  p.value[1] = -std::numeric_limits<double>::infinity();
  commit->commit({});
  std::uint64_t bits;
  std::memcpy(&bits, &a.committed()->value[2], 8);
  EXPECT_EQ(bits, 0x7FF8000000000000U);
  EXPECT_EQ(a.committed()->value[1], -std::numeric_limits<double>::infinity());
}

TEST_F(Topic, HeaderCarriesStampAndOrigins) {
  SegmentPlan chains;
  const WriterId w = chains.add_writer("imu");
  const TopicId t =
      chains.add_topic(w, {.name = "imu.raw", .type = &msg::type_info<Pair>(), .burst = 2, .source_chains = 0b10});
  const auto c = chains.connect(t, drop_oldest(2));
  Segment memory(chains);
  Commit writer(memory, w);
  Out<Pair> out;
  writer.bind(out, 0);
  InQueue<Pair> queue;
  Latch latch(memory);
  latch.bind(queue, c);
  out.loan().stamp.ns = 11;
  out.loan().stamp.ns = 12;
  CommitInfo info{Time{20}};
  info.origin_ns[0] = 4;
  writer.commit(info);
  Latched step(latch);
  EXPECT_EQ(queue.header(1)->stamp.ns, 12);
  EXPECT_EQ(queue.header(1)->origin_ns[0], 4);
  EXPECT_EQ(queue.header(0)->origin_ns[1], 11);
  EXPECT_EQ(queue.header(1)->origin_ns[1], 12);
  EXPECT_EQ(queue.header(1)->origin_ns[2], kNoOrigin.ns);
  std::int64_t oldest[kMaxChains];
  latch.merge_origins(oldest);
  EXPECT_EQ(oldest[0], 4);
  EXPECT_EQ(oldest[1], 11);
  EXPECT_EQ(oldest[7], kNoOrigin.ns);
}

TEST_F(Topic, LatestIsUpdatedOnlyByAnotherMessage) {
  const auto c = plan.connect(a_topic, latest());
  start();
  In<Pair> in;
  Latch latch(*segment);
  latch.bind(in, c);
  publish(1);
  {
    Latched step(latch);
    EXPECT_TRUE(in.updated());
  }
  {
    Latched step(latch);
    EXPECT_FALSE(in.updated());
    EXPECT_EQ(in.get()->number, 1U);
  }
  publish(2);
  publish(3);
  Latched step(latch);
  EXPECT_TRUE(in.updated());
  EXPECT_EQ(in.get()->number, 3U);
  EXPECT_EQ(in.dropped(), 0U);
}

TEST_F(Topic, FreshLooksAtTheStampAndTheDeclaredAge) {
  const auto c = plan.connect(a_topic, latest());
  start();
  In<Pair> in;
  Latch latch(*segment);
  latch.bind(in, c, Duration{10});
  a.loan().stamp.ns = 100;
  commit->commit({});
  Latched step(latch);
  EXPECT_NE(in.fresh(Time{110}), nullptr);
  EXPECT_EQ(in.fresh(Time{111}), nullptr);
  EXPECT_NE(in.get(), nullptr);
}

TEST_F(Topic, PinnedMessageSurvivesWhileTheWriterLaps) {
  const auto c = plan.connect(a_topic, latest());
  start();
  In<Pair> in;
  Latch latch(*segment);
  latch.bind(in, c);
  publish(1);
  Latched step(latch);
  for (std::uint32_t n = 2; n < 1000; ++n) publish(n);
  EXPECT_EQ(in.get()->number, 1U);
  EXPECT_EQ(in.header(0)->sequence, kNearWrap);
}

TEST_F(Topic, DropOldestKeepsTheNewestAndCountsTheRest) {
  const auto c = plan.connect(a_topic, drop_oldest(3));
  start();
  InQueue<Pair> queue;
  Latch latch(*segment);
  latch.bind(queue, c);
  for (std::uint32_t n = 1; n <= 5; ++n) publish(n);
  {
    Latched step(latch);
    EXPECT_THAT(numbers(queue), ElementsAre(3, 4, 5));
    EXPECT_EQ(queue.dropped(), 2U);
    publish(6);  // comes while the step runs: for the next one
    EXPECT_THAT(numbers(queue), ElementsAre(3, 4, 5));
  }
  {
    Latched step(latch);
    EXPECT_THAT(numbers(queue), ElementsAre(6));
    EXPECT_EQ(queue.dropped(), 0U);
    EXPECT_EQ(queue.dropped_total(), 2U);
  }
  Latched step(latch);
  EXPECT_THAT(numbers(queue), IsEmpty());
}

TEST_F(Topic, DropNewestKeepsTheOldestAndCountsTheRest) {
  const auto c = plan.connect(a_topic, drop_newest(3));
  start();
  InQueue<Pair> queue;
  Latch latch(*segment);
  latch.bind(queue, c);
  for (std::uint32_t n = 1; n <= 5; ++n) publish(n);
  {
    Latched step(latch);
    EXPECT_THAT(numbers(queue), ElementsAre(1, 2, 3));
    EXPECT_EQ(queue.dropped(), 2U);
    publish(6);  // still full until the step has released
    EXPECT_THAT(numbers(queue), ElementsAre(1, 2, 3));
  }
  publish(7);
  {
    Latched step(latch);
    EXPECT_THAT(numbers(queue), ElementsAre(7));
    EXPECT_EQ(queue.dropped(), 1U);
    EXPECT_EQ(queue.dropped_total(), 3U);
  }
}

TEST_F(Topic, TwoQueuesOfOneTopicDropEachForItself) {
  const auto c1 = plan.connect(a_topic, drop_newest(1)), c2 = plan.connect(a_topic, drop_newest(4)),
             c3 = plan.connect(a_topic, drop_oldest(2));
  start();
  InQueue<Pair> q1, q2, q3;
  Latch latch(*segment);
  latch.bind(q1, c1);
  latch.bind(q2, c2);
  latch.bind(q3, c3);
  for (std::uint32_t n = 1; n <= 3; ++n) publish(n);
  Latched step(latch);
  EXPECT_THAT(numbers(q1), ElementsAre(1));
  EXPECT_THAT(numbers(q2), ElementsAre(1, 2, 3));
  EXPECT_THAT(numbers(q3), ElementsAre(2, 3));
  EXPECT_EQ(q1.dropped(), 2U);
  EXPECT_EQ(q2.dropped(), 0U);
  EXPECT_EQ(q3.dropped(), 1U);
}

TEST_F(Topic, BurstIsOneCommitAndArrivesInOrder) {
  TwoOutputs t(4);
  const auto c = t.plan.connect(t.a_topic, drop_oldest(8)), l = t.plan.connect(t.a_topic, latest());
  t.start();
  InQueue<Pair> queue;
  In<Pair> in;
  Latch latch(*t.segment);
  latch.bind(queue, c);
  latch.bind(in, l);
  for (std::uint32_t n = 1; n <= 4; ++n) t.a.loan().number = n;
  t.commit->commit({});
  EXPECT_EQ(t.commit->committed(0).size(), 4U);
  EXPECT_EQ(t.commit->number(), 1U);
  Latched step(latch);
  EXPECT_THAT(numbers(queue), ElementsAre(1, 2, 3, 4));
  EXPECT_EQ(in.get()->number, 4U);
}

TEST_F(Topic, LateReaderFindsWhatTheQueueHolds) {
  const auto o = plan.connect(a_topic, drop_oldest(2)), n = plan.connect(a_topic, drop_newest(2)),
             l = plan.connect(a_topic, latest());
  start();
  for (std::uint32_t i = 1; i <= 100; ++i) publish(i);
  InQueue<Pair> oldest, newest;
  In<Pair> in;
  Latch latch(*segment);
  latch.bind(oldest, o);
  latch.bind(newest, n);
  latch.bind(in, l);
  Latched step(latch);
  EXPECT_THAT(numbers(oldest), ElementsAre(99, 100));
  EXPECT_EQ(oldest.dropped(), 98U);
  EXPECT_THAT(numbers(newest), ElementsAre(1, 2));
  EXPECT_EQ(newest.dropped(), 98U);
  EXPECT_EQ(in.get()->number, 100U);
}

TEST_F(Topic, SequencesWrapWithoutLossOrGap) {
  const auto o = plan.connect(a_topic, drop_oldest(4)), n = plan.connect(a_topic, drop_newest(4)),
             l = plan.connect(a_topic, latest());
  start();
  InQueue<Pair> oldest, newest;
  In<Pair> in;
  Latch latch(*segment);
  latch.bind(oldest, o);
  latch.bind(newest, n);
  latch.bind(in, l);
  std::uint32_t published = 0;
  bool wrapped = false;
  while (published < 1024) {
    for (std::uint32_t i = 0; i < 1 + published % 3; ++i) publish(++published);
    Latched step(latch);
    ASSERT_EQ(in.get()->number, published);
    ASSERT_TRUE(in.updated());
    ASSERT_EQ(oldest.back().number, published);
    ASSERT_EQ(numbers(oldest), numbers(newest));
    ASSERT_EQ(oldest.dropped() + newest.dropped(), 0U);
    wrapped |= in.header(0)->sequence < kNearWrap;
    ASSERT_EQ(in.header(0)->sequence, kNearWrap + published - 1);
  }
  EXPECT_TRUE(wrapped);
}

/// What 32 bits could not count must not come out small.
TEST_F(Topic, MoreThanAMachineCanAddressIsNeverSaidToFit) {
  plan.add_topic(
      plan.add_writer("c"),
      {.name = "c.a", .type = &msg::type_info<msg::Image>(), .bulk_bytes = 0xFFFFFF00, .burst = 3, .history = 5});
  constexpr std::uint64_t kLeast = std::uint64_t{8} * 0xFFFFFF00;
  EXPECT_GE(plan.bytes(), std::min<std::uint64_t>(kLeast, SIZE_MAX / 4096 * 4096));
}

TEST_F(Topic, SegmentCanBeReadByOffsetsAlone) {
  plan.connect(a_topic, latest());
  start();
  publish(1);
  publish_a(2);
  const auto* base = reinterpret_cast<const std::byte*>(&segment->header());
  const auto word = [base](std::uint64_t offset) {
    std::uint32_t value;
    std::memcpy(&value, base + offset, 4);
    return value;
  };
  SegmentHeader header;
  std::memcpy(&header, base, sizeof header);
  ASSERT_EQ(header.magic, kSegmentMagic);
  ASSERT_EQ(std::memcmp(&header.magic, "SNEWSEG1", 8), 0);
  TopicEntry topic;
  std::memcpy(&topic, base + header.topics, sizeof topic);
  WriterEntry writer;
  std::memcpy(&writer, base + header.writers + topic.writer * sizeof writer, sizeof writer);
  EXPECT_STREQ(topic.name, "w.a");
  EXPECT_STREQ(topic.type, "Pair");
  const std::uint32_t number = word(writer.number);
  ASSERT_EQ(number, 2U);
  const std::uint64_t record = writer.records + std::uint64_t{number % writer.record_count} * 4 * (1 + writer.outputs);
  EXPECT_EQ(word(record), number);
  const std::uint32_t last_a = word(record + 4), last_b = word(record + 8);
  EXPECT_EQ(last_a, kNearWrap + 1);
  EXPECT_EQ(last_b, kNearWrap);
  const std::uint32_t slot = word(topic.ring + 4 * (last_a % topic.ring_size));
  ASSERT_LT(slot, topic.slot_count);
  SlotHeader slot_header;
  std::memcpy(&slot_header, base + topic.slots + slot * topic.slot_stride, sizeof slot_header);
  EXPECT_EQ(slot_header.sequence, last_a);
  Pair message;
  std::memcpy(&message, base + topic.slots + slot * topic.slot_stride + sizeof slot_header, sizeof message);
  EXPECT_EQ(message.number, 2U);
}

class Writer final : public Module {
 public:
  void declare(Declaration& d) override {
    d.out("often", often_);
    d.out("seldom", seldom_, {.usual_period = 100ms});
  }
  StepStatus step(const Step&) noexcept override { return StepStatus::ok; }

 private:
  Out<Pair> often_, seldom_;
};

TEST(TopicHistory, HoldsHalfASecondOfWhatTheWriterUsuallyWrites) {
  Robot robot;
  robot.add<Writer>("w");
  robot.periodic("fast", 50, 1ms, {"w"});
  const Graph& graph = robot.build();
  const auto often = graph.find_topic("w.often"), seldom = graph.find_topic("w.seldom");
  EXPECT_DOUBLE_EQ(graph.planned_rate_hz(often), 1000);
  EXPECT_DOUBLE_EQ(graph.planned_rate_hz(seldom), 10);
  EXPECT_EQ(graph.slots(often).keep, 501U);
  EXPECT_EQ(graph.slots(seldom).keep, 6U);
}

}  // namespace
}  // namespace sinew::rt::topic_test
