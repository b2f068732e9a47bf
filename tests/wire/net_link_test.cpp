#include "wire/net_link.hpp"

#include <gtest/gtest.h>

#include <array>
#include <vector>

namespace sinew::wire::net_link_test {
namespace {

using Bytes = std::vector<std::uint8_t>;

Bytes written(const NetLinkPacket& p) {
  Bytes out(kNetLinkHeadBytes + p.payload.size());
  out.resize(write_net_link(p, out));
  return out;
}

TEST(NetLinkTest, WhatIsHeardHasItsSenderItsLossesAndItsInstant) {
  const Bytes datagram{1, 2, 3};
  const Bytes bytes = written({NetLinkKind::heard, 0x01020304, 5, -7, datagram});
  ASSERT_EQ(bytes.size(), 23u);
  const auto p = read_net_link(bytes);
  ASSERT_TRUE(p);
  EXPECT_EQ(p->kind, NetLinkKind::heard);
  EXPECT_EQ(p->sender, 0x01020304u);
  EXPECT_EQ(p->lost, 5u);
  EXPECT_EQ(p->stamp_ns, -7);
  EXPECT_EQ(Bytes(p->payload.begin(), p->payload.end()), datagram);
}

TEST(NetLinkTest, TheBytesAreThoseOfThePage) {
  const Bytes datagram{0xAB};
  EXPECT_EQ(written({NetLinkKind::heard, 0x01020304, 5, 0x0807060504030201, datagram}),
            (Bytes{1, 3, 0, 0, 4, 3, 2, 1, 5, 0, 0, 0, 1, 2, 3, 4, 5, 6, 7, 8, 0xAB}));
}

TEST(NetLinkTest, PacketsThatDoNotFitTheirKindAreNeitherReadNorWritten) {
  const Bytes much(kNetLinkMostDatagram + 1), one{1};
  EXPECT_TRUE(written({NetLinkKind::say, 0, 0, 0, much}).empty());
  EXPECT_TRUE(written({NetLinkKind::say, 0, 0, 0, {}}).empty());
  EXPECT_TRUE(written({NetLinkKind::hello, 0, 0, 0, one}).empty());
  EXPECT_TRUE(written({NetLinkKind::say, 1, 0, 0, one}).empty()) << "a robot does not say who it is";
  Bytes bytes = written({NetLinkKind::say, 0, 0, 0, one});
  bytes[1] = 7;
  EXPECT_FALSE(read_net_link(bytes));
  bytes[1] = 2, bytes[0] = 2;
  EXPECT_FALSE(read_net_link(bytes)) << "another version";
  EXPECT_FALSE(read_net_link(Bytes(kNetLinkHeadBytes - 1, 1)));
}

}  // namespace
}  // namespace sinew::wire::net_link_test
