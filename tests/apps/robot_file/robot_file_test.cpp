#include "apps/robot_file/robot_file.hpp"

#include <gmock/gmock.h>

namespace sinew::app::robot_file_test {
namespace {

using namespace std::chrono_literals;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::UnorderedElementsAre;

constexpr std::string_view kGood =
    R"(robot = { name = "desk", board = "sim", seed = 7, virtual_cores = 2, tap_history_ms = 2000 }

[[thread]]
name = "control"
priority = 80
period_us = 1000
phase_us = 250
overrun = "catch_up"
catch_up_max = 3
cpus = [1]
order = ["imu", "gimbal"]

[[thread]]
name = "vision"
priority = 40
device = "camera"
timeout_us = 100000
order = ["camera"]

[module]
imu    = { type = "drivers::ImuSource", exec_us = 2.5 }
gimbal = { type = "control::Level", in = { imu = "imu.raw" }, params = { kp = 1.5, on = true, n = 3, s = "x" }, exec_trace_us = [10, 20] }
camera = { type = "drivers::CameraSource", exec_measured_factor = 1.5, enabled = false }

[topic."camera.raw"]
image = { width = 640, height = 480, format = "yuyv" }
history = 5

[topic."operator.link"]
writer = "external"
type = "OperatorLink"
thread = "control"
exec_us = 2

[actuator.tilt]
command = "gimbal.tilt"
channels = 2
limit = [-0.6, 0.6]
rate_per_s = 5
lease_ms = 20
safe = "hold"

[[chain]]
name = "imu_to_tilt"
from = "imu.raw"
to = "guardian.tilt"
budget_ms = 5

[guardian]
priority = 90
arming = "manual"
exec_us = 4

[[failsafe]]
name = "camera_lost"
topic = "camera.raw"
silent_ms = 500
action = "land"
then = "stop"
then_after_ms = 20000

[[failsafe]]
name = "imu_stuck"
topic = "imu.raw"
stuck_ms = 20
action = "stop"

[[failsafe]]
name = "hot"
topic = "baro.raw"
field = "temperature_c"
below = -20
above = 70.5
for_ms = 1000
action = "land"
)";

std::vector<std::string> problems_of(std::string_view text) {
  std::vector<std::string> lines;
  for (const auto& p : parse_robot(text, "robot.toml").problems) lines.push_back(rt::to_string(p, "robot.toml"));
  return lines;
}

TEST(RobotFile, TypeAndThreadOfATopicBelongToExternalOnes) {
  EXPECT_THAT(problems_of(R"(robot = { name = "a", board = "sim" }
[topic."a.b"]
type = "OperatorLink"
[topic."c.d"]
writer = "module"
[topic."e.f"]
writer = "external"
)"),
              UnorderedElementsAre("robot.toml:3: topic.a.b.type: \"OperatorLink\": none without writer = \"external\"",
                                   "robot.toml:5: topic.c.d.writer: \"module\": one of \"external\"",
                                   "robot.toml:6: topic.e.f.type: missing: the type of a message, e.g. "
                                   "\"OperatorLink\"; it is required",
                                   "robot.toml:6: topic.e.f.thread: missing: the name of a thread; it is required"));
}

constexpr std::string_view kMate = R"(robot = { name = "ant", board = "linux" }
[team]
robot = 1
members = { ant = 1, bee = 2, cat = 3 }
bytes_per_s = 9000
say."ball.model" = { rate_hz = 5, priority = 2 }
[module.ball]
type = "my::Ball"
in.of_bee = { topic = "bee/ball.model", max_age_ms = 250 }
in.of_all = "mates/ball.model"
)";

TEST(RobotFile, ATeamBecomesAModuleThatSaysAndHears) {
  const auto loaded = parse_robot(kMate, "robot.toml");
  ASSERT_THAT(loaded.problems, IsEmpty());
  ASSERT_TRUE(loaded.robot.team);
  const team::LinkOptions& link = loaded.robot.team->link;
  EXPECT_EQ(link.robot, 1);
  ASSERT_EQ(link.mates.size(), 2u) << "the list is that of all robots, and this is one of them";
  EXPECT_EQ(link.mates[1].name, "cat");
  EXPECT_EQ(link.bytes_per_s, 9000);
  ASSERT_EQ(link.said.size(), 1u);
  EXPECT_EQ(link.said[0].priority, 2);
  EXPECT_THAT(link.heard, UnorderedElementsAre("bee/ball.model", "mates/ball.model"));
  const auto& modules = loaded.robot.graph.modules;
  EXPECT_EQ(modules.front().max_age.at("of_bee"), 250ms);
  EXPECT_EQ(modules.back().name, "mates");
  EXPECT_EQ(modules.back().in.at("say_ball_model").value, "ball.model");
}

