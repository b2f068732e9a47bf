#include "apps/sweep/results_file.hpp"

#include <gmock/gmock.h>
#include <sys/resource.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <thread>

namespace sinew::sweep::results_file_test {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

std::string content(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  std::ostringstream all;
  all << in.rdbuf();
  return all.str();
}

class SweepResults : public ::testing::Test {
 protected:
  SweepResults()
      : folder_(fs::temp_directory_path() / ::testing::UnitTest::GetInstance()->current_test_info()->name()) {
    fs::create_directories(folder_);
  }
  ~SweepResults() override { fs::remove_all(folder_); }

  std::string path(const std::string& name) const { return (folder_ / name).string(); }
  std::unique_ptr<ResultsFile> open(const std::string& name, const Shard& shard = {}) {
    auto file = ResultsFile::open(path(name), identity_, shard, why_);
    if (!file) ADD_FAILURE() << why_;
    return file;
  }
  std::string refusal(const std::string& name, const Shard& shard = {}) {
    std::string why;
    EXPECT_EQ(ResultsFile::open(path(name), identity_, shard, why), nullptr);
    return why;
  }
  static Json result(std::uint64_t number) {
    return {{"run", "robot.toml --seed " + std::to_string(number)}, {"good", true}};
  }
  void append(ResultsFile& file, std::uint64_t number) {
    ASSERT_TRUE(file.append(number, result(number), why_)) << why_;
  }
  /// A file with these cases, finished.
  void make(const std::string& name, const std::vector<std::uint64_t>& cases, const Shard& shard = {}) {
    const auto file = open(name, shard);
    for (const std::uint64_t c : cases) append(*file, c);
    ASSERT_TRUE(file->finish(identity_.cases, why_)) << why_;
  }

