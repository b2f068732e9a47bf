#include "net/dds/participant.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>

#include "local_domain.hpp"

namespace sinew::net::participant_test {
namespace {

using namespace std::chrono_literals;
using test::becomes;
using test::joined;
using test::local_domain;
using testing::ElementsAre;
using testing::HasSubstr;

const std::vector<std::uint8_t> kSeven{0, 1, 0, 0, 7, 0, 0, 0}, kEight{0, 1, 0, 0, 8, 0};

struct Pair {
  std::unique_ptr<Participant> here = joined(), there = joined();
  std::string why;
};

EndpointSpec reliable(std::string topic, std::uint32_t depth = 10) {
  EndpointSpec spec{std::move(topic), "pkg::msg::dds_::Any_", {}, {}};
  spec.qos.reliable = true;
  spec.qos.depth = depth;
  return spec;
}

TEST(ParticipantTest, BytesOfATypeThatNobodyDescribedArriveAsTheyWereWritten) {
  Pair p;
  const auto writer = p.here->write(reliable("rt/a"), p.why);
  ASSERT_TRUE(writer) << p.why;
  const auto reader = p.there->read(reliable("rt/a"), p.why);
  ASSERT_TRUE(reader) << p.why;
  ASSERT_TRUE(becomes(*p.here, [&] { return (*writer)->matched() == 1; }));
  ASSERT_TRUE(becomes(*p.there, [&] { return (*reader)->matched() == 1; }));
  ASSERT_TRUE((*writer)->write(kSeven));
  ASSERT_TRUE((*writer)->write(kEight));  // not of whole words
  DdsSample sample;
  ASSERT_TRUE(becomes(*p.there, [&] { return (*reader)->take(sample); }));
  EXPECT_EQ(sample.cdr, kSeven);
  ASSERT_TRUE(becomes(*p.there, [&] { return (*reader)->take(sample); }));
  ASSERT_GE(sample.cdr.size(), kEight.size());
  EXPECT_TRUE(std::equal(kEight.begin(), kEight.end(), sample.cdr.begin()));
  EXPECT_GT(sample.written_wall_ns, 0);
  EXPECT_EQ(sample.writer, (*writer)->guid());
  EXPECT_FALSE((*reader)->take(sample));
}

TEST(ParticipantTest, AMessageOfManyDatagramsArrivesWhole) {
  Pair p;
  const auto writer = p.here->write(reliable("rt/image"), p.why);
  const auto reader = p.there->read(reliable("rt/image"), p.why);
  ASSERT_TRUE(becomes(*p.here, [&] { return (*writer)->matched() == 1; }));
  std::vector<std::uint8_t> large(1'000'004);
  for (std::size_t i = 4; i < large.size(); ++i) large[i] = static_cast<std::uint8_t>(i * 7 >> 3);
  large[1] = 1;
  ASSERT_TRUE((*writer)->write(large));
  DdsSample sample;
  ASSERT_TRUE(becomes(*p.there, [&] { return (*reader)->take(sample); }));
  EXPECT_TRUE(sample.cdr == large);
}

TEST(ParticipantTest, ALateReaderGetsWhatATransientLocalWriterKeeps) {
  Pair p;
  EndpointSpec spec = reliable("rt/tf_static", 1);
  spec.qos.transient_local = true;
  const auto writer = p.here->write(spec, p.why);
  ASSERT_TRUE(writer) << p.why;
  ASSERT_TRUE((*writer)->write(kEight));
  ASSERT_TRUE((*writer)->write(kSeven));
  const auto reader = p.there->read(spec, p.why);
  DdsSample sample;
  ASSERT_TRUE(becomes(*p.there, [&] { return (*reader)->take(sample); }));
  EXPECT_EQ(sample.cdr, kSeven);
  EXPECT_FALSE((*reader)->take(sample));
}

TEST(ParticipantTest, OwnSamplesDoNotComeBack) {
  Pair p;
  const auto writer = p.here->write(reliable("rt/team"), p.why);
  const auto own = p.here->read(reliable("rt/team"), p.why), other = p.there->read(reliable("rt/team"), p.why);
  ASSERT_TRUE(becomes(*p.here, [&] { return (*writer)->matched() >= 1; }));
  ASSERT_TRUE((*writer)->write(kSeven));
  DdsSample sample;
  ASSERT_TRUE(becomes(*p.there, [&] { return (*other)->take(sample); }));
  EXPECT_FALSE((*own)->take(sample));
}

TEST(ParticipantTest, EndpointsOfOthersAreSeenWithTheirQosAlsoWhenNothingOfOursMatches) {
  Pair p;
  EndpointSpec spec = reliable("rt/odom", 5);
  spec.qos.partitions = {"b", "c"};
  spec.qos.deadline = 200ms;
  spec.user_data = "typehash=RIHS01_x;";
  const auto writer = p.there->write(spec, p.why);
  ASSERT_TRUE(writer) << p.why;
  std::vector<RemoteEndpoint> seen;
  ASSERT_TRUE(becomes(*p.here, [&] { return !(seen = p.here->endpoints()).empty(); }));
  ASSERT_EQ(seen.size(), 1u);
  EXPECT_TRUE(seen[0].writes);
  EXPECT_EQ(seen[0].topic, "rt/odom");
  EXPECT_EQ(seen[0].type, "pkg::msg::dds_::Any_");
  EXPECT_EQ(seen[0].guid, (*writer)->guid());
  EXPECT_EQ(seen[0].participant, p.there->guid());
  EXPECT_TRUE(seen[0].qos.reliable);
  EXPECT_FALSE(seen[0].qos.transient_local);
  EXPECT_EQ(seen[0].qos.deadline, 200ms);
  EXPECT_THAT(seen[0].qos.partitions, ElementsAre("b", "c"));
  EXPECT_EQ(seen[0].user_data, "typehash=RIHS01_x;");
  EXPECT_TRUE(seen[0].xcdr1);
}

TEST(ParticipantTest, AnEndpointThatEndsIsSeenNoMore) {
  Pair p;
  auto reader = p.there->read(reliable("rt/x"), p.why);
  ASSERT_TRUE(becomes(*p.here, [&] { return p.here->endpoints().size() == 1; }));
  EXPECT_FALSE(p.here->endpoints()[0].writes);
  reader->reset();
  EXPECT_TRUE(becomes(*p.here, [&] { return p.here->endpoints().empty(); }));
}

TEST(ParticipantTest, UserDataOfAParticipantIsSeen) {
  ParticipantOptions options = local_domain();
  options.user_data = "enclave=/;";
  const auto here = joined(), there = joined(options);
  ASSERT_TRUE(becomes(*here, [&] { return here->participants().size() == 1; }));
  EXPECT_EQ(here->participants()[0].user_data, "enclave=/;");
  EXPECT_EQ(here->participants()[0].guid, there->guid());
}

struct Refusal {
  hal::Errc code = hal::Errc::io;
  std::string why;
};

Refusal refusal(const ParticipantOptions& options) {
  Refusal r;
  const auto opened = Participant::open(options, r.why);
  EXPECT_FALSE(opened);
  if (!opened) r.code = opened.error().code;
  return r;
}

TEST(ParticipantTest, AnInterfaceThatIsNotThereIsNamed) {
  ParticipantOptions options = local_domain();
  options.interfaces = {"nowhere0"};
  const Refusal r = refusal(options);
  EXPECT_EQ(r.code, hal::Errc::not_found) << r.why;
  EXPECT_THAT(r.why, HasSubstr("nowhere0"));
}

TEST(ParticipantTest, AConfigurationThatCycloneRefusesIsItsUsersMistake) {
  ParticipantOptions options = local_domain();
  options.extra += "<General><MaxMessageSize>much</MaxMessageSize></General>";
  const Refusal r = refusal(options);
  EXPECT_EQ(r.code, hal::Errc::bad_argument) << r.why;
  EXPECT_THAT(r.why, HasSubstr("much"));
}

TEST(ParticipantTest, OptionsOutOfRangeAreRefusedWithTheRange) {
  ParticipantOptions options = local_domain();
  options.domain = 233;
  EXPECT_EQ(refusal(options).why, "domain 233: from 0 to 232");
  options = local_domain();
  options.most_on_a_machine = 120;
  EXPECT_EQ(refusal(options).why, "participants on a machine: from 1 to 119");
  options = local_domain();
  options.security.certificate = "robot.pem";
  EXPECT_EQ(refusal(options).why, "security: identity_ca is missing: it needs all six files");
}

TEST(ParticipantTest, MoreParticipantsThanMayBeOnAMachineAreRefusedAsBusy) {
  ParticipantOptions options = local_domain();
  options.domain = 61;
  options.most_on_a_machine = 2;
  const auto one = joined(options), two = joined(options);
  const Refusal r = refusal(options);
  EXPECT_EQ(r.code, hal::Errc::busy) << r.why;
  options.most_on_a_machine = 10;  // Cyclone 0.10 keeps the sockets of the one that failed
  EXPECT_TRUE(joined(options));
}

TEST(ParticipantTest, TwelveOnAMachineFindEachOtherWithoutMulticast) {
  std::vector<std::unique_ptr<Participant>> all;
  for (int i = 0; i < 12; ++i) all.push_back(joined());
  for (const auto& one : all) EXPECT_TRUE(becomes(*one, [&] { return one->participants().size() == 11; }));
}

TEST(ParticipantTest, ADepthThatCannotBeIsRefused) {
  const auto here = joined();
  std::string why;
  EXPECT_FALSE(here->write(reliable("rt/a", 4'000'000'000), why));
  EXPECT_EQ(why, "rt/a: depth is at most 100000");
  EXPECT_FALSE(here->read({"", "T", {}, {}}, why));
  EXPECT_EQ(why, "an endpoint without a topic or a type");
}

}  // namespace
}  // namespace sinew::net::participant_test
