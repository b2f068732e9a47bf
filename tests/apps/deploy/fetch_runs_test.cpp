#include "apps/deploy/fetch_runs.hpp"

#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>

#include "hal/linux/run_dir.hpp"

namespace sinew::app::fetch_runs_test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
namespace fs = std::filesystem;

class FetchRuns : public ::testing::Test {
 protected:
  FetchRuns() : into_(fs::path(::testing::TempDir()) / ("fetch_runs_" + std::to_string(hal::process_id()))) {
    fs::remove_all(into_), fs::create_directories(into_);
  }
  ~FetchRuns() override { fs::remove_all(into_); }
  void file(const std::string& name, const std::string& text) {
    fs::create_directories((into_ / name).parent_path());
    std::ofstream(into_ / name, std::ios::binary) << text;
  }
  std::string content(const std::string& name) {
    std::ifstream in(into_ / name, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  FetchPlan plan(const std::string& lines) { return plan_fetch(parse_listing("1000", lines), into_.string()); }
  /// As the board sends it, in pieces of so many bytes.
  std::string feed(FetchSink& sink, const std::string& bytes, std::size_t piece) {
    for (std::size_t at = 0; at < bytes.size(); at += piece) sink.take(std::string_view(bytes).substr(at, piece));
    return sink.failure();
  }
  static std::string sent(const std::string& text, const std::string& whole) {
    PosixCksum sum;
    sum.add(whole);
    return text + "\n::sinew end " + std::to_string(sum.value()) + " " + std::to_string(whole.size()) + "\n";
  }
  fs::path into_;
};

TEST_F(FetchRuns, TheChecksumIsThatOfTheUtility) {
  PosixCksum sum;
  EXPECT_EQ(sum.value(), 4294967295u);  // cksum </dev/null
  sum.add("1234");
  sum.add("56789");
  EXPECT_EQ(sum.value(), 930766865u);  // printf 123456789 | cksum
}

TEST_F(FetchRuns, PiecesOfAnySizeBecomeTheSameFiles) {
  const FetchPlan p = plan("5 1 runs/a/run.mcap\n0 1 runs/b/empty\n3 1 runs/c/x\n");
  EXPECT_EQ(request_text(p), "0 5 runs/a/run.mcap\n0 0 runs/b/empty\n0 3 runs/c/x\n");
  const std::string bytes = "hello\n::sinew begin\n" + sent("a\n\nbc", "a\n\nbc") + sent("", "") + sent("xyz", "xyz");
  for (std::size_t piece = 1; piece < bytes.size() + 1; ++piece) {
    fs::remove_all(into_ / "runs");
    FetchSink sink(p, into_.string());
    ASSERT_EQ(feed(sink, bytes, piece), "") << piece;
    EXPECT_EQ(sink.files_done(), 3u);
    EXPECT_EQ(content("runs/a/run.mcap"), "a\n\nbc");
    EXPECT_TRUE(fs::exists(into_ / "runs/b/empty"));
    EXPECT_EQ(content("runs/c/x"), "xyz");
  }
}

TEST_F(FetchRuns, APartGoesOnAndIsCheckedAsAWhole) {
  file("runs/a/run.mcap.part", "hel");
  const FetchPlan p = plan("5 1 runs/a/run.mcap\n");
  EXPECT_EQ(request_text(p), "3 2 runs/a/run.mcap\n");
  FetchSink sink(p, into_.string());
  EXPECT_EQ(feed(sink, "::sinew begin\n" + sent("lo", "hello"), 4), "");
  EXPECT_EQ(content("runs/a/run.mcap"), "hello");
}

TEST_F(FetchRuns, WhatIsNotTheBoardsIsThrownAway) {
  file("runs/a/run.mcap.part", "XXX");
  const FetchPlan p = plan("5 1 runs/a/run.mcap\n");
  FetchSink sink(p, into_.string());
  EXPECT_THAT(feed(sink, "::sinew begin\n" + sent("lo", "hello"), 4), HasSubstr("is not what the board has"));
  EXPECT_FALSE(fs::exists(into_ / "runs/a/run.mcap"));
  EXPECT_FALSE(fs::exists(into_ / "runs/a/run.mcap.part"));
}

TEST_F(FetchRuns, AnEndInTheMiddleKeepsWhatCame) {
  const FetchPlan p = plan("5 1 runs/a/run.mcap\n");
  {
    FetchSink sink(p, into_.string());
    EXPECT_THAT(feed(sink, "::sinew begin\nhel", 4), HasSubstr("the next time goes on"));
  }
  EXPECT_EQ(content("runs/a/run.mcap.part"), "hel");
}

TEST_F(FetchRuns, NothingHereIsOverwritten) {
  file("runs/a/same", "12345");
  file("runs/a/other", "12");
  const FetchPlan p = plan("5 1 runs/a/same\n5 1 runs/a/other\n");
  EXPECT_THAT(p.parts, IsEmpty());
  EXPECT_EQ(p.here, 2u);
  EXPECT_THAT(p.different, ElementsAre("runs/a/other"));
  const FetchPlan late = plan("5 1 runs/a/late\n");
  file("runs/a/late", "somebody's");
  FetchSink sink(late, into_.string());
  EXPECT_THAT(feed(sink, "::sinew begin\n" + sent("hello", "hello"), 100), HasSubstr("left alone"));
  EXPECT_EQ(content("runs/a/late"), "somebody's");
}

TEST_F(FetchRuns, ARunWithAFreshFileIsLeftForTheNextTime) {
  const FetchPlan p = plan("5 1 runs/a/run.mcap\n5 998 runs/a/run-1.mcap\n5 990 runs/b/run.mcap\n");
  EXPECT_THAT(p.recording, ElementsAre("runs/a"));
  ASSERT_EQ(p.parts.size(), 1u);
  EXPECT_EQ(p.parts[0].name, "runs/b/run.mcap");
}

TEST_F(FetchRuns, ABoardsNamesStayBelowTheFolder) {
  const BoardListing l =
      parse_listing("1000", "5 1 ../x\n5 1 /etc/x\n5 1 a/../../x\n5 1 a\x07\n-5 1 a\n5 a\n5 1 a b\n");
  ASSERT_EQ(l.files.size(), 1u);
  EXPECT_EQ(l.files[0].name, "a b");
  EXPECT_EQ(l.problems.size(), 6u);
}

}  // namespace
}  // namespace sinew::app::fetch_runs_test
