// A million results need no more memory than a thousand, but for a bit each.
#include <gtest/gtest.h>

#include <filesystem>

#include "apps/sweep/results_file.hpp"
#include "apps/sweep/summary.hpp"
#include "hal/linux/process.hpp"

namespace sinew::sweep::memory_test {
namespace {

namespace fs = std::filesystem;

TEST(SweepMemory, AMillionResultsAreWrittenSortedAndSummedUpInBoundedMemory) {
  constexpr std::uint64_t kCases = 1'000'000;
  constexpr std::uint64_t kMost = 24 << 20;  // the window of the sorting, a bit for each case, tables
  const std::string path = (fs::temp_directory_path() / "million.jsonl").string();
  const std::uint64_t before = hal::process_use().peak_rss_bytes;
  std::string why;
  const Identity identity{kCases, {{"fake", true}}};
  auto file = ResultsFile::open(path, identity, {}, why);
  ASSERT_TRUE(file) << why;
  CaseResult result{0,
                    "",
                    0,
                    true,
                    "landed on the pad",
                    "",
                    "0123456789abcdef",
                    {{"landing_error_m", 0, {0.15, {}}}, {"flight_s", 20, {}}}};
  for (std::uint64_t i = 0; i < kCases; ++i) {
    const std::uint64_t number = (i ^ 1) % kCases;  // pairs end in the wrong order
    result.run = "robots/quad/quad.toml --set mixer.thrust_max_n=5.5 --seed " + std::to_string(number);
    result.measures[0].value = 1e-7 * static_cast<double>(number);
    ASSERT_TRUE(file->append(number, to_json(result), why)) << why;
  }
  ASSERT_TRUE(file->finish(kCases, why)) << why;
  Summary summary;
  Identity read;
  Shard shard;
  std::uint64_t next = 0;
  const auto see = [&](const ResultLine& line) {
    EXPECT_EQ(line.number, next++);
    summary.add(case_result(line.number, line.result));
    return !::testing::Test::HasFailure();
  };
  ASSERT_TRUE(read_results(path, read, shard, see, why)) << why;
  EXPECT_EQ(summary.runs(), kCases);
  EXPECT_FALSE(summary.text(kCases).empty());
  fs::remove(path);
#ifndef SINEW_SANITIZED  // those keep what was freed
  EXPECT_LT(hal::process_use().peak_rss_bytes - before, kMost);
#endif
}

}  // namespace
}  // namespace sinew::sweep::memory_test
