// Relations between the sections of a robot file that `check` and `run` refuse alike, each with file, line and key.
#include "apps/robot/wiring_rules.hpp"

#include <gmock/gmock.h>

#include "../run/wired_head.hpp"

namespace sinew::app::wiring_rules_test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

TEST(WiringRules, ARobotThatIsWholeHasNoProblem) { EXPECT_THAT(problems(), IsEmpty()); }

// ---- modules and devices

TEST(WiringRules, AModuleWithoutItsDeviceIsRefused) {
  EXPECT_THAT(
      problems({{"[device.imu]", "[device.gyro]"}}),
      ElementsAre(at("[module.imu]") + "module.imu: \"imu\": the name of a [device.NAME] that gives imu: gyro"));
  EXPECT_THAT(problems({{"device = \"air\"", "device = \"sky\""}}),
              ElementsAre(at("params = { device = \"air\"") +
                          "module.baro.params.device: \"sky\": the name of a [device.NAME] that gives baro: air"));
}

TEST(WiringRules, AModuleOfADeviceOfAnotherKindIsRefusedOnAnyBoard) {
  const std::string said =
      "module.baro.params.device: \"imu\", with driver \"mpu6050\": a device that gives baro, as "
      "module.baro reads: driver one of bmp280, text_baro";
  const Change wrong{"device = \"air\"", "device = \"imu\""};
  EXPECT_THAT(problems({wrong}), ElementsAre(at("params = { device = \"air\"") + said));
}

LoadedRobot simulated(const std::string& sim, const std::vector<Change>& changes = {}) {
  std::vector<Change> all = changes;
  all.emplace_back("board = \"linux\"", "board = \"sim\"");
  std::string text = changed(all) + "[sim]\n" + sim;
  return parse_robot(text, "r.toml");
}
std::vector<std::string> problems_of(const LoadedRobot& loaded) {
  std::vector<std::string> out;
  for (const auto& p : loaded.problems) out.push_back(rt::to_string(p, "r.toml"));
  for (const auto& p : check_robot(loaded.robot, rt::Graph(loaded.robot.graph, all_modules()), {}))
    out.push_back(rt::to_string(p, "r.toml"));
  return out;
}

TEST(WiringRules, WithASimulatorOnlyTablesThatAreThereAreLookedAt) {
  LoadedRobot loaded = simulated("plant = \"unix:/tmp/plant\"\n");
  std::erase_if(loaded.robot.devices.devices, [](const auto& d) { return d.name == "imu"; });
  EXPECT_THAT(problems_of(loaded), IsEmpty());
  for (auto& d : loaded.robot.devices.devices)
    if (d.name == "air") d.driver = "qmc5883l";
  EXPECT_THAT(problems_of(loaded), ElementsAre(HasSubstr("a device that gives baro")));
}

TEST(WiringRules, AWorldThatIsStartedHasWhatTheRobotUses) {
  EXPECT_THAT(problems_of(simulated("world = \"desk_head\"\n")),
              ElementsAre(at("params = { device = \"air\"") + "module.baro.params.device: \"air\": the name of baro in "
                                                              "the world desk_head: there is none",
                          at("params = { device = \"head\"") + "module.joints.params.device: \"head\": the name of "
                                                               "joints in the world desk_head: joints"));
  EXPECT_THAT(problems_of(simulated("world = \"quad\"\n", {{"device = \"air\"", "device = \"baro\""}})),
              ElementsAre(HasSubstr("module.joints.params.device: \"head\""),
                          at("[actuator.head]") + "actuator.head: \"head\": the name of actuators in the world quad: "
                                                  "motors"));
}

TEST(WiringRules, AnActuatorGroupWithoutADeviceIsRefused) {
  EXPECT_THAT(problems({{"[actuator.head]", "[actuator.neck]"}}),
              ElementsAre(at("[actuator.head]") +
                          "actuator.neck: \"neck\": the name of a [device.NAME] that gives actuators: head"));
  EXPECT_THAT(
      problems({{"[actuator.head]", "[actuator.camera]"}}),
      ElementsAre(HasSubstr("actuator.camera: \"camera\", with driver \"v4l2\": a device that gives actuators")));
}

TEST(WiringRules, ABoardOfADeviceThatNobodyUsesIsRefused) {
  EXPECT_THAT(problems({{"board = \"linux\"", "board = \"linux\", device_boards = { lidar = \"sim\" }"}}),
              ElementsAre(HasSubstr("r.toml:1: robot.device_boards.lidar: \"sim\": a device that a module or an "
                                    "actuator uses: ")));
}