TEST(RobotFile, WrongWordsOfATeamAreNamed) {
  const auto changed = [](const std::string& from, const std::string& to) {
    std::string text(kMate);
    text.replace(text.find(from), from.size(), to);
    return problems_of(text);
  };
  EXPECT_THAT(
      changed("topic = \"bee/", "topic = \"be/"),
      ElementsAre("robot.toml:9: module.ball.in.of_bee: \"be/ball.model\": NAME/TOPIC, NAME of mates bee cat; did "
                  "you mean bee?"));
  EXPECT_THAT(changed("topic = \"bee/", "topic = \"ant/"),
              ElementsAre(HasSubstr("\"ant/ball.model\": NAME/TOPIC, NAME of mates bee cat")));
  EXPECT_THAT(changed("cat = 3", "cat = 2"),
              ElementsAre("robot.toml:4: team.members.cat: 2: a number that no other robot of the team has"));
  EXPECT_THAT(changed("cat = 3", "mates = 3"), ElementsAre(HasSubstr("other than \"mates\"")));
  EXPECT_THAT(changed("rate_hz = 5, ", ""), ElementsAre(HasSubstr("team.say.ball.model.rate_hz: missing")));
  EXPECT_THAT(changed("say.\"ball.model\"", "say.\"bee/ball\""), ElementsAre(HasSubstr("a topic of this robot")));
  EXPECT_THAT(changed("robot = 1\n", ""), ElementsAre(HasSubstr("team.robot: missing")));
  EXPECT_THAT(changed("[module.ball]", "[module.mates]"), ElementsAre(HasSubstr("[team] makes the module mates")));
  std::string alone(kMate);
  alone.erase(alone.find("[team]"), alone.find("[module.ball]") - alone.find("[team]"));
  EXPECT_THAT(problems_of(alone),
              ElementsAre(HasSubstr("a mate's needs a table [team]"), HasSubstr("needs a table [team]")));
}

constexpr std::string_view kRos2 = R"(robot = { name = "my-quad", board = "linux" }
[ros2]
distro = "jazzy"
namespace = "/lab"
[[ros2.out]]
from = "imu.raw"
topic = "imu/data_raw"
type = "sensor_msgs/msg/Imu"
frame = "base_link"
qos = "sensor_data"
[[ros2.out]]
from = "filter.state"
topic = "/odom"
type = "nav_msgs/msg/Odometry"
qos = { profile = "default", durability = "transient_local", depth = 3 }
rate_hz = 50
[[ros2.in]]
to = "operator.wanted"
topic = "~/cmd_vel"
type = "geometry_msgs/msg/Twist"
[[ros2.frame]]
parent = "base_link"
child = "camera"
xyz_m = [0.1, 0, -0.05]
)";

TEST(RobotFile, ARos2TableSaysWhatIsBridgedByRosOwnNames) {
  const auto loaded = parse_robot(kRos2, "robot.toml");
  ASSERT_THAT(loaded.problems, IsEmpty());
  ASSERT_TRUE(loaded.robot.ros2);
  const ros2::BridgeSpec& spec = *loaded.robot.ros2;
  EXPECT_EQ(spec.distro, ros2::Distro::jazzy);
  EXPECT_EQ(spec.node, "my_quad") << "the robot's name, as ROS 2 allows it";
  ASSERT_EQ(spec.out.size(), 2u);
  EXPECT_EQ(spec.out[0].qos, (ros2::Qos{false, false, 5}));
  EXPECT_EQ(spec.out[1].qos, (ros2::Qos{true, true, 3}));
  EXPECT_EQ(ros2::full_name(spec, spec.out[0].ros), "/lab/imu/data_raw");
  EXPECT_EQ(ros2::full_name(spec, spec.out[1].ros), "/odom");
  EXPECT_EQ(ros2::full_name(spec, spec.in[0].ros), "/lab/my_quad/cmd_vel");
  EXPECT_EQ(ros2::dds_topic("/lab/odom"), "rt/lab/odom");
  ASSERT_EQ(spec.frames.size(), 1u);
  EXPECT_EQ(spec.frames[0].xyz_m[2], -0.05);
}

