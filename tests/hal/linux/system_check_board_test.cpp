// The checks of `sinew doctor` on a robot's own devices, on machines made of files.
#include <gmock/gmock.h>

#include "made_machine.hpp"

namespace sinew::hal::system_check_board_test {
namespace {

using enum CheckState;
using ::testing::HasSubstr;
using ::testing::Not;

class Board : public Machine {
 protected:
  Board() { demand.real_board = true; }
  void node(const std::string& path, std::filesystem::perms mode) {
    file(path.substr(1), "");
    std::filesystem::permissions(root_ / path.substr(1), mode);
  }
  void can(const std::string& name, const std::string& flags, int queue) {
    file("sys/class/net/" + name + "/type", "280");
    file("sys/class/net/" + name + "/flags", flags);
    file("sys/class/net/" + name + "/tx_queue_len", std::to_string(queue));
  }
};

TEST_F(Board, OnlyARobotWithRealDevicesIsAskedAboutThem) {
  demand.real_board = false;
  demand.nodes = {{"/dev/no-such", "device.imu"}};
  for (const auto& c : check_system(SystemFiles(root_.string()), demand)) EXPECT_NE(c.id, "devices");
}

TEST_F(Board, ADeviceFileThatIsNotThereIsAProblem) {
  demand.nodes = {{"/dev/i2c-1", "device.imu"}, {"/dev/video0", "device.camera"}};
  node("/dev/video0", std::filesystem::perms(0660));
  EXPECT_EQ(look("devices").state, problem);
  EXPECT_THAT(look("devices").seen, HasSubstr("/dev/i2c-1 (device.imu) is not there"));
  EXPECT_THAT(look("devices").seen, HasSubstr("/dev/video0 (device.camera) is 0660, group "));
  node("/dev/i2c-1", std::filesystem::perms(0660));
  EXPECT_EQ(look("devices").state, ok);
}

TEST_F(Board, ADeviceFileForItsOwnerAloneIsNothingForAService) {
  demand.nodes = {{"/dev/spidev0.0", "bus.spi"}};
  node("/dev/spidev0.0", std::filesystem::perms(0600));
  EXPECT_EQ(look("devices").state, warning);
  EXPECT_THAT(look("devices").seen, HasSubstr("0600"));
  EXPECT_THAT(look("devices").advice, HasSubstr("udev rule"));
  node("/dev/spidev0.0", std::filesystem::perms(0));
  EXPECT_EQ(look("devices").state, ::geteuid() == 0 ? warning : problem) << "root may use everything";
}

TEST_F(Board, ACanInterfaceMustBeThereAndUp) {
  demand.can = {{"can0", "bus.arms", 1'000'000}};
  EXPECT_THAT(look("can").seen, HasSubstr("can0 (bus.arms) is not there"));
  file("sys/class/net/can0/type", "1");
  EXPECT_THAT(look("can").seen, HasSubstr("is no CAN interface"));
  can("can0", "0x40080", 128);
  EXPECT_EQ(look("can").state, problem);
  EXPECT_THAT(look("can").seen, HasSubstr("is down"));
  EXPECT_THAT(look("can").advice, HasSubstr("ip link set can0 up type can bitrate 1000000 restart-ms 100"));
  can("can0", "0x40081", 128);
  EXPECT_EQ(look("can").state, ok);
  EXPECT_THAT(look("can").seen, HasSubstr("its bit rate is not told here"));
  can("can0", "0x40081", 10);
  EXPECT_EQ(look("can").state, warning);
  EXPECT_THAT(look("can").advice, HasSubstr("txqueuelen 128"));
}

TEST_F(Board, WhatTheKernelTellsOfABusIsHeldAgainstTheRobotFile) {
  demand.can = {{"can0", "bus.arms", 1'000'000}};
  can("can0", "0x40081", 128);
  SystemDemand::CanFacts facts{1'000'000, 100, false};
  demand.can_facts = [&](const std::string&) { return std::optional(facts); };
  EXPECT_EQ(look("can").state, ok);
  EXPECT_THAT(look("can").seen, HasSubstr("1000000 bit/s"));
  facts.bit_rate = 500'000;
  EXPECT_EQ(look("can").state, problem);
  EXPECT_THAT(look("can").seen, HasSubstr("runs at 500000 bit/s, the robot file says 1000000"));
  facts = {1'000'000, 0, false};
  EXPECT_EQ(look("can").state, warning);
  EXPECT_THAT(look("can").advice, HasSubstr("restart-ms 100"));
  facts = {1'000'000, 100, true};
  EXPECT_EQ(look("can").state, problem);
  EXPECT_THAT(look("can").seen, HasSubstr("bus-off"));
  facts = {0, 0, false};
  EXPECT_EQ(look("can").state, ok) << "a virtual bus has neither";
}

TEST_F(Board, TheKernelMustHaveWhatTheDevicesNeed) {
  EXPECT_EQ(look("kernel_options").state, ok) << "nothing is needed";
  demand.nodes = {{"/dev/spidev0.0", "bus.spi"}};
  demand.can = {{"can0", "bus.arms", 0}};
  demand.iio = true;
  EXPECT_EQ(look("kernel_options").state, unknown) << "no configuration";
  file("proc/sys/kernel/osrelease", "6.6.1");
  file("boot/config-6.6.1", "CONFIG_CAN=m\nCONFIG_CAN_RAW=m\nCONFIG_IIO=y\n# CONFIG_SPI_SPIDEV is not set");
  EXPECT_EQ(look("kernel_options").state, problem);
  EXPECT_THAT(look("kernel_options").seen, HasSubstr("without CONFIG_IIO_BUFFER, CONFIG_SPI_SPIDEV"));
  file("boot/config-6.6.1", "CONFIG_CAN=m\nCONFIG_CAN_RAW=m\nCONFIG_IIO=y\nCONFIG_IIO_BUFFER=y\nCONFIG_SPI_SPIDEV=m");
  EXPECT_EQ(look("kernel_options").state, ok);
}

TEST_F(Board, SwapOnADiskIsNamed) {
  const std::string head = "Filename\tType\tSize\tUsed\tPriority\n";
  EXPECT_EQ(look("swap").state, unknown);
  file("proc/swaps", head);
  EXPECT_EQ(look("swap").state, ok);
  file("proc/swaps", head + "/dev/zram0 partition 1 0 -2");
  EXPECT_EQ(look("swap").state, ok) << "memory, only packed";
  file("proc/swaps", head + "/dev/zram0 partition 1 0 -2\n/var/swap file 1 0 -3");
  EXPECT_EQ(look("swap").state, warning);
  EXPECT_THAT(look("swap").seen, HasSubstr("swapped to /var/swap:"));
}

TEST_F(Board, AWritableRootIsAtTheMercyOfThePlug) {
  EXPECT_EQ(look("root").state, unknown);
  file("proc/mounts", "proc /proc proc rw 0 0\n/dev/mmcblk0p2 / ext4 rw,noatime 0 0");
  EXPECT_EQ(look("root").state, warning);
  EXPECT_THAT(look("root").seen, HasSubstr("(ext4) is writable"));
  file("proc/mounts", "/dev/mmcblk0p2 / ext4 ro,noatime 0 0\n/dev/mmcblk0p3 /data ext4 rw 0 0");
  EXPECT_EQ(look("root").state, ok);
  file("proc/mounts", "/dev/mmcblk0p2 / ext4 rw 0 0\noverlayroot / overlay rw,lowerdir=/lower 0 0");
  EXPECT_EQ(look("root").state, ok);
}

TEST_F(Board, TheWallClockShouldFollowSomebody) {
  EXPECT_EQ(look("clock_sync").state, unknown);
  file("run/systemd/timesync/synchronized", "");
  EXPECT_EQ(look("clock_sync").state, ok);
  demand.can = {};
  for (const auto& c : check_system(SystemFiles("/"), demand))
    EXPECT_FALSE(c.id == "clock_sync" && c.state == unknown) << "the live kernel says it";
}

TEST_F(Board, EveryAilmentOfABoardComesWithAdvice) {
  demand.nodes = {{"/dev/i2c-1", "device.imu"}};
  demand.can = {{"can0", "bus.arms", 0}};
  file("proc/sys/kernel/osrelease", "6.6.1");
  file("boot/config-6.6.1", "CONFIG_HIGH_RES_TIMERS=y");
  file("proc/swaps", "Filename\n/dev/sda2 partition 1 0 -2");
  file("proc/mounts", "/dev/sda1 / ext4 rw 0 0");
  int ill = 0;
  for (const auto& c : check_system(SystemFiles(root_.string()), demand)) {
    if (c.state != problem && c.state != warning) continue;
    ++ill;
    EXPECT_FALSE(c.advice.empty()) << c.id;
  }
  EXPECT_EQ(ill, 5);
}

}  // namespace
}  // namespace sinew::hal::system_check_board_test