TEST(WiringRules, ABoardOfADeviceIsOneThatThereIs) {
  EXPECT_THAT(problems({{"board = \"linux\"", "board = \"linux\", device_boards = { camera = \"moon\" }"}}),
              ElementsAre(HasSubstr("r.toml:1: robot.device_boards.camera: \"moon\": \"sim\", \"linux\"")));
}

// ---- actuators and joints

constexpr const char* kLimit = "limit = [[-1.4, 1.4], [-1.0, 0.9]]";

TEST(WiringRules, AGroupHasAsManyChannelsAsJoints) {
  const Change third{"max_rad = 0.9\n",
                     "max_rad = 0.9\n[[device.head.joint]]\nname = \"roll\"\ndriver = \"cia402\"\nbus = \"can0\"\n"
                     "id = 3\ncounts_per_turn = 65536\nmax_rad = 1.4\nmin_rad = -1.4\n"};
  EXPECT_THAT(problems({third}),
              ElementsAre(at("channels = 2") + "actuator.head.channels: 2: 3, as [device.head] has joints"));
}

TEST(WiringRules, AGroupHasAsManyChannelsAsTheModuleThatCommandsIt) {
  EXPECT_THAT(problems({{"channels = 2", "channels = 3"}, {kLimit, "limit = [-1.4, 1.4]"}}),
              ElementsAre(at("channels = 2") +
                          "actuator.head.channels: 3: 2, as follower.command of control::HeadFollower has"));
}

TEST(WiringRules, ALimitForAllIsNoWiderThanTheWidestJoint) {
  EXPECT_THAT(problems({{kLimit, "limit = [-1.4, 1.5]"}}),
              ElementsAre(at("limit = ") + "actuator.head.limit: [-1.4, 1.5]: within [-1.4, 1.4], the widest range of "
                                           "the joints of [device.head]: what is beyond is pulled in"));
  EXPECT_THAT(problems({{kLimit, "limit = [-1.0, 0.9]"}}), IsEmpty());
}

TEST(WiringRules, ALimitOfAChannelIsNoWiderThanItsJoint) {
  EXPECT_THAT(problems({{kLimit, "limit = [[-1.4, 1.4], [-1.0, 1.0]]"}}),
              ElementsAre(at("limit = ") + "actuator.head.limit: [-1, 1]: within [-1, 0.9], the range of the joint "
                                           "tilt of [device.head]: what is beyond is pulled in"));
}

TEST(WiringRules, ALimitThatLeavesNothingToAJointIsRefusedWithItsName) {
  EXPECT_THAT(
      problems({{kLimit, "limit = [1.0, 1.4]"}}),
      ElementsAre(at("limit = ") + "actuator.head.limit: [1, 1.4]: a range that has something of [-1, 0.9], that "
                                   "of the joint tilt of [device.head]: it could follow nothing"));
}

TEST(WiringRules, AJointThatIsNarrowerThanItsGroupIsNamed) {
  const auto robot = [](const std::vector<Change>& changes) { return parse_robot(changed(changes), "r.toml").robot; };
  EXPECT_THAT(narrower_joints(robot({{kLimit, "limit = [-1.4, 1.4]"}})),
              ElementsAre("actuator.head.limit [-1.4, 1.4]: joint tilt goes from -1 to 0.9, and is pulled in beyond"));
  EXPECT_THAT(narrower_joints(robot({{kLimit, "limit = [-1.0, 0.9]"}})), IsEmpty());
  EXPECT_THAT(narrower_joints(robot({})), IsEmpty());
}

// ---- cameras and topics

TEST(WiringRules, FramesFitIntoTheirTopic) {
  EXPECT_THAT(
      problems({{"width = 640\nheight = 480\nformat = \"yuyv\"", "width = 1280\nheight = 720\nformat = \"rgb8\""}}),
      ElementsAre(at("width = 640\nheight") + "device.camera: 1280x720 rgb8, 2764800 bytes: at most 614400 bytes, as "
                                              "topic.\"camera.raw\".image has room for: every frame would be dropped"));
  EXPECT_THAT(
      problems({{"width = 640\nheight = 480\nformat = \"yuyv\"", "width = 320\nheight = 240\nformat = \"rgb8\""}}),
      IsEmpty())
      << "smaller is fine";
}