TEST(RobotFile, WrongWordsOfRos2AreNamed) {
  const auto changed = [](const std::string& from, const std::string& to) {
    std::string text(kRos2);
    text.replace(text.find(from), from.size(), to);
    return problems_of(text);
  };
  EXPECT_THAT(changed("\"jazzy\"", "\"jazy\""),
              ElementsAre("robot.toml:3: ros2.distro: \"jazy\": one of \"humble\", \"jazzy\"; did you mean jazzy?"));
  EXPECT_THAT(changed("distro = \"jazzy\"\n", ""), ElementsAre(HasSubstr("ros2.distro: missing")));
  EXPECT_THAT(changed("imu/data_raw", "imu//data"),
              ElementsAre(HasSubstr("ros2.out.0.topic: \"imu//data\": a ROS 2 name")));
  EXPECT_THAT(changed("\"sensor_data\"", "\"sensor\""), ElementsAre(HasSubstr("ros2.out.0.qos: \"sensor\": one of")));
  EXPECT_THAT(changed("transient_local", "latched"),
              ElementsAre(HasSubstr("one of \"transient_local\", \"volatile\"")));
  EXPECT_THAT(changed("depth = 3", "depth = 0"), ElementsAre(HasSubstr("robot.toml:15: ros2.out.1.qos.depth: 0")));
  EXPECT_THAT(changed("to = ", "from = "),
              UnorderedElementsAre(HasSubstr("ros2.in.0.to: missing"), HasSubstr("unknown key")));
  EXPECT_THAT(changed("\"/lab\"", "\"lab\""), ElementsAre(HasSubstr("a name that begins with /")));
  EXPECT_THAT(changed("[0.1, 0, -0.05]", "[0.1, 0]"), ElementsAre(HasSubstr("ros2.frame.0.xyz_m")));
  EXPECT_THAT(changed("namespace = \"/lab\"", "clock = \"publish\"\nstamps = \"wall\""),
              ElementsAre(HasSubstr("stamps are of the time that /clock says")));
}