  fs::path folder_;
  Identity identity_{10, {{"seeds", "1..10"}, {"contents", {{"program", "ab"}}}}};
  std::string why_;
};

TEST_F(SweepResults, TheOrderInWhichCasesEndLeavesNoTraceInAFinishedFile) {
  make("a", {0, 1, 2, 3, 4, 5, 6, 7, 8, 9});
  make("b", {9, 3, 1, 0, 2, 8, 7, 6, 5, 4});
  EXPECT_EQ(content(path("a")), content(path("b")));
  EXPECT_THAT(content(path("a")),
              HasSubstr("\n{\"case\":3,\"run\":\"robot.toml --seed 3\",\"good\":true}\n{\"case\":4,"));
  EXPECT_FALSE(fs::exists(path("b.new")));
}

TEST_F(SweepResults, AFileGoesOnWhereItStoppedWithoutItsTornLine) {
  {
    const auto file = open("a");
    append(*file, 4);
    append(*file, 2);
  }
  std::ofstream(path("a"), std::ios::app) << "{\"case\":7,\"run\":\"rob";
  const auto file = open("a");
  EXPECT_EQ(file->count(), 2u);
  EXPECT_TRUE(file->has(4) && file->has(2));
  EXPECT_FALSE(file->has(7));
  for (const std::uint64_t c : {0, 1, 3, 5, 6, 7, 8, 9}) append(*file, c);
  ASSERT_TRUE(file->finish(10, why_)) << why_;
  make("whole", {0, 1, 2, 3, 4, 5, 6, 7, 8, 9});
  EXPECT_EQ(content(path("a")), content(path("whole")));
}

TEST_F(SweepResults, AFileThatWasKilledInItsFirstLineBeginsAnew) {
  std::ofstream(path("a")) << "{\"sinew_sw";
  const auto file = open("a");
  append(*file, 0);
  EXPECT_THAT(content(path("a")), HasSubstr("{\"sinew_sweep\":1,\"cases\":10,"));
}

TEST_F(SweepResults, AFileOfAnotherSweepIsRefusedWithWhatDiffers) {
  make("a", {1});
  identity_.what["seeds"] = "1..20";
  identity_.what["contents"]["program"] = "cd";
  identity_.what["camera"] = "64x48";
  EXPECT_THAT(refusal("a"),
              HasSubstr("results of another sweep: seeds: 1..10 there, 1..20 here; contents.program: ab there, "
                        "cd here; camera: none there, 64x48 here"));
  identity_ = {};
  EXPECT_THAT(refusal("a"), HasSubstr("cases: 10 there, 0 here"));
}

TEST_F(SweepResults, AnotherPartOfTheSameSweepIsRefused) {
  make("a", {1}, {1, 2});
  EXPECT_THAT(refusal("a"), HasSubstr("shard: 2/2 there, 1/1 here"));
  EXPECT_THAT(refusal("a", {0, 2}), HasSubstr("shard: 2/2 there, 1/2 here"));
}

TEST_F(SweepResults, WhatIsNoFileOfResultsIsLeftAsItIs) {
  for (const char* const text : {"hello\nworld\n", "hello", "{\"sinew_sweep\":9,\"cases\":1,\"what\":{}}\n",
                                 "{\"sinew_sweep\":1,\"cases\":-1,\"what\":{}}\n",
                                 "{\"sinew_sweep\":1,\"cases\":99999999999999,\"what\":{}}\n"}) {
    std::ofstream(path("a")) << text;
    EXPECT_THAT(refusal("a"), HasSubstr(path("a"))) << text;
    EXPECT_EQ(content(path("a")), text);
    fs::remove(path("a"));
  }
}

TEST_F(SweepResults, ALineInTheMiddleThatIsNoResultIsNamed) {
  make("a", {1, 2});
  for (const char* const line : {"{\"case\":10}", "{\"cas\":1}", "", "{\"case\":1", "{\"case\":-1}"}) {
    fs::copy_file(path("a"), path("b"), fs::copy_options::overwrite_existing);
    std::ofstream(path("b"), std::ios::app) << line << "\n{\"case\":3}\n";
    EXPECT_THAT(refusal("b"), HasSubstr(path("b") + ":4: ")) << line;
  }
}

TEST_F(SweepResults, TwoProgramsDoNotWriteOneFile) {
  const auto file = open("a");
  EXPECT_THAT(refusal("a"), HasSubstr("another program writes it now"));
  append(*file, 1);
  append(*file, 0);
  ASSERT_TRUE(file->finish(10, why_));
  EXPECT_THAT(refusal("a"), HasSubstr("another program writes it now")) << "also after the file was replaced";
  append(*file, 2);
  EXPECT_THAT(content(path("a")), HasSubstr("{\"case\":2,"));
}

TEST_F(SweepResults, AFileThatIsHeldForAMomentIsWaitedFor) {
  // As of a sweep that was killed, whose cases end a moment later.
  auto file = open("a");
  std::thread ending([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    file.reset();
  });
  EXPECT_TRUE(open("a"));
  ending.join();
}

TEST_F(SweepResults, FinishLeavesOutWhatIsBeyondTheEnd) {
  const auto file = open("a");
  for (const std::uint64_t c : {0, 1, 2, 5}) append(*file, c);
  ASSERT_TRUE(file->finish(3, why_)) << why_;
  EXPECT_EQ(file->count(), 3u);
  EXPECT_FALSE(file->has(5));
}

TEST_F(SweepResults, ShardsMergeInAnyOrderToTheUndividedFile) {
  make("whole", {0, 1, 2, 3, 4, 5, 6, 7, 8, 9});
  make("1", {0, 3, 6, 9}, {0, 3});
  make("2", {7, 4, 1}, {1, 3});
  make("3", {2, 5, 8}, {2, 3});
  Merged merged;
  for (const std::vector<std::string>& order : {std::vector{path("1"), path("2"), path("3")},
                                                {path("3"), path("1"), path("2"), path("1")},
                                                {path("2"), path("whole")}}) {
    fs::remove(path("out"));
    ASSERT_TRUE(merge_results(order, path("out"), merged, why_)) << why_;
    EXPECT_EQ(merged.missing_count, 0u);
    EXPECT_EQ(content(path("out")), content(path("whole")));
  }
}

TEST_F(SweepResults, AKilledShardsLastLineIsMissingAndTheMergedFileGoesOn) {
  make("1", {0, 2, 4, 6, 8}, {0, 2});
  make("2", {1, 3}, {1, 2});
  std::ofstream(path("2"), std::ios::app) << "{\"case\":5,\"ru";
  Merged merged;
  ASSERT_TRUE(merge_results({path("1"), path("2")}, path("out"), merged, why_)) << why_;
  EXPECT_THAT(merged.missing, ElementsAre(5, 7, 9));
  EXPECT_EQ(merged.missing_count, 3u);
  const auto file = open("out");
  EXPECT_EQ(file->count(), 7u);
}

TEST_F(SweepResults, UnequalResultsOfACaseAndOtherSweepsDoNotMerge) {
  make("1", {0, 1});
  {
    const auto file = open("2");
    ASSERT_TRUE(file->append(1, {{"run", "robot.toml --seed 1"}, {"good", false}}, why_));
  }
  Merged merged;
  EXPECT_FALSE(merge_results({path("1"), path("2")}, path("out"), merged, why_));
  EXPECT_THAT(why_, HasSubstr("case 1 has two results, in " + path("1") + " and in " + path("2")));
  EXPECT_FALSE(fs::exists(path("out")));
  identity_.what["seeds"] = "1..20";
  make("3", {2});
  EXPECT_FALSE(merge_results({path("1"), path("3")}, path("out"), merged, why_));
  EXPECT_THAT(why_, HasSubstr("are of different sweeps: seeds: 1..10 there, 1..20 here"));
  EXPECT_FALSE(merge_results({path("1"), path("nowhere")}, path("out"), merged, why_));
  EXPECT_THAT(why_, HasSubstr(path("nowhere")));
}

TEST_F(SweepResults, AFullDiskIsSaidAndNoHalfLineStays) {
  const auto file = open("a");
  append(*file, 1);
  const std::string before = content(path("a"));
  rlimit usual{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &usual), 0);
  const auto heard = std::signal(SIGXFSZ, SIG_IGN);
  const rlimit full{before.size() + 10, usual.rlim_max};
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &full), 0);
  const bool written = file->append(2, result(2), why_);
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &usual), 0);
  std::signal(SIGXFSZ, heard);
  EXPECT_FALSE(written);
  EXPECT_THAT(why_, HasSubstr(path("a") + ": file: writev: File too large"));
  EXPECT_EQ(content(path("a")), before);
  append(*file, 2);
  EXPECT_EQ(file->count(), 2u);
}

TEST_F(SweepResults, WhatIsNoOrdinaryFileIsRefused) {
  std::string why;
  for (const auto& place : {std::string("/dev/null"), folder_.string()}) {
    EXPECT_EQ(ResultsFile::open(place, identity_, {}, why), nullptr);
    EXPECT_THAT(why, HasSubstr(place));
  }
}

TEST_F(SweepResults, ALineWithoutEndIsNotReadIntoMemory) {
  const std::string long_text(std::size_t{3} << 20, 'x');
  std::ofstream(path("a")) << long_text << "\n";
  EXPECT_THAT(refusal("a"), HasSubstr("not a file of results of a sweep"));
  make("b", {1});
  std::ofstream(path("b"), std::ios::app) << long_text << "\n{\"case\":2}\n";
  EXPECT_THAT(refusal("b"), HasSubstr(path("b") + ":3: no result of a case"));
}

TEST_F(SweepResults, AFolderThatCannotBeMadeIsSaid) {
  std::ofstream(path("file")) << "x";
  EXPECT_THAT(refusal("file/sweeps/a"), HasSubstr("its folder cannot be made"));
}

}  // namespace
}  // namespace sinew::sweep::results_file_test