TEST(WiringRules, FramesOfTheSimulatorFitIntoTheirTopic) {
  const std::string world = "world = \"desk_head\"\n", size = "camera_width = 1280\ncamera_height = 960\n";
  EXPECT_THAT(problems_of(simulated(world + size)),
              ::testing::Contains(HasSubstr("sim.camera: 1280x960 yuyv, 2457600")));
  EXPECT_THAT(problems_of(simulated(world)), ::testing::Not(::testing::Contains(HasSubstr("sim.camera"))));
  EXPECT_THAT(problems_of(simulated("plant = \"unix:/tmp/plant\"\n" + size)), IsEmpty()) << "another's own size";
}

// ---- joints and buses

TEST(BusRules, TwoJointsOfOneNameAreRefusedAtTheSecond) {
  EXPECT_THAT(problems({{"name = \"tilt\"", "name = \"pan\""}}),
              ElementsAre(at("[[device.head.joint]]\nname = \"tilt\"") +
                          "device.head.joint.pan: \"pan\": a name that no other joint of head has"));
}

TEST(BusRules, TwoJointsOfOneNumberAreRefusedAtTheSecond) {
  EXPECT_THAT(problems({{"id = 2", "id = 1"}}),
              ElementsAre(at("id = 2") + "device.head.joint.tilt.id: 1: a number that no other servo on its bus has: "
                                         "'pan' has it (bus can0)"));
}

constexpr Change kPanMit{"driver = \"cia402\"\nbus = \"can0\"\nid = 1\ncounts_per_turn = 65536\n",
                         "driver = \"mit\"\nbus = \"can0\"\nid = 1\nmotor = \"ak80_9\"\nkp = 40.0\nkd = 2.0\n"};

TEST(BusRules, OneNumberOfTwoProtocolsIsFineWhereTheirFramesDiffer) {
  EXPECT_THAT(problems({kPanMit, {"id = 2", "id = 1"}}), IsEmpty());
}

TEST(BusRules, TwoProtocolsThatListenToOneIdentifierAreRefused) {
  const Change answers{"motor = \"ak80_9\"", "motor = \"ak80_9\"\nmaster_id = 0x182"};  // TPDO1 of node 2
  EXPECT_THAT(problems({kPanMit, answers}),
              ElementsAre(HasSubstr("device.head.joint.tilt.id: 2: a number whose frames are not taken for those of "
                                    "'pan' (bus can0)")));
}

TEST(BusRules, AMotorThatAnswersUnderTheNumberOfAnotherIsRefused) {
  const Change tilt{
      "driver = \"cia402\"\nbus = \"can0\"\nid = 2\ncounts_per_turn = 65536\n",
      "driver = \"mit\"\nbus = \"can0\"\nid = 2\nmotor = \"ak80_9\"\nkp = 40.0\nkd = 2.0\nmaster_id = 1\n"};
  EXPECT_THAT(problems({kPanMit, tilt}),
              ElementsAre(HasSubstr("device.head.joint.tilt.master_id: 1: no number of a motor: what it answers would "
                                    "be a command to 'pan' (bus can0)")));
  const Change same{"id = 2\nmotor", "id = 1\nmotor"}, elsewhere{"master_id = 1", "master_id = 5"};
  EXPECT_THAT(problems({kPanMit, tilt, same, elsewhere}),
              ElementsAre(HasSubstr("device.head.joint.tilt.id: 1: a number that no other servo on its bus has")))
      << "commands go by the number alone";
}

TEST(BusRules, ADronecanNodeDoesNotHaveOurNumber) {
  const Change pan{"driver = \"cia402\"\nbus = \"can0\"\nid = 1\ncounts_per_turn = 65536\n",
                   "driver = \"dronecan\"\nbus = \"can0\"\nid = 9\nactuator_id = 0\non_stop = \"hold\"\n"};
  EXPECT_THAT(problems({pan, {"address = 7", "address = 7\ndronecan_node = 9"}}),
              ElementsAre(HasSubstr("device.head.joint.pan.id: 9: another number than the bus's dronecan_node")));
}

TEST(BusRules, LoadIsPlannedByTheHubsOwnFunctionAndToldWithItsKey) {
  EXPECT_THAT(
      problems({{"max_load_percent = 80", "max_load_percent = 80\nbit_rate = 250000"}}),
      ElementsAre(HasSubstr(at("max_load_percent = 80") + "bus.can0.max_load_percent: 80: 2 servos at 500 Hz need ")));
}

// ---- things that only one module or device can have