TEST(RobotFile, EveryKeyReachesTheGraphSpec) {
  const auto loaded = parse_robot(kGood, "robot.toml");
  ASSERT_THAT(loaded.problems, IsEmpty());
  const rt::GraphSpec& g = loaded.robot.graph;
  EXPECT_EQ(g.robot, "desk");
  EXPECT_EQ(g.board, "sim");
  EXPECT_EQ(g.seed, 7u);
  EXPECT_EQ(g.virtual_cores, 2u);
  EXPECT_EQ(g.tap_history, 2s);
  ASSERT_EQ(g.threads.size(), 2u);
  EXPECT_EQ(g.threads[0].priority, 80);
  EXPECT_EQ(g.threads[0].period, 1ms);
  EXPECT_EQ(g.threads[0].phase, 250us);
  EXPECT_EQ(g.threads[0].overrun, rt::ThreadSpec::Overrun::catch_up);
  EXPECT_EQ(g.threads[0].catch_up_max, 3u);
  EXPECT_THAT(g.threads[0].cpus, ElementsAre(1));
  EXPECT_EQ(g.threads[0].order[1].value, "gimbal");
  EXPECT_EQ(g.threads[1].trigger, rt::ThreadSpec::Trigger::device);
  EXPECT_EQ(g.threads[1].timeout, 100ms);
  ASSERT_EQ(g.modules.size(), 3u);
  EXPECT_EQ(g.modules[0].name, "imu") << "modules keep the order of the file";
  EXPECT_EQ(g.modules[0].exec.constant, 2500ns);
  EXPECT_EQ(g.modules[1].in.at("imu").value, "imu.raw");
  EXPECT_EQ(std::get<double>(g.modules[1].params.at("kp").value), 1.5);
  EXPECT_EQ(std::get<bool>(g.modules[1].params.at("on").value), true);
  EXPECT_EQ(std::get<std::int64_t>(g.modules[1].params.at("n").value), 3);
  EXPECT_EQ(std::get<std::string>(g.modules[1].params.at("s").value), "x");
  EXPECT_THAT(g.modules[1].exec.trace, ElementsAre(rt::Duration{10us}, rt::Duration{20us}));
  EXPECT_EQ(g.modules[2].exec.kind, rt::ExecModel::Kind::measured);
  EXPECT_FALSE(g.modules[2].enabled);
  ASSERT_EQ(g.topics.size(), 2u);
  EXPECT_EQ(g.topics[0].image_bytes, 640u * 480 * 2);
  EXPECT_EQ(g.topics[0].image_pixels, 640u * 480);
  EXPECT_EQ(g.topics[0].history, 5u);
  EXPECT_FALSE(g.topics[0].external);
  ASSERT_TRUE(g.topics[1].external);
  EXPECT_EQ(g.topics[1].external->type, "OperatorLink");
  EXPECT_EQ(g.topics[1].external->thread, "control");
  EXPECT_EQ(g.topics[1].external->exec.constant, 2us);
  ASSERT_EQ(g.actuators.size(), 1u);
  EXPECT_EQ(g.actuators[0].min, -0.6);
  EXPECT_EQ(g.actuators[0].lease, 20ms);
  EXPECT_EQ(g.actuators[0].safe, rt::ActuatorSpec::Safe::hold);
  ASSERT_EQ(g.chains.size(), 1u);
  EXPECT_EQ(g.chains[0].budget, 5ms);
  EXPECT_EQ(g.guardian.priority, 90);
  EXPECT_EQ(g.guardian.exec.constant, 4us);
  EXPECT_EQ(g.guardian.arming, rt::GuardianSpec::Arming::manual);
}

TEST(RobotFile, EveryKeyOfAFailsafeReachesTheGraphSpec) {
  using Kind = rt::FailsafeSpec::Kind;
  const auto loaded = parse_robot(kGood, "robot.toml");
  ASSERT_THAT(loaded.problems, IsEmpty());
  const std::vector<rt::FailsafeSpec>& f = loaded.robot.graph.failsafes;
  ASSERT_EQ(f.size(), 3u);
  EXPECT_EQ(f[0].name, "camera_lost");
  EXPECT_EQ(f[0].topic.value, "camera.raw");
  EXPECT_EQ(f[0].kind, Kind::silent);
  EXPECT_EQ(f[0].time, 500ms);
  EXPECT_EQ(f[0].action, msg::FailsafeAction::land);
  EXPECT_EQ(f[0].stop_after, rt::Duration{20s});
  EXPECT_EQ(f[1].kind, Kind::stuck);
  EXPECT_EQ(f[1].time, 20ms);
  EXPECT_EQ(f[1].action, msg::FailsafeAction::stop);
  EXPECT_FALSE(f[1].stop_after);
  EXPECT_EQ(f[2].kind, Kind::value);
  EXPECT_EQ(f[2].field.value, "temperature_c");
  EXPECT_EQ(f[2].below, -20.0);
  EXPECT_EQ(f[2].above, 70.5);
  EXPECT_EQ(f[2].time, 1000ms);
}

TEST(RobotFile, AFailsafeIsOfOneKindAndEveryProblemIsNamed) {
  EXPECT_THAT(problems_of(R"(robot = { name = "r", board = "sim" }
[[failsafe]]
name = "a"
topic = "x.y"
action = "land"
[[failsafe]]
name = "b"
topic = "x.y"
silent_ms = 0
stuck_ms = 5
action = "pray"
then = "stop"
[[failsafe]]
name = "c"
field = "v"
below = "low"
[guardian]
arming = "manuel"
)"),
              UnorderedElementsAre(
                  "robot.toml:2: failsafe.a: : exactly one of silent_ms, stuck_ms, field (with below or above)",
                  "robot.toml:9: failsafe.b.silent_ms: 0: a number from 1 to 3600000",
                  "robot.toml:6: failsafe.b: : exactly one of silent_ms, stuck_ms, field (with below or above)",
                  "robot.toml:11: failsafe.b.action: \"pray\": one of \"land\", \"stop\"",
                  "robot.toml:6: failsafe.b: : then and then_after_ms together, or neither",
                  "robot.toml:13: failsafe.c.topic: missing: the name of a topic; it is required",
                  "robot.toml:16: failsafe.c.below: \"low\": a number from -1e+300 to 1e+300",
                  "robot.toml:13: failsafe.c.action: missing: one of land stop; it is required",
                  "robot.toml:18: guardian.arming: \"manuel\": one of \"auto\", \"manual\"; did you mean manual?"));
}

