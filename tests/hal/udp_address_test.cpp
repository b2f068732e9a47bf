#include "hal/udp_address.hpp"

#include <gtest/gtest.h>

namespace sinew::hal::udp_address_test {
namespace {

TEST(UdpAddress, IsWrittenAsItIsRead) {
  for (const char* text : {"239.72.1.1:4580", "0.0.0.0:1", "255.255.255.255:65535", "127.0.0.1:80"}) {
    const auto address = udp_address(text);
    ASSERT_TRUE(address) << text;
    EXPECT_EQ(to_text(*address), text);
  }
  EXPECT_EQ(udp_address("192.168.1.2:4580"), (UdpAddress{0xC0A80102, 4580}));
  EXPECT_TRUE(udp_address("239.255.255.255:1")->is_multicast());
  EXPECT_FALSE(udp_address("192.168.1.2:1")->is_multicast());
}

TEST(UdpAddress, WhatIsNoneIsNothing) {
  for (const char* text :
       {"", "1.2.3.4", "1.2.3.4:", "1.2.3.4:0", "1.2.3.4:65536", "1.2.3:5", "1.2.3.4.5:6", "256.2.3.4:5", "1.2.3.-4:5",
        " 1.2.3.4:5", "1.2.3.4:5 ", "1.2.3.4:+5", "1..3.4:5", "robot2:4580", "[::1]:4580", "1.2.3.4:4580:1"})
    EXPECT_FALSE(udp_address(text)) << text;
}

}  // namespace
}  // namespace sinew::hal::udp_address_test
