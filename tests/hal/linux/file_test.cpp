#include "hal/linux/file.hpp"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace sinew::hal::file_test {
namespace {

class File : public testing::Test {
 protected:
  File() {
    std::string pattern = (std::filesystem::temp_directory_path() / "sinew-file-XXXXXX").string();
    EXPECT_NE(::mkdtemp(pattern.data()), nullptr);
    folder_ = pattern;
  }
  ~File() override { std::filesystem::remove_all(folder_); }
  std::string path(const char* name) const { return folder_ + "/" + name; }
  static std::string read(InputFile& file, std::uint64_t offset, std::size_t size) {
    std::string text(size, '\0');
    EXPECT_TRUE(file.read_at(offset, std::as_writable_bytes(std::span(text))));
    return text;
  }
  std::string folder_;
};

std::span<const std::byte> bytes(std::string_view text) { return std::as_bytes(std::span(text)); }

TEST_F(File, PartsArriveInOrderHoweverManyThereAre) {
  auto out = create_file(path("a"));
  ASSERT_TRUE(out);
  std::vector<std::string> texts;
  std::string all;
  for (int i = 0; i < 100; ++i)
    all += texts.emplace_back(static_cast<std::size_t>(i % 5), static_cast<char>('a' + i % 26));
  std::vector<std::span<const std::byte>> parts;
  for (const auto& text : texts) parts.push_back(bytes(text));
  ASSERT_TRUE((*out)->append(parts));
  ASSERT_TRUE((*out)->sync());
  auto in = open_file(path("a"));
  ASSERT_TRUE(in);
  EXPECT_EQ((*in)->size(), all.size());
  EXPECT_EQ(read(**in, 0, all.size()), all);
  EXPECT_EQ(read(**in, 17, 5), all.substr(17, 5));
}

TEST_F(File, OneThatIsRemovedCanBeMadeAgain) {
  auto out = create_file(path("a"));
  ASSERT_TRUE(out);
  ASSERT_TRUE((*out)->remove());
  EXPECT_FALSE(std::filesystem::exists(path("a")));
  EXPECT_EQ((*out)->remove().error().detail, ENOENT);
  EXPECT_TRUE(create_file(path("a")));
}

TEST_F(File, WhatIsCutOffIsGoneAndWritingGoesOnThere) {
  auto out = create_file(path("a"));
  ASSERT_TRUE(out);
  const std::array first = {bytes("0123456789")}, second = {bytes("abc")};
  ASSERT_TRUE((*out)->append(first));
  ASSERT_TRUE((*out)->cut(4));
  ASSERT_TRUE((*out)->append(second));
  auto in = open_file(path("a"));
  EXPECT_EQ(read(**in, 0, static_cast<std::size_t>((*in)->size())), "0123abc");
}

TEST_F(File, NothingThatExistsIsOverwritten) {
  ASSERT_TRUE(create_file(path("a")));
  EXPECT_EQ(create_file(path("a")).error().code, Errc::busy);
  EXPECT_EQ(create_file(path("none/a")).error().code, Errc::not_found);
}

TEST_F(File, OnlyOrdinaryFilesAreRead) {
  EXPECT_EQ(open_file(path("a")).error().code, Errc::not_found);
  EXPECT_EQ(open_file(folder_).error().code, Errc::bad_argument);
  ASSERT_EQ(::mkfifo(path("fifo").c_str(), 0600), 0);
  EXPECT_EQ(open_file(path("fifo")).error().code, Errc::bad_argument);  // and does not wait for a writer
}

TEST_F(File, ReadingBeyondTheEndIsSaid) {
  auto out = create_file(path("a"));
  const std::array part = {bytes("0123")};
  ASSERT_TRUE((*out)->append(part));
  auto in = open_file(path("a"));
  std::array<std::byte, 3> into;
  const auto done = (*in)->read_at(2, into);
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().code, Errc::bad_data);
  EXPECT_EQ(done.error().detail, 4);
}

TEST_F(File, ADiskThatIsFullIsAnErrorWithItsNumber) {
  // A limit on the size of files plays the full disk; its signal would end us.
  const auto before = std::signal(SIGXFSZ, SIG_IGN);
  rlimit limit{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &limit), 0);
  const rlimit small{1000, limit.rlim_max};
  auto out = create_file(path("a"));
  ASSERT_TRUE(out);
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
  const std::string text(700, 'x');
  const std::array part = {bytes(text)};
  const bool first = bool((*out)->append(part));
  const auto second = (*out)->append(part);
  ::setrlimit(RLIMIT_FSIZE, &limit);
  std::signal(SIGXFSZ, before);
  EXPECT_TRUE(first);
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().code, Errc::io);
  EXPECT_EQ(second.error().detail, EFBIG);
  ASSERT_TRUE((*out)->cut(700));  // the part of it that arrived
  EXPECT_EQ((*open_file(path("a")))->size(), 700u);
}

TEST_F(File, TheDiskHasRoom) {
  auto out = create_file(path("a"));
  const auto free = (*out)->free_bytes();
  ASSERT_TRUE(free);
  EXPECT_GT(*free, 0u);
  EXPECT_LE(*free, std::filesystem::space(folder_).capacity);
}

}  // namespace
}  // namespace sinew::hal::file_test