TEST(RobotFile, QuantilesOfExecutionTimesReachTheGraphSpec) {
  const auto loaded = parse_robot(R"(robot = { name = "r", board = "sim" }
[module]
m = { type = "t", exec_quantiles_us = [[0.5, 12], [1, 80.5]] }
)",
                                  "robot.toml");
  ASSERT_THAT(loaded.problems, IsEmpty());
  const rt::ExecModel& exec = loaded.robot.graph.modules[0].exec;
  EXPECT_EQ(exec.kind, rt::ExecModel::Kind::quantiles);
  ASSERT_EQ(exec.quantiles.size(), 2u);
  EXPECT_EQ(exec.quantiles[0].share, 0.5);
  EXPECT_EQ(exec.quantiles[1].exec, 80500ns);
  EXPECT_THAT(problems_of(R"(robot = { name = "r", board = "sim" }
[module]
m = { type = "t", exec_quantiles_us = [[0.5, 12], 3] }
n = { type = "t", exec_quantiles_us = [[1, 12]], exec_us = 3 }
)"),
              ElementsAre("robot.toml:3: module.m.exec_quantiles_us: [ [ 0.5, 12 ], 3 ]: an array of pairs [share, "
                          "us], us from 0.001 to 3.6e9",
                          "robot.toml:4: module.n.exec_us: 3: only one of exec_us, exec_trace_us, exec_quantiles_us, "
                          "exec_measured_factor"));
}

TEST(RobotFile, EveryProblemIsNamedInOneRun) {
  const auto lines = problems_of(R"(robot = { name = "r", board = "sim", colour = "red" }
[[thread]]
name = "control"
priority = 120
period_us = 1000
trigger = "imu.raw"
order = ["m"]
[module]
m = { exec_us = -3, params = { k = [1] } }
[topic."camera.raw"]
image = { width = 5000, height = 480, format = "hsv" }
[actuator.tilt]
command = "m.tilt"
channels = 9
limit = [1, -1]
safe = "pray"
)");
  EXPECT_THAT(
      lines,
      UnorderedElementsAre(
          "robot.toml:1: robot.colour: \"red\": unknown key; known here: board calibration device_boards name seed "
          "tap_history_ms "
          "virtual_cores",
          "robot.toml:4: thread.control.priority: 120: an integer from 0 to 98",
          "robot.toml:2: thread.control: : exactly one of period_us, trigger (topics), device (a driver module)",
          "robot.toml:9: module.m.type: missing: the type of a module, e.g. \"control::Mixer\"; it is required",
          "robot.toml:9: module.m.exec_us: -3: a number from 0.001 to 3600000000",
          "robot.toml:9: module.m.params.k: [ 1 ]: a boolean, a number or a string",
          "robot.toml:11: topic.camera.raw.image.width: 5000: an integer from 1 to 1280",
          "robot.toml:11: topic.camera.raw.image.format: \"hsv\": one of \"mono8\", \"rgb8\", \"bgr8\", \"yuyv\"",
          "robot.toml:14: actuator.tilt.channels: 9: an integer from 1 to 8",
          "robot.toml:15: actuator.tilt.limit: [ 1, -1 ]: [smallest, largest], two numbers in this order, or a list of "
          "such, one for each channel",
          "robot.toml:12: actuator.tilt.lease_ms: missing: a number from 0.1 to 10000; it is required",
          "robot.toml:16: actuator.tilt.safe: \"pray\": one of \"stop\", \"hold\", \"damp\", \"torque_off\""));
}

