#include "sim_hil/usarsim/session.hpp"

#include <gmock/gmock.h>

#include <regex>

#include "rig.hpp"
#include "sim_hil/usarsim/values.hpp"

namespace sinew::usarsim::session_test {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

std::string value(const std::string& text, const std::string& key) {
  wire::UsarLine line;
  EXPECT_EQ(parse_usarsim(text, line), wire::UsarError::none) << text;
  return text_of(line, key);
}
double number(const std::string& text, const std::string& key, std::size_t index = 0) {
  return wire::usar_number(value(text, key), index).value_or(-999);
}
/// With this type.
std::vector<std::string> of_type(const std::vector<std::string>& lines, const std::string& type) {
  std::vector<std::string> found;
  for (const std::string& l : lines)
    if (l.find("{Type " + type + "}") != std::string::npos) found.push_back(l);
  return found;
}

// ---- what is said

TEST(UsarSession, GreetsAndTellsWhereRobotsMayStart) {
  Rig rig;
  Client& c = rig.client();
  EXPECT_EQ(c.hear(), std::vector<std::string>{"NFO {Gametype BotDeathMatch} {Level Flat} {TimeLimit 0}"});
  c.say("GETSTARTPOSES");
  const std::string said = c.last("NFO {StartPoses 3}");
  EXPECT_THAT(said, HasSubstr("{Pose1 0.0000,0.0000,0.0000 0.0000,0.0000,0.0000 Pose2 0.0000,-2.0000,0.0000 "));
  EXPECT_THAT(said, HasSubstr("Pose3 0.0000,2.0000,0.0000 0.0000,0.0000,-1.5708}"))
      << "yaw is clockwise, y to the right";
}

/// Forms of the captured session (data of altURI), with numbers as #.
TEST(UsarSession, AnAirRobotSpeaksInTheFormOfTheCapturedSession) {
  Rig rig;
  Client& c = rig.with("AirRobot", "{Location 1.2,2.5,2.05}");
  c.hear();
  rig.wait(0.21);
  std::vector<std::string> forms;
  for (const std::string& line : c.hear()) {
    const std::string form = std::regex_replace(line, std::regex("-?[0-9]+(\\.[0-9]+)?"), "#");
    if (form.find("IMU") == std::string::npos && form.find("Accel") == std::string::npos &&
        form.find("Altitude") == std::string::npos && form.find("Sonar") == std::string::npos)
      forms.push_back(form);
  }
  EXPECT_THAT(forms,
              testing::ElementsAre(
                  "SEN {Time #} {Type GroundTruth} {Name GroundTruth} {Location #,#,#} {Orientation #,#,#}",
                  "SEN {Type GPS} {Name GPS} {Latitude #,#,N} {Longitude #,#,W} {Fix #} {Satellites #}",
                  "MISSTA {Time #} {Name CameraPanTilt} {Link #} {Value #} {Torque #} {Link #} {Value #} {Torque #}",
                  "STA {Type AerialVehicle} {Time #} {LightToggle False} {LightIntensity #} {Battery #} {View #}"));
}

TEST(UsarSession, DecimalsAreThoseOfTheCapturedSession) {
  Rig rig;
  Client& c = rig.with("AirRobot", "{Location 1.2,2.5,2.05}");
  rig.wait(0.2);
  const auto lines = c.hear();
  EXPECT_THAT(lines,
              testing::Contains("SEN {Time 0.2000} {Type GroundTruth} {Name GroundTruth} {Location 1.20,2.50,2.05} "
                                "{Orientation 0.00,0.00,0.00}"));
  EXPECT_THAT(lines, testing::Contains("STA {Type AerialVehicle} {Time 0.20} {LightToggle False} {LightIntensity 0} "
                                       "{Battery 1199} {View -1}"));
  EXPECT_THAT(lines, testing::Contains(StartsWith("MISSTA {Time 0.20} {Name CameraPanTilt} {Link 1} {Value 0.0000} "
                                                  "{Torque -20.00}")));
}

TEST(UsarSession, UnderARoofGpsHasNoFix) {
  plant::PlaceMap map = flat();
  map.solids.push_back({plant::Shape::box, {0, 0, 9}, {}, {100, 100, 0.1}});
  Rig rig({}, map);
  Client& c = rig.with("AirRobot");
  rig.wait(0.21);
  EXPECT_THAT(c.hear(), testing::Contains("SEN {Type GPS} {Name GPS} {Fix 0} {Satellites 0}"));
}

TEST(UsarSession, EachSensorOfEachClassComesAtItsInterval) {
  for (const RobotClass& kind : robot_classes()) {
    Rig rig;
    Client& c = rig.with(kind.name);
    c.hear();
    rig.wait(4.01);
    const auto lines = c.hear();
    for (const SensorMount& m : kind.sensors) {
      std::size_t count = 0;
      for (const std::string& l : lines)
        if (l.starts_with("SEN") && l.find("{Type " + std::string(to_string(m.type)) + "}") != std::string::npos &&
            l.find("Name " + std::string(m.name)) != std::string::npos)
          ++count;
      EXPECT_EQ(count, static_cast<std::size_t>(4.0 / m.interval_s + 0.5)) << kind.name << ' ' << m.name;
    }
    EXPECT_EQ(std::ranges::count_if(lines, [](const auto& l) { return l.starts_with("STA"); }), 20) << kind.name;
    EXPECT_EQ(std::ranges::count_if(lines, [](const auto& l) { return l.starts_with("MISSTA"); }), 20) << kind.name;
    EXPECT_EQ(rig.game.counts().unsent, 0u) << "every line fitted";
  }
}

TEST(UsarSession, SonarsComeTogetherOrApart) {
  Rig together;
  Client& a = together.with("P2AT");
  together.wait(0.21);
  const auto one = of_type(a.hear(), "Sonar");
  ASSERT_EQ(one.size(), 1u);
  EXPECT_THAT(one[0], testing::ContainsRegex("\\{Name F1 Range 5\\.0000 Name F2 Range "));
  Options options;
  options.sonars_together = false;
  Rig apart(options);
  Client& b = apart.with("P2AT");
  apart.wait(0.21);
  const auto eight = of_type(b.hear(), "Sonar");
  ASSERT_EQ(eight.size(), 8u);
  EXPECT_THAT(eight[0], HasSubstr("{Name F1} {Range 5.0000}"));
}

TEST(UsarSession, SonarAndScannerSeeTheWall) {
  Rig rig;
  Client& c = rig.with("P2AT", "{Location 1,-2,0.2}");  // y = 2 in Sinew's world: before the wall
  rig.wait(0.21);
  const auto lines = c.hear();
  const std::string scan = of_type(lines, "RangeScanner").at(0);
  EXPECT_EQ(wire::usar_count(value(scan, "Range")), 181u);
  EXPECT_NEAR(number(scan, "Range", 90), 3 - 0.2085, 0.01) << "straight ahead";
  EXPECT_NEAR(number(scan, "Range", 0), 20, 1e-9) << "to the right there is nothing";
  const std::string sonars = of_type(lines, "Sonar").at(0);
  wire::UsarLine line;
  ASSERT_EQ(parse_usarsim(sonars, line), wire::UsarError::none);
  EXPECT_NEAR(*wire::usar_number(line.part[line.index_of("Range", line.index_of("Time") + 1) + 6].value), 2.8, 0.06)
      << "F4";
}

TEST(UsarSession, OdometryAndEncodersFollowTheWheels) {
  Rig rig;
  Client& c = rig.with("P3AT");
  c.say("DRIVE {Left 4} {Right 4}");
  rig.wait(3);
  const auto lines = c.hear();
  const double x = rig.body(c).p_world_m.x;
  EXPECT_GT(x, 1);
  EXPECT_NEAR(number(of_type(lines, "Odometry").back(), "Pose"), x, 0.06);
  EXPECT_NEAR(number(of_type(lines, "Encoder").back(), "Tick"), x / 0.11 / 0.01745, 20);
  c.say("DRIVE {Left 2} {Right -2}");
  rig.wait(1);
  EXPECT_GT(number(of_type(c.hear(), "Odometry").back(), "Pose", 2), 0.3) << "theta is clockwise";
}

TEST(UsarSession, InsDriftsWithTheWayAndGroundTruthDoesNot) {
  Rig rig;
  Client& c = rig.with("P3AT");
  c.say("DRIVE {Left 6} {Right 6}");
  rig.wait(20);
  const auto lines = c.hear();
  const double truth = number(of_type(lines, "GroundTruth").back(), "Location"),
               ins = number(of_type(lines, "INS").back(), "Location");
  EXPECT_NEAR(truth, rig.body(c).p_world_m.x, 0.001);
  EXPECT_NEAR(ins, truth, 0.02);
}

TEST(UsarSession, TouchTellsOfTheWall) {
  Rig rig;
  Client& c = rig.with("P3AT", "{Location 2,-2,0.2}");
  rig.wait(0.2);
  EXPECT_THAT(of_type(c.hear(), "Touch").back(), HasSubstr("{Touch False}"));
  c.say("DRIVE {Left 6} {Right 6}");
  rig.wait(5);
  EXPECT_THAT(of_type(c.hear(), "Touch").back(), HasSubstr("{Touch True}"));
}

TEST(UsarSession, TheImuFeelsAStartForward) {
  Rig rig;
  Client& c = rig.with("AirRobot", "{Location 0,0,2}");
  c.say("DRIVE {LinearVelocity 2} {LateralVelocity 1}");
  rig.wait(0.11);
  const std::string imu = of_type(c.hear(), "IMU").at(0);
  EXPECT_GT(number(imu, "XYZAcceleration", 0), 1.5);
  EXPECT_GT(number(imu, "XYZAcceleration", 1), 0.5) << "y is to the right";
  EXPECT_LT(number(imu, "AngularVel", 1), -0.3) << "pitch upwards is positive: the nose goes down";
}

// ---- what is obeyed

TEST(UsarSession, AnAirRobotDrivesUpForwardRightAndClockwise) {
  Rig rig;
  Client& c = rig.with("AirRobot");
  c.say("DRIVE {AltitudeVelocity 1.00} {LinearVelocity 0.00} {LateralVelocity 0.00} {RotationalVelocity 0.00}");
  rig.wait(1.5);
  c.say("DRIVE {AltitudeVelocity 0} {LinearVelocity 0.5} {LateralVelocity 0.25}");
  rig.wait(2);
  const math::Vec3 v = rig.body(c).v_world_mps;
  EXPECT_NEAR(v.x, 0.5, 0.01);
  EXPECT_NEAR(v.y, -0.25, 0.01) << "to the right";
  const std::string truth = of_type(c.hear(), "GroundTruth").back();
  EXPECT_GT(number(truth, "Location", 1), 0.2) << "y is to the right";
  EXPECT_NEAR(number(truth, "Location", 2), 1.5 + plant::kAirRobot.rest_m, 0.02);
  c.say("DRIVE {RotationalVelocity 0.5}");
  rig.wait(1);
  EXPECT_NEAR(rig.body(c).v_world_mps.x, 0.5, 0.2) << "what is not named stays";
  EXPECT_NEAR(rig.body(c).angles_rad.yaw, -0.4, 0.02);
  const double yaw = number(of_type(c.hear(), "GroundTruth").back(), "Orientation", 2);
  EXPECT_GT(yaw, 0.2);
  EXPECT_LT(yaw, 0.45);
}

TEST(UsarSession, NormalizedIsAPercentageOfTheClass) {
  Rig rig;
  Client& air = rig.with("AirRobot", "{Location 0,0,3}");
  Client& wheels = rig.with("P3AT", "{Start Pose3}");
  air.say("DRIVE {LinearVelocity 50} {Normalized True}");
  wheels.say("DRIVE {Left 50} {Right 50} {Normalized true}");
  rig.wait(2);
  EXPECT_NEAR(rig.body(air).v_world_mps.x, 1.0, 0.01) << "half of 2 m/s";
  EXPECT_NEAR(wheels.robot()->vehicle().wheels().left_radps(), 3.2, 0.01) << "half of 6.4 rad/s";
}

TEST(UsarSession, ASteeredVehicleTakesItsSpeedAndTheAnglesOfItsAxles) {
  Rig rig;
  Client& c = rig.with("FrontAckerman");
  c.say("DRIVE {Speed 4.00} {FrontSteer 0.30} {RearSteer 0.00} {Normalized false} {Light true}");
  rig.wait(2);
  EXPECT_GT(rig.body(c).p_world_m.x, 0.4);
  EXPECT_LT(rig.body(c).angles_rad.yaw, -0.1) << "clockwise is positive";
  EXPECT_THAT(c.last("STA"), HasSubstr("{FrontSteer 0.3000} {RearSteer 0.0000} {LightToggle True}"));
  const auto yaw = [&] { return rig.body(c).angles_rad.yaw; };
  const double before = yaw();
  c.say("DRIVE {FrontSteer -0.30}");
  rig.wait(2);
  EXPECT_GT(yaw(), before) << "Speed stays as it was";
  c.say("DRIVE {Speed 0} {FrontSteer 0} {RearSteer 0}");
  rig.wait(3);
  EXPECT_NEAR(math::norm(rig.body(c).v_world_mps), 0, 1e-3);
  EXPECT_EQ(rig.game.counts().unusable, 0u);

  Client& rear = rig.with("BasicAckermanRobot", "{Location 0,4,0.2}");
  rear.say("DRIVE {Speed 50} {FrontSteer 0} {RearSteer 50} {Normalized True}");
  rig.wait(2);
  EXPECT_NEAR(rear.robot()->vehicle().wheels().rear_steer_rad(), -0.4, 1e-6) << "half of 0.8 rad";
  EXPECT_NEAR((rear.robot()->vehicle().wheels().left_radps() + rear.robot()->vehicle().wheels().right_radps()) / 2, 4,
              0.01)
      << "half of 8 rad/s";
  EXPECT_GT(rig.body(rear).angles_rad.yaw, 0.1) << "rear wheels to the right steer to the left";
}

TEST(UsarSession, OdometryOfASteeredVehicleIsTheWayOfTheAxleThatDoesNotSteer) {
  Rig rig;
  Client& c = rig.with("FrontAckerman", "{Location -4,0,0.2}");
  c.say("DRIVE {Speed 4} {FrontSteer -0.3} {RearSteer 0}");
  rig.wait(4.001);
  const std::string said = of_type(c.hear(), "Odometry").back();
  const double half = plant::kFrontSteered.wheelbase_m / 2, yaw = rig.body(c).angles_rad.yaw;
  EXPECT_NEAR(number(said, "Pose", 0), rig.body(c).p_world_m.x - half * std::cos(yaw) - (-4 - half), 0.02);
  EXPECT_NEAR(number(said, "Pose", 1), -(rig.body(c).p_world_m.y - half * std::sin(yaw)), 0.02);
  EXPECT_NEAR(number(said, "Pose", 2), -yaw, 0.02);
}

TEST(UsarSession, ADriveThatAVehicleCannotObeyIsAnsweredWithTheReasonAndChangesNothing) {
  Rig rig;
  Client& c = rig.with("FrontAckerman");
  c.say("DRIVE {Speed 2} {FrontSteer 0.1} {RearSteer 0}");
  c.hear();
  c.say("DRIVE {Speed 5} {FrontSteer much} {RearSteer }");
  EXPECT_EQ(c.last("NFO"), "NFO {Error DRIVE} {Reason FrontSteer 'much' is no number; RearSteer '' is no number}");
  c.say("DRIVE {Left 1} {Right 1}");
  EXPECT_EQ(c.last("NFO"), "NFO {Error DRIVE} {Reason FrontAckerman is driven by Speed, FrontSteer, RearSteer}");
  EXPECT_EQ(c.robot()->vehicle().driven().steered.spin_radps, 2) << "as before";
  EXPECT_EQ(c.robot()->vehicle().driven().steered.front_rad, -0.1);
  Client& skid = rig.with("P3AT", "{Start Pose2}");
  skid.hear();
  skid.say("DRIVE {Speed 2} {FrontSteer 0.1} {RearSteer 0}");
  EXPECT_EQ(skid.last("NFO"), "NFO {Error DRIVE} {Reason P3AT has no steered wheels: it is driven by Left and Right}");
  EXPECT_EQ(rig.game.counts().unusable, 3u);
}

TEST(UsarSession, MultidriveMovesNamedJoints) {
  Rig rig;
  Client& c = rig.with("P3AT");
  c.say("MULTIDRIVE {CameraPan 0.5} {CameraTilt -0.3} {FLWheelRoll 2} {frwheelroll 3,0}");
  rig.wait(1.2);
  const plant::Vehicle& v = c.robot()->vehicle();
  EXPECT_NEAR(v.camera().position_rad[plant::kPan], -0.5, 1e-4) << "clockwise";
  EXPECT_NEAR(v.camera().position_rad[plant::kTilt], 0.3, 1e-4) << "upwards";
  EXPECT_EQ(v.driven().left_radps, 2);
  EXPECT_EQ(v.driven().right_radps, 3) << "names in any case, decimal commas";
  EXPECT_THAT(c.last("MISSTA"), HasSubstr("{Link 1} {Value 0.5000}"));

  Client& steered = rig.with("FrontAckerman", "{Location 0,4,0.2}");
  steered.say("MULTIDRIVE {FRFrontSteer 0.2} {BLWheelRoll 1.5}");
  EXPECT_EQ(steered.robot()->vehicle().driven().steered.front_rad, -0.2);
  EXPECT_EQ(steered.robot()->vehicle().driven().steered.spin_radps, 1.5);
  EXPECT_EQ(rig.game.counts().unusable, 0u);
  EXPECT_EQ(rig.game.counts().unknown, 0u);
}

TEST(UsarSession, JointsThatARobotDoesNotHaveAreNamedAndTheOthersMove) {
  Rig rig;
  Client& c = rig.with("AirRobot");
  c.hear();
  c.say("MULTIDRIVE {FRFlipper 0.8} {CameraPanTilt_Link1 0.25} {CameraTilt up}");
  EXPECT_EQ(c.last("NFO"),
            "NFO {Error MULTIDRIVE} {Reason no joint 'FRFlipper'; AirRobot has CameraPan, CameraTilt, "
            "CameraPanTilt_Link1, CameraPanTilt_Link2; CameraTilt 'up' is no number}");
  rig.wait(1);
  EXPECT_NEAR(c.robot()->vehicle().camera().position_rad[plant::kPan], -0.25, 1e-4);
  EXPECT_EQ(c.robot()->vehicle().camera().position_rad[plant::kTilt], 0);
  c.say("MULTIDRIVE");
  EXPECT_THAT(c.last("NFO {Error MULTIDRIVE}"), HasSubstr("it names no joint"));
  EXPECT_EQ(rig.game.counts().unusable, 2u);
}

TEST(UsarSession, DriveWithANameTurnsOneJointToAnAngleOrAtARate) {
  Rig rig;
  Client& c = rig.with("P2AT");
  c.say("DRIVE {Name CameraTilt} {Order 1} {Value 0.5}");
  c.say("DRIVE {Name CameraPan} {Value 0.4}");
  c.say("DRIVE {Name LeftRWheel} {Order 1} {Value 1.5}");
  rig.wait(0.5);
  const plant::Vehicle& v = c.robot()->vehicle();
  EXPECT_NEAR(v.camera().rate_radps[plant::kTilt], -0.5, 1e-6);
  EXPECT_NEAR(v.camera().position_rad[plant::kPan], -0.4, 1e-3);
  EXPECT_EQ(v.driven().left_radps, 1.5);
  EXPECT_EQ(rig.game.counts().unusable, 0u);
  const auto why = [&](const std::string& line) {
    c.hear();
    c.say(line);
    const std::string answer = c.last("NFO {Error DRIVE} {Reason ");
    return answer.empty() ? answer : answer.substr(26, answer.size() - 27);
  };
  EXPECT_EQ(why("DRIVE {Name CameraPan} {Order 2} {Value 1}"), "Order '2': there are 0, an angle, and 1, a rate");
  EXPECT_EQ(why("DRIVE {Name CameraPan} {Steps 20}"), "a joint needs its Value; Steps are not known here");
  EXPECT_EQ(why("DRIVE {Name LeftFWheel} {Order 0} {Value 1}"), "LeftFWheel turns at a rate: Order 1");
  EXPECT_THAT(why("DRIVE {Name Elbow} {Value 1}"), StartsWith("no joint 'Elbow'; P2AT has LeftFWheel, LeftRWheel, "));
  EXPECT_NEAR(v.camera().position_rad[plant::kPan], -0.4, 1e-3) << "none of these moved it";
  Client& steered = rig.with("FrontAckerman", "{Location 0,4,0.2}");
  steered.hear();
  steered.say("DRIVE {Name FLFrontSteer} {Order 1} {Value 0.1}");
  EXPECT_THAT(steered.last("NFO {Error DRIVE}"), HasSubstr("FLFrontSteer turns to an angle: Order 0"));
}

TEST(UsarSession, LightIsTold) {
  Rig rig;
  Client& c = rig.with("P3AT");
  c.say("DRIVE {Left 0.00} {Right 0.00} {Light 1} {Flip 0}");
  rig.wait(0.2);
  EXPECT_THAT(c.last("STA"), HasSubstr("{LightToggle True} {LightIntensity 100}"));
}

TEST(UsarSession, MissionPackageAndActTurnTheCameraAndAreAnswered) {
  Rig rig;
  Client& c = rig.with("AirRobot");
  c.say("MISPKG {Name CameraPanTilt} {Link 1} {Value 0.5} {Order 0} {Link 2} {Value -0.3} {Order 0}");
  rig.wait(1.2);
  EXPECT_NEAR(c.robot()->vehicle().camera().position_rad[plant::kPan], -0.5, 1e-4) << "clockwise";
  EXPECT_NEAR(c.robot()->vehicle().camera().position_rad[plant::kTilt], 0.3, 1e-4) << "upwards";
  auto lines = c.hear();
  EXPECT_TRUE(std::ranges::none_of(lines, [](const auto& l) { return l.starts_with("ASTA"); }));
  wire::UsarLine line;
  const auto missta =
      std::ranges::find_if(lines.rbegin(), lines.rend(), [](auto& l) { return l.starts_with("MISSTA"); });
  ASSERT_EQ(parse_usarsim(*missta, line), wire::UsarError::none);
  EXPECT_NEAR(*wire::usar_number(line.find("Value").value), 0.5, 1e-3);
  EXPECT_NEAR(*wire::usar_number(line.find("Value", 4).value), -0.3, 1e-3);
  c.say("ACT {Name CameraPanTilt} {Link 1} {Value -0.25}");
  rig.wait(1.2);
  EXPECT_THAT(c.last("ASTA"), HasSubstr("{Link 1} {Value -0.2500} {Link 2} {Value -0.3000}"));
  c.say("MISPKG {Name CameraPanTilt} {Link 2} {Value 0.5} {Order 1}");
  rig.wait(0.5);
  EXPECT_NEAR(c.robot()->vehicle().camera().rate_radps[plant::kTilt], -0.5, 1e-6) << "a rate";
}

TEST(UsarSession, CameraTurnsAndZooms) {
  Rig rig;
  Client& c = rig.with("P3AT");
  c.say("CAMERA {Rotation 0,-0.4,0.7} {Zoom 0.7}");
  rig.wait(1.5);
  const plant::Vehicle& v = c.robot()->vehicle();
  EXPECT_NEAR(v.camera().position_rad[plant::kTilt], 0.4, 1e-4);
  EXPECT_NEAR(v.camera().position_rad[plant::kPan], -0.7, 1e-4);
  EXPECT_NEAR(v.focal_per_height(), 0.5 / std::tan(0.35) * 320 / 240, 1e-6);
  c.say("CAMERA {Rotation 0,0,0}{Zoom 0}");
  EXPECT_EQ(v.focal_per_height(), v.kind().focal_per_height);
  c.say("SET {Type Camera} {Name Camera} {Opcode Zoom} {Params 0.1}");
  EXPECT_NEAR(v.focal_per_height(), 0.5 / std::tan(0.3491 / 2) * 320 / 240, 1e-6) << "no nearer than CameraMinFov";
}

TEST(UsarSession, ConfAndGeoAnswerForEverySensorRobotCameraAndPackage) {
  for (const RobotClass& kind : robot_classes()) {
    Rig rig;
    Client& c = rig.with(kind.name);
    c.hear();
    const auto ask = [&](const std::string& what) {
      c.say(what);
      const auto lines = c.hear();
      EXPECT_EQ(lines.size(), 1u) << what;
      return lines.empty() ? std::string() : lines[0];
    };
    for (const SensorMount& m : kind.sensors) {
      const std::string type(to_string(m.type)), both = "{Type " + type + "} {Name " + m.name + "}";
      EXPECT_THAT(ask("GETCONF " + both), StartsWith("CONF " + both + " {ScanInterval ")) << kind.name;
      EXPECT_THAT(ask("GETGEO " + both),
                  testing::MatchesRegex("GEO \\{Type " + type + "\\} \\{Name " + m.name +
                                        "\\} \\{Location .*\\} \\{Orientation .*\\} \\{Mount " + kind.name + "\\}"));
    }
    const bool flies = std::string(kind.name) == "AirRobot";
    EXPECT_THAT(ask("GETCONF {Type Robot}"),
                StartsWith(flies ? "CONF {Type AerialVehicle}" : "CONF {Type GroundVehicle}"));
    EXPECT_THAT(ask("GETGEO {Type Robot}"), HasSubstr("{Dimensions "));
    EXPECT_THAT(ask("GETCONF {Type Camera}"), HasSubstr("{CameraFov 1.3963}"));
    EXPECT_THAT(ask("GETGEO {Type Camera} {Name Camera}"), HasSubstr("{Mount CameraPanTilt} {MountLink 2}"));
    EXPECT_THAT(ask("GETCONF {Type MisPkg}"), HasSubstr("{Link 2} {JointType Revolute} {MaxRotationSpeed "));
    EXPECT_THAT(ask("GETGEO {Type MisPkg}"), HasSubstr("{Link 2} {ParentLink 1}"));
    EXPECT_THAT(ask("GETCONF {Type Actuator}"), HasSubstr("{MinValue "));
    EXPECT_EQ(rig.game.counts().unusable, 0u);
    EXPECT_EQ(ask("GETCONF {Type Gripper}"), "CONF {Type Gripper}") << "what it does not have";
    EXPECT_EQ(rig.game.counts().unusable, 1u);
  }
}

TEST(UsarSession, ControlPutsMovesAndRemovesThings) {
  Rig rig;
  Client& c = rig.client();
  c.hear();
  c.say("INIT {ClassName USARBotAPI.WorldController} {Name W}");
  c.say("CONTROL {Type Create} {ClassName WCCrateRed} {Name Box1} {Location 2,1,0.2} {Rotation 0,0,0} {Physics None}");
  c.say("CONTROL {Type Create} {ClassName USARPhysObj.WCCrate} {Name Box2} {Location 3,1,0.2}");
  ASSERT_EQ(rig.place.things().size(), 2u);
  EXPECT_EQ(rig.place.things()[0].pose.p_world_m, (msg::Vec3{2, -1, 0.2}));
  c.say("CONTROL {Type RelMove} {Name box1} {Location 0.5,0,0}");
  EXPECT_EQ(rig.place.things()[0].pose.p_world_m, (msg::Vec3{2, -1, 0.2})) << "names of things are exact";
  c.say("CONTROL {Type RelMove} {Name Box1} {Location 0.5,0,0}");
  c.say("CONTROL {Type AbsMove} {Name Box2} {Location 1,1,1}");
  c.say("CONTROL {Type GetSTA}");
  EXPECT_EQ(c.hear(),
            std::vector<std::string>{
                "STA {Name Box1} {Size 0.4000,0.4000,0.4000} {Location 2.5000,1.0000,0.2000} {Rotation "
                "0.0000,0.0000,0.0000} {Name Box2} {Size 0.4000,0.4000,0.4000} {Location 1.0000,1.0000,1.0000} "
                "{Rotation 0.0000,0.0000,0.0000}"});
  c.say("CONTROL {Type Kill} {Name Box1}");
  EXPECT_EQ(rig.place.things().size(), 1u);
  c.say("CONTROL {Type KillAll}");
  EXPECT_TRUE(rig.place.things().empty());
  c.say("CONTROL {Type Create} {ClassName WCElephant} {Name E}");
  EXPECT_THAT(c.last("NFO {Error CONTROL}"), HasSubstr("no class 'WCElephant'; there are WCCrate, WCCrateRed"));
  c.say("CONTROL {Type AbsMove} {Name Target} {Location 3,2,0.25}");
  EXPECT_EQ(rig.place.target_m(), (math::Vec3{3, -2, 0.25}));
}

TEST(UsarSession, ControlMovesRobotsByName) {
  Rig rig;
  Client& c = rig.with("AirRobot");
  c.say("CONTROL {Type AbsMove} {Name R1} {Location -3,1,2} {Rotation 0,0,1}");
  EXPECT_EQ(rig.body(c).p_world_m, (math::Vec3{-3, -1, 2}));
  EXPECT_NEAR(rig.body(c).angles_rad.yaw, -1, 1e-12);
}

// ---- several robots

TEST(UsarSession, RobotsOfSeveralClientsHaveTheirOwnDrivesAndSensors) {
  Rig rig;
  Client &a = rig.with("AirRobot", "{Start Pose1}"), &b = rig.with("P3AT", "{Start Pose2}"),
         &d = rig.with("P2AT", "{Start Pose3}");
  a.say("DRIVE {AltitudeVelocity 1}");
  b.say("DRIVE {Left 3} {Right 3}");
  rig.wait(1.01);
  EXPECT_GT(rig.body(a).p_world_m.z, 0.8);
  EXPECT_GT(rig.body(b).p_world_m.x, 0.2);
  EXPECT_NEAR(rig.body(d).p_world_m.x, 0, 1e-9);
  EXPECT_NEAR(number(of_type(b.hear(), "GroundTruth").back(), "Location", 1), -2, 1e-3);
  EXPECT_THAT(a.last("STA"), HasSubstr("{View 0}"));
  EXPECT_THAT(d.last("STA"), HasSubstr("{View 2}"));
}

TEST(UsarSession, TheNinthRobotIsRefusedWithTheReason) {
  Rig rig;
  for (int i = 0; i < 8; ++i) rig.with("AirRobot", "{Location " + std::to_string(-2 * i) + ",0,1}");
  Client& c = rig.client();
  c.say("INIT {ClassName USARBot.AirRobot} {Name R9} {Location 0,5,1}");
  EXPECT_FALSE(c.robot());
  EXPECT_THAT(c.last("NFO {Error INIT}"), HasSubstr("all vehicles of the place are taken"));
  EXPECT_EQ(rig.game.counts().refused, 1u);
}

TEST(UsarSession, AnUnknownClassIsAnsweredWithThoseThatThereAre) {
  Rig rig;
  Client& c = rig.client();
  c.say("INIT {ClassName USARBot.Kenaf} {Name R1} {Start Pose1}");
  EXPECT_EQ(
      c.last("NFO {Error"),
      "NFO {Error INIT} {Reason no class 'USARBot.Kenaf'; there are USARBot.AirRobot, USARBot.P3AT, USARBot.P2AT, "
      "USARBot.FrontAckerman, USARBot.BasicAckermanRobot}");
  c.say("INIT {ClassName USARBot.P3AT} {Name R1} {Start Pose1}");
  EXPECT_TRUE(c.robot()) << "it may try again";
  c.say("INIT {ClassName USARBot.P3AT} {Name R2} {Start Pose2}");
  EXPECT_THAT(c.last("NFO {Error INIT}"), HasSubstr("this connection has its robot, R1"));
}

// ---- clients are sloppy

TEST(UsarSloppy, KeysAndClassesMayHaveAnyCase) {
  Rig rig;
  Client& c = rig.client();
  c.say("INIT {Classname usarbot.airrobot} {name R1} {start pose3}");
  ASSERT_TRUE(c.robot());
  EXPECT_NEAR(rig.body(c).p_world_m.y, -2, 1e-9);
  c.say("drive {altitudevelocity 1}");
  rig.wait(1);
  EXPECT_GT(rig.body(c).p_world_m.z, 0.8);
}

TEST(UsarSloppy, AClassNeedsNoPackageInFrontOfIt) {
  Rig rig;
  Client& c = rig.client();
  c.say("INIT {ClassName P2AT}");
  EXPECT_TRUE(c.robot());
}

TEST(UsarSloppy, BlanksMayBeMissingOrMany) {
  Rig rig;
  Client& c = rig.client();
  c.say("  INIT{ClassName USARBot.P3AT}{Name R1}   {  Start   Pose1  }  ");
  ASSERT_TRUE(c.robot());
  c.say("DRIVE{Left 2}\t{ Right  2 }");
  rig.wait(1);
  EXPECT_GT(rig.body(c).p_world_m.x, 0.1);
}

TEST(UsarSloppy, LinesEndWithCrOrLfOrBothOrSeveral) {
  Rig rig;
  Client& c = rig.client();
  c.send("INIT {ClassName USARBot.P3AT}\rDRIVE {Left 2} {Right 2}\n\n\r\r\nGETSTARTPOSES\r");
  ASSERT_TRUE(c.robot());
  EXPECT_FALSE(c.last("NFO {StartPoses").empty());
  EXPECT_EQ(rig.game.counts().lines, 3u);
}

TEST(UsarSloppy, MessagesMaySplitAndMergeAnywhere) {
  const std::string all = "INIT {ClassName USARBot.P3AT} {Name R1} {Start Pose1}\r\nDRIVE {Left 2.50} {Right 2.50}\r\n";
  for (std::size_t piece = 1; piece < all.size(); ++piece) {
    Rig rig;
    Client& c = rig.client();
    for (std::size_t at = 0; at < all.size(); at += piece) c.send(std::string_view(all).substr(at, piece));
    ASSERT_TRUE(c.robot()) << piece;
    EXPECT_EQ(c.robot()->vehicle().driven().left_radps, 2.5) << piece;
  }
}

TEST(UsarSloppy, DecimalCommasAreUnderstood) {
  EXPECT_EQ(number_in("0,5"), 0.5);
  EXPECT_EQ(number_in("-1,25"), -1.25);
  EXPECT_FALSE(number_in("1,2,3"));
  EXPECT_FALSE(number_in("nan"));
  wire::UsarLine line;
  for (const char* text : {"X {L 1.5,2,-0.25}", "X {L 1.5 2 -0.25}", "X {L 1,5 2,0 -0,25}", "X {L 1,5;2,0;-0,25}",
                           "X {L 1,5,2,0,-0,25}"}) {
    ASSERT_EQ(parse_usarsim(text, line), wire::UsarError::none);
    EXPECT_EQ(vector_of(line, "L"), (math::Vec3{1.5, 2, -0.25})) << text;
  }
  for (const char* text : {"X {L 1,2}", "X {L 1,2,3,4}", "X {L a,b,c}", "X {L}", "X {M 1,2,3}"}) {
    ASSERT_EQ(parse_usarsim(text, line), wire::UsarError::none);
    EXPECT_FALSE(vector_of(line, "L")) << text;
  }
  Rig rig;
  Client& c = rig.with("P3AT");
  c.say("DRIVE {Left 1,50} {Right 1,50}");
  EXPECT_EQ(c.robot()->vehicle().driven().left_radps, 1.5);
}

TEST(UsarSloppy, WithoutAStartOrWithATakenOneARobotGetsAFreePlace) {
  Rig rig;
  Client &a = rig.with("P3AT", ""), &b = rig.with("P3AT", "{Start Pose1}"), &d = rig.with("P3AT", "{Start NoSuchPose}");
  EXPECT_EQ(rig.body(a).p_world_m.y, 0);
  EXPECT_EQ(rig.body(b).p_world_m.y, 2);
  EXPECT_EQ(rig.body(d).p_world_m.y, -2);
  Client& e = rig.client();
  e.say("INIT {ClassName P3AT} {Start Pose1}");
  EXPECT_FALSE(e.robot());
  EXPECT_THAT(e.last("NFO {Error INIT}"), HasSubstr("something is in the way there"));
}

TEST(UsarSloppy, UnknownLinesAndKeysChangeNothingAndAreCounted) {
  Rig rig;
  Client& c = rig.with("P3AT");
  c.hear();
  c.say("HELLO {World 1}");
  c.say("HELLO");
  c.say("DRIVE {Left 2} {Right 2} {Mood good}");
  c.say("DRIVE {Left 2}");
  c.say("DRIVE {Left x} {Right y}");
  c.say("SET {Type Joint} {Name LKneePitch} {Opcode Angle} {Params 1}");
  c.say("MISPKG {Name Arm} {Link 1} {Value 1} {Order 0}");
  c.say("MISPKG {Name CameraPanTilt} {Link 7} {Value 1} {Order 0}");
  c.say("CAMERA {Rotation 1,2}");
  EXPECT_EQ(c.robot()->vehicle().driven().left_radps, 2);
  EXPECT_TRUE(c.hear().empty());
  const Counts& counts = rig.game.counts();
  EXPECT_EQ(counts.unknown, 2u);
  EXPECT_EQ(counts.of_type.at("HELLO"), 2u);
  EXPECT_EQ(counts.unusable, 6u);
}

TEST(UsarSloppy, CommandsBeforeInitAreCountedAndDoNothing) {
  Rig rig;
  Client& c = rig.client();
  c.hear();
  c.say("DRIVE {Left 2} {Right 2}");
  c.say("GETCONF {Type Robot}");
  EXPECT_TRUE(c.hear().empty());
  EXPECT_EQ(rig.game.counts().unusable, 2u);
}

// ---- the link fails

TEST(UsarLink, GarbageAndTornLinesAreDroppedCountedAndDoNotStopWhatFollows) {
  Rig rig;
  Client& c = rig.client();
  c.send(std::string("\x00\x01\xff{{{}}}\x7f\x02\r\n", 12));
  c.say("INIT {ClassName USARBot.P3AT");
  c.say("INIT {ClassName {USARBot.P3AT}}");
  c.say("} {");
  c.say(std::string(wire::kUsarLine + 10, 'x'));
  c.say("INIT {ClassName USARBot.P3AT}");
  EXPECT_TRUE(c.robot());
  EXPECT_EQ(rig.game.counts().torn, 3u);
  EXPECT_EQ(rig.game.counts().dropped, 2u);
}

TEST(UsarLink, ACutTakesTheRobotAwayAndHalfALineIsNotObeyed) {
  Rig rig;
  Client& a = rig.with("P3AT", "{Start Pose1}");
  const plant::Vehicle* first = rig.place.vehicle(0);
  ASSERT_TRUE(first);
  a.send("DRIVE {Left 5} {Right 5}");  // no line end
  rig.wait(0.5);
  EXPECT_EQ(first->driven().left_radps, 0);
  a.leave();
  rig.clients.clear();
  EXPECT_EQ(rig.game.counts().dropped, 1u);
  EXPECT_EQ(rig.place.robots(), 0u);
  ASSERT_EQ(rig.game.visits().size(), 1u);
  EXPECT_EQ(rig.game.visits()[0].name, "R1");
  Client& b = rig.with("AirRobot", "{Start Pose1}");
  EXPECT_EQ(rig.body(b).p_world_m.x, 0) << "the place is free again";
}

TEST(UsarLink, WhileAClientIsSilentItsRobotDrivesOnAsTheOriginalDoes) {
  Rig rig;
  Client& c = rig.with("AirRobot", "{Location 0,3,1}");
  c.say("DRIVE {LinearVelocity 0.5}");
  rig.wait(10);
  EXPECT_NEAR(rig.body(c).v_world_mps.x, 0.5, 0.01);
}

TEST(UsarLink, AClientThatDoesNotReadCostsBoundedMemory) {
  Rig rig;
  Client& c = rig.with("P2AT");
  for (int i = 0; i < 5000; ++i) c.say("GETCONF {Type RangeScanner}");
  EXPECT_LE(c.session().waiting().size(), Session::kMostWaiting);
  EXPECT_GT(rig.game.counts().unsent, 0u);
  c.hear();
  c.say("GETCONF {Type Robot}");
  EXPECT_FALSE(c.last("CONF").empty()) << "when it reads again it is served again";
}

TEST(UsarFrame, RightHandTurnsZ) {
  Options options;
  options.frame.z_down = true;
  Rig rig(options);
  Client& c = rig.with("AirRobot", "{Location 1,1,-2}");
  EXPECT_EQ(rig.body(c).p_world_m, (math::Vec3{1, -1, 2}));
  rig.wait(0.2);
  EXPECT_THAT(of_type(c.hear(), "GroundTruth").at(0), HasSubstr("{Location 1.00,1.00,-2.00}"));
}

}  // namespace
}  // namespace sinew::usarsim::session_test
