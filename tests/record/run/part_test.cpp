#include "record/run/part.hpp"

#include <gmock/gmock.h>

#include "midway_robot.hpp"

namespace sinew::record::part_test {
namespace {

using namespace std::chrono_literals;
using ::testing::IsEmpty;

class PartTest : public MidwayRobot {
 protected:
  void set_gain_at(std::chrono::nanoseconds at) {
    robot.grants.at(rt::Time{at.count()}, [this] { ASSERT_TRUE(robot.graph().set_param("numbers", "gain", 2.5)); });
  }
  static Metadata edited(const std::string& by) { return {std::string(kEditedName), {{"by", by}}}; }
  static Bytes cut(Reader& reader, rt::Time from, rt::Time until) {
    Disk to;
    auto writer = Writer::open(std::make_unique<MemoryOutput>(to), {});
    const Query what{.from = static_cast<std::uint64_t>(from.ns), .until = static_cast<std::uint64_t>(until.ns)};
    Reader* const one = &reader;
    Copied copied;
    EXPECT_TRUE(copy({&one, 1}, what, **writer, copied, nullptr, changes_of_cut(reader, what.from)));
    EXPECT_TRUE((*writer)->add_metadata(edited("cut")));
    EXPECT_TRUE((*writer)->finish());
    return to.bytes;
  }
  static Bytes merge(const std::vector<Bytes>& files) {
    std::vector<std::unique_ptr<Reader>> readers;
    std::vector<Reader*> from;
    for (const Bytes& file : files) {
      readers.push_back(read(file));
      from.push_back(readers.back().get());
    }
    Disk to;
    auto writer = Writer::open(std::make_unique<MemoryOutput>(to), {});
    Copied copied;
    EXPECT_TRUE(copy(from, {}, **writer, copied, nullptr, changes_of_merge(from)));
    EXPECT_TRUE((*writer)->add_metadata(edited("merge of " + std::to_string(files.size()))));
    EXPECT_TRUE((*writer)->finish());
    return to.bytes;
  }
  static std::uint64_t steps(const ReplayReport& report) {
    std::uint64_t all = 0;
    for (const auto& m : report.modules) all += m.steps;
    return all;
  }
};

TEST_F(PartTest, EachFileOfASplitRecordingReplaysAlone) {
  set_gain_at(150'500'000ns);
  fly(1s, {.files = {.file_duration = 300ms}});
  ASSERT_GE(disks.size(), 3u);
  for (unsigned part = 0; part < 3; ++part) {
    SCOPED_TRACE(part);
    const ReplayReport report = again(disks[part]->bytes);
    expect_identical(report);
    EXPECT_EQ(report.midway, part != 0);
    for (const ReplayedModule& m : report.modules) {
      EXPECT_EQ(m.from.has_value(), part != 0) << m.name;
      EXPECT_EQ(m.not_compared, 0u) << m.name;
    }
    EXPECT_THAT(review(*read(part)).differences, IsEmpty());
  }
}

TEST_F(PartTest, APartThatWasCutOutReplaysFromItsFirstStates) {
  set_gain_at(100'500'000ns);
  fly(600ms, {.state_every = 60ms});
  const Bytes part = cut(*read(), rt::Time{200'000'000}, rt::Time{500'000'000});
  const ReplayReport report = again(part, {.modules = {"numbers", "sums", "pictures", "looks", "plan"}});
  expect_identical(report);
  EXPECT_TRUE(report.midway);
  EXPECT_EQ(report.start, rt::Time{200'000'000}) << "not that of the request before it";
  for (const ReplayedModule& m : report.modules) {
    ASSERT_TRUE(m.from) << m.name;
    EXPECT_GT(*m.from, rt::Time{200'000'000}) << m.name;
    EXPECT_LT(*m.from, rt::Time{300'000'000}) << m.name;
  }
  EXPECT_THAT(review(*read(part)).lost_steps, IsEmpty());
}

TEST_F(PartTest, WhatIsMergedOfPartsIsTheWholeAgain) {
  set_gain_at(100'500'000ns);
  fly(600ms, {.files = {.file_duration = 200ms}, .state_every = 60ms});
  std::vector<Bytes> parts;
  for (const auto& disk : disks) parts.insert(parts.begin(), disk->bytes);
  const Bytes merged = merge(parts);
  const ReplayReport report = again(merged);
  expect_identical(report);
  EXPECT_FALSE(report.midway);
  const auto whole = read(merged);
  const std::uint64_t half = 300'000'000;
  const ReplayReport joined =
      again(merge({cut(*whole, rt::Time{0}, rt::Time{half - 1}), cut(*whole, rt::Time{half}, rt::Time{INT64_MAX})}));
  expect_identical(joined);
  EXPECT_EQ(steps(joined), steps(report));
}

}  // namespace
}  // namespace sinew::record::part_test