TEST(RobotFile, EachChannelMayHaveItsOwnLimit) {
  const std::string head =
      "\n[actuator.a]\ncommand = \"m.out\"\nchannels = 2\nlease_ms = 20\nsafe = \"stop\"\nlimit = ";
  const auto loaded =
      parse_robot("[robot]\nname = \"r\"\nboard = \"none\"\n" + head + "[[-1.4, 1.4], [-1.0, 0.9]]\n", "r.toml");
  ASSERT_THAT(loaded.problems, IsEmpty());
  const rt::ActuatorSpec& a = loaded.robot.graph.actuators.at(0);
  EXPECT_EQ(a.limit(0).max, 1.4);
  EXPECT_EQ(a.limit(1).min, -1.0);
  EXPECT_EQ(a.limit(1).max, 0.9);
  EXPECT_THAT(problems_of("[robot]\nname = \"r\"\nboard = \"none\"\n" + head + "[[-1.5, 1.5], [1.0]]\n"),
              ElementsAre(HasSubstr("actuator.a.limit: [ [ -1.5, 1.5 ], [ 1.0 ] ]: [smallest, largest]")));
}

TEST(RobotFile, ABoardThatIsNoneIsNamedWithItsLine) {
  EXPECT_THAT(problems_of("\n[robot]\nname = \"r\"\nboard = \"Linux\"\n"),
              ElementsAre("robot.toml:4: robot.board: \"Linux\": \"sim\", \"linux\", \"dataset\" or \"none\"; did you "
                          "mean linux?"));
}

TEST(RobotFile, ANameIsOneThatOtherProgramsCanAskFor) {
  EXPECT_THAT(problems_of("[robot]\nname = \"my robot\"\nboard = \"none\"\n"),
              ElementsAre("robot.toml:2: robot.name: \"my robot\": letters, digits, _ and -, at most 40"));
  EXPECT_THAT(problems_of("[robot]\nname = \"" + std::string(41, 'a') + "\"\nboard = \"none\"\n"),
              ElementsAre(HasSubstr("robot.toml:2: robot.name: ")));
}

TEST(RobotFile, APlantIsAPlaceAndAWorldOneThatThereIs) {
  EXPECT_THAT(
      problems_of("robot = { name = \"r\", board = \"sim\" }\n[sim]\nplant = \"here\"\nworld = \"quda\"\n"),
      UnorderedElementsAre(
          "robot.toml:3: sim.plant: \"here\": \"auto\", \"unix:PATH\" or \"tcp:HOST:PORT\"",
          "robot.toml:4: sim.world: \"quda\": the name of a world of sinew-sim: \"air_robot\", \"desk_head\", "
          "\"gripper\", \"soccer\", \"mixed\", \"quad\", \"seesaw\", \"simspark\", \"terrain\"; did you mean quad?"));
  EXPECT_THAT(problems_of("robot = { name = \"r\", board = \"sim\" }\n[sim]\nplant = \"unix:/tmp/p\"\n"), IsEmpty());
}

TEST(RobotFile, AHangIsNoShorterThanTwoLeases) {
  const auto with = [](const char* hang) {
    return problems_of(std::string(R"(robot = { name = "x", board = "none" }
actuator.a = { command = "m.out", channels = 1, limit = [0, 1], lease_ms = 300, safe = "stop" }
)") +
                       "parent = { hang_ms = " + hang + " }\n");
  };
  EXPECT_THAT(with("599"),
              ElementsAre("robot.toml:3: parent.hang_ms: 599: at least two of the smallest lease: 600 or more"));
  EXPECT_THAT(with("600"), ElementsAre());
}

TEST(RobotFile, AFlightRingIsThereOnlyWhereItIsAskedFor) {
  const std::string robot = "robot = { name = \"r\", board = \"none\" }\n";
  EXPECT_FALSE(parse_robot(robot + "[record]\n", "f").robot.record.ring.enabled);
  const RecordOptions by_default = parse_robot(robot + "[record.ring]\n", "f").robot.record;
  EXPECT_TRUE(by_default.ring.enabled);
  EXPECT_EQ(by_default.ring.seconds, 10);
  EXPECT_EQ(by_default.ring.megabytes, 32);
  const auto set = parse_robot(robot + "[record.ring]\nseconds = 3\nmegabytes = 20\n", "f");
  EXPECT_TRUE(set.problems.empty());
  EXPECT_EQ(set.robot.record.ring.seconds, 3);
  EXPECT_EQ(set.robot.record.ring.megabytes, 20);
  const auto wrong = parse_robot(robot + "[record.ring]\nseconds = 0\nmegabytes = 1\nmode = 1\n", "f");
  ASSERT_EQ(wrong.problems.size(), 3u);
  for (const rt::Problem& p : wrong.problems) EXPECT_TRUE(p.key.starts_with("record.ring.")) << p.key;
}

