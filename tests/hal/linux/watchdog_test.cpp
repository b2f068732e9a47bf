#include "hal/linux/watchdog.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>

namespace sinew::hal::watchdog_test {
namespace {

using namespace std::chrono_literals;

// A pipe replaces the device: the test can read what is written.
class WatchdogPipe : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = (std::filesystem::temp_directory_path() / "sinew_watchdog_XXXXXX").string();
    ASSERT_NE(::mkdtemp(folder_.data()), nullptr);
    path_ = folder_ + "/watchdog";
    ASSERT_EQ(::mkfifo(path_.c_str(), 0600), 0);
    read_end_ = ::open(path_.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
    ASSERT_GE(read_end_, 0);
  }
  void TearDown() override {
    ::close(read_end_);
    std::filesystem::remove_all(folder_);
  }
  std::string written() {
    char buffer[64];
    const auto n = ::read(read_end_, buffer, sizeof(buffer));
    return n > 0 ? std::string(buffer, static_cast<std::size_t>(n)) : std::string();
  }
  std::string folder_, path_;
  int read_end_ = -1;
};

TEST_F(WatchdogPipe, EveryFeedIsOneWrite) {
  auto watchdog = open_watchdog(path_, 2s);
  ASSERT_TRUE(watchdog);
  EXPECT_EQ((*watchdog)->timeout(), 2s);
  EXPECT_EQ(written(), "") << "opening feeds nothing";
  EXPECT_TRUE((*watchdog)->feed());
  EXPECT_TRUE((*watchdog)->feed());
  EXPECT_EQ(written(), std::string(2, '\0'));
}

TEST_F(WatchdogPipe, OnlyReleaseDisarms) {
  auto watchdog = open_watchdog(path_, 2s);
  ASSERT_TRUE(watchdog);
  EXPECT_TRUE((*watchdog)->feed());
  EXPECT_TRUE((*watchdog)->release());
  EXPECT_EQ(written(), std::string("\0V", 2));
  auto other = open_watchdog(path_, 2s);
  ASSERT_TRUE(other);
  other->reset();
  EXPECT_EQ(written(), "") << "closing alone must leave it armed";
}

TEST_F(WatchdogPipe, FullDeviceIsAnErrorAndNoWait) {
  auto watchdog = open_watchdog(path_, 2s);
  ASSERT_TRUE(watchdog);
  Status fed;
  for (int i = 0; i < 2'000'000 && fed; ++i) fed = (*watchdog)->feed();
  ASSERT_FALSE(fed);
  EXPECT_EQ(fed.error().code, Errc::io);
}

TEST(Watchdog, WhatIsNotThereIsNotFound) {
  auto watchdog = open_watchdog("/no/such/watchdog", 2s);
  ASSERT_FALSE(watchdog);
  EXPECT_EQ(watchdog.error().code, Errc::not_found);
}

TEST(Watchdog, TimeoutBelowOneSecondIsRefused) {
  auto watchdog = open_watchdog("/no/such/watchdog", 999ms);
  ASSERT_FALSE(watchdog);
  EXPECT_EQ(watchdog.error().code, Errc::bad_argument);
}

}  // namespace
}  // namespace sinew::hal::watchdog_test