TEST(DeviceClaims, TwoDevicesOnOneSerialLineAreRefused) {
  const Change two{"[device.air]\n",
                   "[device.gnss]\ndriver = \"gnss\"\npath = \"/dev/ttyS1\"\n[device.range]\ndriver = "
                   "\"tfmini\"\npath = \"/dev/ttyS1\"\n[device.air]\n"};
  EXPECT_THAT(problems({two}), ElementsAre(HasSubstr("device.range.path: \"serial line /dev/ttyS1\": one that no other "
                                                     "has: it is [device.gnss]'s")));
}

TEST(DeviceClaims, ChipsShareABusButNoAddress) {
  EXPECT_THAT(
      problems({{"[device.air]\n", "[device.other]\ndriver = \"icm42600\"\npath = \"/dev/i2c-1\"\n[device.air]\n"}}),
      ElementsAre(HasSubstr("chip at /dev/i2c-1, address 104")));
}

TEST(DeviceClaims, TwoBusesDoNotHaveOneAddress) {
  EXPECT_THAT(problems({{"[device.imu]", "[bus.can1]\ndriver = \"udp\"\naddress = 7\n[device.imu]"}}),
              ElementsAre(HasSubstr("bus.can1.address: \"udp bus 7\": one that no other has: it is [bus.can0]'s")));
}

TEST(DeviceClaims, PlacesAreComparedByWhatTheyMean) {
  const auto bus = [](const std::string& address) {
    return problems({{"[device.imu]", "[bus.can1]\ndriver = \"udp\"\naddress = \"" + address + "\"\n[device.imu]"}});
  };
  EXPECT_THAT(bus("239.65.82.7"), ElementsAre(HasSubstr("bus.can1.address: \"udp bus 7\": one that no other has")));
  EXPECT_THAT(bus("7:lo"), ElementsAre(HasSubstr("bus.can1.address: \"udp bus 7\": one that no other has")));
  EXPECT_THAT(bus("7:eth0"), IsEmpty());
  const auto before_air = [](const std::string& tables) {
    return problems({{"[device.air]\n", tables + "[device.air]\n"}});
  };
  EXPECT_THAT(before_air("[device.gnss]\ndriver = \"gnss\"\npath = \"/dev/ttyS1\"\n"
                         "[device.range]\ndriver = \"tfmini\"\npath = \"/dev//ttyS1\"\n"),
              ElementsAre(HasSubstr("device.range.path: \"serial line /dev/ttyS1\": one that no other has")));
  EXPECT_THAT(before_air("[device.other]\ndriver = \"icm42600\"\npath = \"/dev//i2c-1\"\naddress = 104\n"),
              ElementsAre(HasSubstr("chip at /dev/i2c-1, address 104")));
  EXPECT_THAT(before_air("[device.both]\ndriver = \"iio\"\nname = \"accel_3d,gyro_3d\"\n"
                         "[device.one]\ndriver = \"iio\"\nname = \"gyro_3d\"\n"),
              ElementsAre(HasSubstr("device.one.name: \"IIO device gyro_3d\": one that no other has")));
}

TEST(DeviceClaims, TwoSimulatedCamerasMayHaveOneNodeInDifferentFolders) {
  const auto second = [](const std::string& root) {
    return problems({{"[device.camera]\n", "[device.second]\ndriver = \"v4l2\"\npath = \"/dev//video0\"\nroot = \"" +
                                               root + "\"\n[device.camera]\n"}});
  };
  EXPECT_THAT(second("/tmp/wire"), IsEmpty());
  EXPECT_THAT(second("//"), ElementsAre(HasSubstr("\"camera /dev/video0\": one that no other has")));
}

// ---- conditions outside of the file

TEST(OptionLines, TellWhereAValueComesFrom) {
  OptionLines lines;
  const int first = lines.line_of("--board moon"), second = lines.line_of("--set bus.can0.address=x");
  EXPECT_LT(first, 0);
  RobotFile robot;
  robot.path = "r.toml";
  EXPECT_EQ(lines.told({second, "bus.can0.address", "\"x\"", "a bus"}, robot),
            "from --set bus.can0.address=x: bus.can0.address: \"x\": a bus");
  EXPECT_EQ(lines.told({first, "robot.board", "\"moon\"", "none"}, robot),
            "from --board moon: robot.board: \"moon\": none");
  EXPECT_EQ(lines.told({4, "robot.board", "\"moon\"", "none"}, robot), "r.toml:4: robot.board: \"moon\": none");
}

}  // namespace
}  // namespace sinew::app::wiring_rules_test