TEST(RobotFile, SyntaxErrorIsOneProblemWithItsLine) {
  const auto loaded = parse_robot("robot = { name = \"r\", board = \"sim\" }\n[[thread]\n", "robot.toml");
  ASSERT_EQ(loaded.problems.size(), 1u);
  EXPECT_EQ(loaded.problems[0].line, 2);
  EXPECT_EQ(loaded.problems[0].key, "TOML");
}

TEST(RobotFile, HeaderThatIsNoKeyIsOneProblemAndNotAnAbort) {
  EXPECT_THAT(problems_of("\n[[:m]]\n"), ElementsAre(HasSubstr("robot.toml:2: TOML: syntax: ")));
}

TEST(RobotFile, OnlyCommentsGoBeyondAscii) {
  const std::string says = ": TOML: syntax: only ASCII outside of comments";
  EXPECT_THAT(problems_of("# ok: \u00b0\n\u00b0 = 1\n"), ElementsAre("robot.toml:2" + says));
  EXPECT_THAT(problems_of("a = '''\n# '\n\u00b0'''\n"), ElementsAre("robot.toml:3" + says));
  EXPECT_THAT(problems_of("a = \"\\\"# \u00b0\"\n"), ElementsAre("robot.toml:1" + says));
  EXPECT_THAT(problems_of("a = \"\\\u00b0\"\n"), ElementsAre("robot.toml:1" + says));
  const auto named = parse_robot("robot = { name = \"cafe #1\", board = \"sim\" } # \u00b0\n", "robot.toml");
  EXPECT_EQ(named.robot.graph.robot, "cafe #1");
}

TEST(RobotFile, NotANumberIsShownInsideAnArrayToo) {
  EXPECT_THAT(problems_of("robot = [nan, [inf], []]\n"),
              testing::Contains(HasSubstr("robot.toml:1: robot: [ nan, [ inf ], [] ]: ")));
}

TEST(RobotFile, FileThatIsNotThereIsNamed) {
  const auto loaded = load_robot("no/such/robot.toml");
  ASSERT_EQ(loaded.problems.size(), 1u);
  EXPECT_EQ(loaded.problems[0].value, "no/such/robot.toml");
}

TEST(RobotFile, WrongShapeOfATableIsAProblemAndNotACrash) {
  EXPECT_THAT(problems_of("robot = 3\nthread = [1]\nmodule = 4\n"),
              UnorderedElementsAre("robot.toml:1: robot: 3: a table",
                                   "robot.toml:2: thread: [ 1 ]: an array of tables, written [[thread]]",
                                   "robot.toml:3: module: 4: a table of tables"));
}

TEST(RobotFile, AnUnknownKeyOrTableIsToldWithTheOneThatItResembles) {
  EXPECT_THAT(problems_of("robot = { name = \"r\", board = \"none\", sed = 3 }\n[sim]\nrelinks = 3\n[gaurdian]\n"),
              UnorderedElementsAre(HasSubstr("robot.sed: 3: unknown key; known here: board calibration device_boards "
                                             "name seed tap_history_ms virtual_cores; did you mean seed?"),
                                   testing::EndsWith("; did you mean relink_s?"),
                                   testing::EndsWith("; did you mean guardian?")));
}

TEST(RobotFile, EmptyKeyIsNamedAsOne) {
  EXPECT_THAT(problems_of("'' = 1\nrobot = { name = \"r\", board = \"sim\" }\n"),
              ElementsAre(testing::StartsWith("robot.toml:1: \"\": 1: unknown key; known here:")));
}

}  // namespace
}  // namespace sinew::app::robot_file_test
