// Which boards may share a robot, both ways.
#include "apps/robot/board_rules.hpp"

#include <gmock/gmock.h>

namespace sinew::app::board_rules_test {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

/// The rules know what a board is, not its name: they are checked with a real one that only a test has.
constexpr BoardKind kBoards[] = {{"sim", false, true}, {"dataset", false, false}, {"bench", true, true}};

rt::GraphSpec robot(const char* board, std::map<std::string, std::string> devices) {
  rt::GraphSpec r;
  r.board = board;
  r.actuators.push_back({.name = "motors", .line = 9});
  for (const auto& [device, of] : devices) r.device_boards[device] = {of, 3};
  return r;
}

std::vector<std::string> problems(const rt::GraphSpec& r, BoardUse use = {}) {
  std::vector<std::string> out;
  for (const auto& p : check_boards(r, use, kBoards)) out.push_back(rt::to_string(p, "r.toml"));
  return out;
}

TEST(BoardRules, OneBoardForAllIsFineInAnyTime) {
  for (const bool virtual_time : {false, true}) {
    EXPECT_THAT(problems(robot("sim", {}), {.virtual_time = virtual_time}), IsEmpty());
  }
  EXPECT_THAT(problems(robot("bench", {})), IsEmpty());
}

TEST(BoardRules, RecordedCameraOnASimulatedRobotIsFineInAnyTime) {
  for (const bool virtual_time : {false, true}) {
    EXPECT_THAT(problems(robot("sim", {{"camera", "dataset"}}), {.virtual_time = virtual_time}), IsEmpty());
  }
}

TEST(BoardRules, UnknownBoardIsNamedWithTheKnownOnes) {
  EXPECT_THAT(problems(robot("sim", {{"camera", "moon"}})),
              ElementsAre("r.toml:3: robot.device_boards.camera: \"moon\": \"sim\", \"dataset\", \"bench\""));
}

TEST(BoardRules, VirtualTimeTakesNoRealDevice) {
  const auto mixed = robot("sim", {{"imu", "bench"}});
  EXPECT_THAT(problems(mixed), IsEmpty());
  EXPECT_THAT(
      problems(mixed, {.virtual_time = true}),
      ElementsAre("r.toml:3: robot.device_boards.imu: \"bench\": a simulated or recorded board: in virtual time "
                  "no real device waits for a grant"));
  EXPECT_EQ(problems(robot("bench", {}), {.virtual_time = true}).size(), 1u);
}

TEST(BoardRules, RealDeviceBesideARecordIsRefused) {
  EXPECT_THAT(problems(robot("dataset", {{"imu", "bench"}})),
              ElementsAre("r.toml:3: robot.device_boards.imu: \"bench\": a real robot.board with the others named per "
                          "device: a run ends with its own board"));
}

TEST(BoardRules, AnyDeviceOnTheSimBoardNeedsAPlant) {
  EXPECT_TRUE(needs_plant(robot("sim", {})));
  EXPECT_TRUE(needs_plant(robot("linux", {{"imu", "sim"}})));
  EXPECT_FALSE(needs_plant(robot("linux", {{"imu", "dataset"}})));
  EXPECT_FALSE(needs_plant(robot("none", {})));
}

TEST(BoardRules, RealActuatorsWithSimulatedSensorsNeedThePermission) {
  const auto mixed = robot("sim", {{"motors", "bench"}});
  EXPECT_THAT(problems(mixed),
              ElementsAre("r.toml:9: actuator.motors: \"bench\": real actuators with simulated sensors "
                          "(all other devices: sim) only with --real-actuators"));
  EXPECT_THAT(problems(mixed, {.real_actuators = true}), IsEmpty());
  const auto one_sensor = robot("bench", {{"camera", "sim"}});
  EXPECT_THAT(problems(one_sensor), ElementsAre("r.toml:9: actuator.motors: \"bench\": real actuators with simulated "
                                                "sensors (camera: sim) only with --real-actuators"));
  EXPECT_THAT(problems(one_sensor, {.real_actuators = true}), IsEmpty());
}

TEST(BoardRules, SimulatedActuatorsOfRealSensorsMoveNothing) {
  EXPECT_THAT(problems(robot("bench", {{"motors", "sim"}})), IsEmpty());
}

TEST(BoardRules, PermissionDoesNotMakeVirtualTimeTakeRealDevices) {
  EXPECT_EQ(problems(robot("sim", {{"motors", "bench"}}), {.virtual_time = true, .real_actuators = true}).size(), 1u);
}

TEST(BoardRules, RecordHasNoActuators) {
  EXPECT_THAT(problems(robot("sim", {{"motors", "dataset"}})),
              ElementsAre("r.toml:3: robot.device_boards.motors: \"dataset\": a board with actuators, as "
                          "[actuator.motors] needs one"));
}

TEST(BoardRules, PlantBesideARecordIsTheBoard) {
  EXPECT_THAT(problems(robot("dataset", {{"imu", "sim"}})),
              ElementsAre("r.toml:3: robot.device_boards.imu: \"sim\": robot.board = \"sim\" with other boards per "
                          "device: one plant, one source of time"));
}

TEST(BoardRules, FaultOfASimulatedDeviceThatThisRunHasFromElsewhereReachesNobody) {
  const auto mixed = robot("linux", {{"camera", "sim"}});
  EXPECT_EQ(unfelt_fault(mixed, "joints:off@1"),
            "--fault: 'joints:off@1' strikes the simulator's joints, and this run has it from the board linux");
  EXPECT_EQ(unfelt_fault(mixed, "camera:off@1"), "");
  EXPECT_EQ(unfelt_fault(mixed, "link:closed@1"), "");
  EXPECT_EQ(unfelt_fault(robot("sim", {}), "joints:off@1"), "");
}

TEST(BoardRules, FaultOfARadioThatNothingUsesReachesNobody) {
  auto alone = robot("sim", {});
  EXPECT_EQ(unfelt_fault(alone, "radio:off@1"),
            "--fault: 'radio:off@1' strikes a radio, and this robot has none: its file has no [team]");
  alone.modules.push_back({.name = "mates", .type = "team::Link"});
  EXPECT_EQ(unfelt_fault(alone, "radio:off@1"), "");
}

}  // namespace
}  // namespace sinew::app::board_rules_test
