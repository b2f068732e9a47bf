#include "monitor/foxglove/inbox.hpp"

#include <gtest/gtest.h>

namespace sinew::foxglove::inbox_test {
namespace {

Item item(std::size_t bytes, std::uint64_t time_ns = 0) {
  return {time_ns, std::make_shared<const std::vector<std::byte>>(bytes)};
}

TEST(InboxTest, TheSessionIsWokenOnceUntilItLooks) {
  int woken = 0;
  const auto backlog = std::make_shared<Backlog>([&] { ++woken; });
  Inbox inbox(10, backlog);
  inbox.put(item(1));
  inbox.put(item(1));
  EXPECT_EQ(woken, 1);
  backlog->look();
  inbox.put(item(1));
  EXPECT_EQ(woken, 2);
}

TEST(InboxTest, AfterCloseNobodyIsWoken) {
  int woken = 0;
  const auto backlog = std::make_shared<Backlog>([&] { ++woken; });
  Inbox inbox(10, backlog);
  backlog->close();
  inbox.put(item(1));
  EXPECT_EQ(woken, 0);
}

TEST(InboxTest, AllInboxesOfAConnectionShareItsBytesAndEachKeepsItsNewest) {
  const auto backlog = std::make_shared<Backlog>([] {});
  Inbox a(2000, backlog), b(2000, backlog);
  for (std::uint64_t i = 0; i < 20; ++i) a.put(item(1 << 20, i));
  EXPECT_EQ(backlog->bytes.load(), Backlog::kMostBytes);
  EXPECT_EQ(a.dropped(), 12u);
  b.put(item(1 << 20, 100));
  b.put(item(1 << 20, 101));
  EXPECT_EQ(b.take()->time_ns, 101u);
  EXPECT_FALSE(b.take());
  EXPECT_EQ(a.take()->time_ns, 12u);
}

TEST(InboxTest, WhatIsLeftInAnInboxIsGivenBackWithIt) {
  const auto backlog = std::make_shared<Backlog>([] {});
  {
    Inbox inbox(3, backlog);
    inbox.put(item(100));
  }
  EXPECT_EQ(backlog->bytes.load(), 0u);
}

}  // namespace
}  // namespace sinew::foxglove::inbox_test
