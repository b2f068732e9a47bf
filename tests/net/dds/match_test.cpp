#include "net/dds/match.hpp"

#include <gtest/gtest.h>

namespace sinew::net::match_test {
namespace {

using namespace std::chrono_literals;

OwnEndpoint own(bool writes, DdsQos qos = {}) { return {{"rt/odom", "T", std::move(qos), {}}, writes}; }

RemoteEndpoint remote(bool writes, DdsQos qos = {}) {
  RemoteEndpoint e;
  e.topic = "rt/odom", e.type = "T", e.writes = writes, e.qos = std::move(qos);
  return e;
}

DdsQos qos(bool reliable, bool transient_local = false) {
  DdsQos q;
  q.reliable = reliable, q.transient_local = transient_local;
  return q;
}

TEST(MatchTest, AReaderThatAsksForMoreThanAWriterOffersIsNamedWithThePolicy) {
  EXPECT_EQ(why_no_match(own(true, qos(false)), remote(false, qos(true))),
            "reliability: its reader asks for reliable, our writer offers best effort");
  EXPECT_EQ(why_no_match(own(false, qos(true, true)), remote(true, qos(true))),
            "durability: our reader asks for transient local, its writer offers volatile");
  EXPECT_EQ(why_no_match(own(true, qos(true, true)), remote(false, qos(false))), "");
}

TEST(MatchTest, ADeadlineThatTheWriterDoesNotPromiseIsNamed) {
  DdsQos asks = qos(false), offers = qos(false);
  asks.deadline = 100ms;
  EXPECT_EQ(why_no_match(own(true, offers), remote(false, asks)),
            "deadline: its reader asks for 100 ms, our writer offers none");
  offers.deadline = 50ms;
  EXPECT_EQ(why_no_match(own(true, offers), remote(false, asks)), "");
}

TEST(MatchTest, AnotherTypePartitionOrRepresentationIsNamed) {
  RemoteEndpoint other = remote(false);
  other.type = "U";
  EXPECT_EQ(why_no_match(own(true), other), "type: ours is T, its is U");
  other = remote(false);
  other.qos.partitions = {"lab", "yard"};
  EXPECT_EQ(why_no_match(own(true), other), "partition: ours none, its 'lab', 'yard'");
  other = remote(false);
  other.xcdr1 = false;
  EXPECT_EQ(why_no_match(own(true), other), "data representation: it has XCDR2 only, we have XCDR1");
}

TEST(MatchTest, PartitionsMatchByPatternsButPatternsNotEachOther) {
  EXPECT_TRUE(partitions_match({}, {""}));
  EXPECT_TRUE(partitions_match({"team_*"}, {"team_1"}));
  EXPECT_TRUE(partitions_match({"a", "b"}, {"b"}));
  EXPECT_FALSE(partitions_match({"team_*"}, {"team_?"}));
  EXPECT_FALSE(partitions_match({}, {"a"}));
}

TEST(MatchTest, OnlyAWriterAndAReaderOfOneTopicAreCounterparts) {
  EXPECT_TRUE(is_counterpart(own(true), remote(false)));
  EXPECT_FALSE(is_counterpart(own(true), remote(true)));
  RemoteEndpoint other = remote(false);
  other.topic = "odom";
  EXPECT_FALSE(is_counterpart(own(true), other));
}

}  // namespace
}  // namespace sinew::net::match_test
