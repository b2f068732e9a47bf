// Two keys that mean one place are one place.
#include "drivers/device_place.hpp"

#include <gtest/gtest.h>

namespace sinew::drivers::device_place_test {
namespace {

TEST(DevicePlace, PathsAreComparedByTheirParts) {
  EXPECT_EQ(place_of_path("/dev//ttyS0"), "/dev/ttyS0");
  EXPECT_EQ(place_of_path("//dev/./ttyS0/"), "/dev/ttyS0");
  EXPECT_EQ(place_of_path("/dev/x/../ttyS0"), "/dev/x/../ttyS0") << "x may be a link to anywhere";
  EXPECT_EQ(place_of_path("///"), "/");
  EXPECT_EQ(place_of_path(""), "");
  EXPECT_EQ(place_of_path("./tmp//wire"), "tmp/wire");
  EXPECT_NE(place_of_path("tmp/wire"), place_of_path("/tmp/wire"));
}

TEST(DevicePlace, WhatIsUnderAFolderIsAnotherThanTheMachines) {
  EXPECT_EQ(place_under("camera /dev/video0", "/"), "camera /dev/video0");
  EXPECT_EQ(place_under("camera /dev/video0", "//"), "camera /dev/video0");
  EXPECT_EQ(place_under("camera /dev/video0", "/tmp//wire/"), "camera /dev/video0 under /tmp/wire");
}

TEST(DevicePlace, ACameraIsOneByItsNodeAndByItsNameById) {
  EXPECT_EQ(place_of_camera("/dev//video0"), "/dev/video0");
  EXPECT_EQ(place_of_camera("/dev/v4l/by-id/usb-ACME-video-index0"), "usb-ACME");
  EXPECT_EQ(place_of_camera("usb-ACME-video-index0"), "usb-ACME");
  EXPECT_EQ(place_of_camera("usb-ACME-video-index1"), "usb-ACME-video-index1") << "another node of it";
}

TEST(DevicePlace, AUdpBusIsItsNumberAndItsInterface) {
  for (const char* same : {"7", "007", "239.65.82.7", "7:lo", "239.65.82.007:lo"})
    EXPECT_EQ(place_of_bus("udp", same), "7") << same;
  EXPECT_EQ(place_of_bus("udp", "0"), "0");
  EXPECT_EQ(place_of_bus("udp", "239.65.82.7:eth0"), "7:eth0");
  EXPECT_NE(place_of_bus("udp", "7"), place_of_bus("udp", "70"));
}

TEST(DevicePlace, AServedBusIsItsHostPortAndBus) {
  for (const char* same : {"localhost:29536/can0", "LocalHost:029536/can0", "127.0.0.1:29536/can0", "[::1]:29536/can0"})
    EXPECT_EQ(place_of_bus("socketcand", same), "localhost:29536/can0") << same;
  EXPECT_EQ(place_of_bus("socketcand", "Bench:29536/CAN0"), "bench:29536/CAN0") << "names of interfaces know case";
  EXPECT_NE(place_of_bus("socketcand", "bench:29536/can0"), place_of_bus("socketcand", "bench:29537/can0"));
  EXPECT_EQ(place_of_bus("socketcan", "can0"), "can0");
}

}  // namespace
}  // namespace sinew::drivers::device_place_test
