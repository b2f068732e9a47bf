// An outsider's reader: the messages that it finds, the changes that it notices, and memory with any content.
#include "tap/segment_reader.hpp"

#include <gtest/gtest.h>

#include <cstring>

#include "msg/sensors.hpp"
#include "rt/commit.hpp"
#include "rt/schema_hash.hpp"

namespace sinew::tap::segment_reader_test {
namespace {

constexpr std::uint32_t kNearWrap = 0xFFFFFFFD;

/// One writer with two outputs, written by the test.
class Topics {
 public:
  explicit Topics(std::uint32_t keep) {
    rt::SegmentPlan plan({.first_sequence = kNearWrap});
    const auto w = plan.add_writer("w");
    plan.add_topic(w, {"w.range", &msg::type_info<msg::RangeSample>(), 0, 2, 0, keep, 0});
    plan.add_topic(w, {"w.baro", &msg::type_info<msg::BaroSample>(), 0, 1, 0, keep, 0});
    segment = std::make_unique<rt::Segment>(plan);
    commit = std::make_unique<rt::Commit>(*segment, w);
    auto opened = SegmentReader::open(memory());
    if (opened) reader.emplace(std::move(*opened));
  }
  std::span<const std::byte> memory() const {
    return {reinterpret_cast<const std::byte*>(&segment->header()), static_cast<std::size_t>(segment->header().bytes)};
  }
  void publish(double range_m) {
    static_cast<msg::RangeSample*>(commit->try_loan(0))->range_m = range_m;
    commit->commit({});
  }
  double range_of(const Message& m) const {
    msg::RangeSample r;
    std::memcpy(&r, m.data(), sizeof r);
    return r.range_m;
  }
  std::unique_ptr<rt::Segment> segment;
  std::unique_ptr<rt::Commit> commit;
  std::optional<SegmentReader> reader;
};

TEST(SegmentReader, FindsTopicsWithTheirTypes) {
  Topics t(4);
  ASSERT_TRUE(t.reader);
  ASSERT_EQ(t.reader->topics().size(), 2U);
  const Topic& baro = t.reader->topics()[*t.reader->find("w.baro")];
  EXPECT_EQ(baro.type, "BaroSample");
  EXPECT_EQ(baro.info, &msg::type_info<msg::BaroSample>());
  EXPECT_EQ(baro.schema_hash, rt::schema_hash(msg::type_info<msg::BaroSample>()));
  EXPECT_EQ(baro.keep, 4U);
  EXPECT_FALSE(t.reader->find("w.image"));
}

TEST(SegmentReader, NewestIsNothingBeforeTheFirstAndThenTheLastCommitted) {
  Topics t(1);
  EXPECT_FALSE(t.reader->newest(0));
  t.publish(1);
  t.publish(2);
  const auto m = t.reader->newest(0);
  ASSERT_TRUE(m);
  EXPECT_EQ(t.range_of(*m), 2);
  EXPECT_EQ(m->sequence, kNearWrap + 1);
  EXPECT_FALSE(t.reader->newest(1)) << "the other output has published nothing";
}

TEST(SegmentReader, LoanedMessageIsNotSeenAndDoesNotEndTheNewest) {
  Topics t(1);
  t.publish(1);
  const auto m = t.reader->newest(0);
  static_cast<msg::RangeSample*>(t.commit->try_loan(0))->range_m = 2;
  EXPECT_TRUE(t.reader->holds(*m));
  EXPECT_EQ(t.range_of(*t.reader->newest(0)), 1);
  t.commit->discard();
  EXPECT_TRUE(t.reader->holds(*m));
}

TEST(SegmentReader, MessageHoldsExactlyAsLongAsItsSlotIsNotLoanedAgain) {
  for (const std::uint32_t keep : {1U, 2U, 5U}) {
    Topics t(keep);
    t.publish(1);
    const auto m = t.reader->newest(0);
    for (std::uint32_t i = 1; i < keep; ++i) {
      EXPECT_TRUE(t.reader->holds(*m)) << i << " of " << keep;
      t.publish(1.0 + i);
    }
    EXPECT_TRUE(t.reader->holds(*m));
    EXPECT_EQ(t.range_of(*m), 1);
    t.publish(100);
    EXPECT_FALSE(t.reader->holds(*m));
  }
}

TEST(SegmentReader, NextGivesEveryMessageOnceOverTheWrap) {
  Topics t(8);
  Cursor cursor;
  EXPECT_FALSE(t.reader->next(0, cursor));
  for (int i = 1; i <= 20; i += 2) {
    t.publish(i), t.publish(i + 1);
    for (int k = 0; k < 2; ++k) {
      const auto m = t.reader->next(0, cursor);
      ASSERT_TRUE(m);
      EXPECT_EQ(t.range_of(*m), i + k);
    }
    EXPECT_FALSE(t.reader->next(0, cursor));
  }
  EXPECT_EQ(cursor.lost, 0U);
}

TEST(SegmentReader, WhatIsGoneIsSkippedAndCounted) {
  Topics t(3);
  Cursor cursor;
  t.publish(0);
  ASSERT_TRUE(t.reader->next(0, cursor));
  for (int i = 1; i <= 10; ++i) t.publish(i);
  const auto m = t.reader->next(0, cursor);
  ASSERT_TRUE(m);
  EXPECT_EQ(t.range_of(*m), 8) << "the oldest of three that are kept";
  EXPECT_EQ(cursor.lost, 7U);
}

TEST(SegmentReader, MessagesOfOneCommitAreAllRead) {
  Topics t(4);
  Cursor cursor;
  t.publish(0);
  ASSERT_TRUE(t.reader->next(0, cursor));
  static_cast<msg::RangeSample*>(t.commit->try_loan(0))->range_m = 1;
  static_cast<msg::RangeSample*>(t.commit->try_loan(0))->range_m = 2;
  t.commit->commit({});
  EXPECT_EQ(t.range_of(*t.reader->next(0, cursor)), 1);
  EXPECT_EQ(t.range_of(*t.reader->next(0, cursor)), 2);
}

TEST(SegmentReader, CopyIsOfAWholeMessageOrNone) {
  Topics t(1);
  t.publish(1);
  const auto m = t.reader->newest(0);
  std::vector<std::byte> copy(t.reader->bytes(0));
  EXPECT_TRUE(t.reader->copy(*m, copy));
  EXPECT_FALSE(t.reader->copy(*m, std::span(copy).first(8))) << "no room";
  t.publish(2);
  EXPECT_FALSE(t.reader->copy(*m, copy));
}

TEST(SegmentReader, TypeOfAnotherDescriptionIsNotKnown) {
  Topics t(1);
  std::vector<std::byte> bytes(t.memory().size() + 64);
  auto* at = bytes.data() + (64 - reinterpret_cast<std::uintptr_t>(bytes.data()) % 64);
  std::memcpy(at, t.memory().data(), t.memory().size());
  rt::SegmentHeader header;
  std::memcpy(&header, at, sizeof header);
  at[header.topics + offsetof(rt::TopicEntry, schema_hash)] ^= std::byte{1};
  const auto reader = SegmentReader::open({at, t.memory().size()});
  ASSERT_TRUE(reader);
  EXPECT_FALSE(reader->topics()[0].known());
  EXPECT_TRUE(reader->topics()[1].known());
}

/// Looks at everything that the memory offers, as a client would.
void look_at_all(const SegmentReader& reader) {
  for (std::uint32_t t = 0; t < reader.topics().size(); ++t) {
    std::vector<std::byte> copy(std::min<std::size_t>(reader.bytes(t), 1 << 20));
    if (const auto m = reader.newest(t)) static_cast<void>(reader.copy(*m, copy));
    Cursor cursor;
    for (int i = 0; i < 4; ++i)
      if (const auto m = reader.next(t, cursor)) static_cast<void>(reader.copy(*m, copy));
  }
}

TEST(SegmentReader, SurvivesMemoryThatSaysAnything) {
  Topics t(4);
  for (int i = 0; i < 10; ++i) t.publish(i);
  const std::size_t n = t.memory().size();
  const std::unique_ptr<std::byte[], void (*)(void*)> memory(static_cast<std::byte*>(std::aligned_alloc(4096, n)),
                                                             [](void* p) { std::free(p); });
  std::uint64_t random = 1;
  const auto draw = [&random] {
    random = random * 6364136223846793005 + 1442695040888963407;
    return static_cast<std::uint32_t>(random >> 33);
  };
  const std::uint32_t nasty[] = {0, 1, 0x7FFFFFFF, 0x80000000, 0xFFFFFFFF, 0xFFFFFFFE, static_cast<std::uint32_t>(n),
                                 64};
  int opened = 0, refused = 0;
  for (int run = 0; run < 20'000; ++run) {
    std::memcpy(memory.get(), t.memory().data(), n);
    for (std::uint32_t k = 0; k <= draw() % 3; ++k) {
      const std::size_t at = draw() % (draw() % 2 ? 640 : n) / 4 * 4;  // the directory, or anywhere
      const std::uint32_t value = draw() % 2 ? nasty[draw() % std::size(nasty)] : draw();
      std::memcpy(memory.get() + at, &value, 4);
    }
    const auto reader = SegmentReader::open({memory.get(), n});
    reader ? ++opened : ++refused;
    if (reader) look_at_all(*reader);
  }
  EXPECT_GT(opened, 1000);
  EXPECT_GT(refused, 1000);
}

TEST(SegmentReader, RefusesWhatDoesNotFit) {
  Topics t(4);
  const auto first = t.memory().first(t.memory().size() - 4096);
  EXPECT_EQ(SegmentReader::open(first).error().code, hal::Errc::bad_data);
  EXPECT_EQ(SegmentReader::open({}).error().code, hal::Errc::bad_data);
  EXPECT_EQ(SegmentReader::open(t.memory().first(10)).error().code, hal::Errc::bad_data);
}

}  // namespace
}  // namespace sinew::tap::segment_reader_test
