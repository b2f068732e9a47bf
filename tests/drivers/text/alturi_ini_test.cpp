#include "drivers/text/alturi_ini.hpp"

#include <gmock/gmock.h>

#include <fstream>
#include <iterator>

#include "drivers/text/text_spec.hpp"
#include "source_dir.hpp"

namespace sinew::drivers::alturi_ini_test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

std::string file(const std::string& name) {
  std::ifstream in(sinew::test::source_dir() + "/robots/air_robot/" + name, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

DeviceSpec read(std::string_view text) {
  DeviceSpec link;
  link.name = "drone", link.driver = "text";
  std::vector<rt::Problem> problems;
  read_alturi_ini(text, link, problems);
  for (const rt::Problem& p : problems) ADD_FAILURE() << rt::to_string(p, "a.ini");
  return link;
}

std::vector<std::string> problems_of(std::string_view text) {
  DeviceSpec link;
  std::vector<rt::Problem> problems;
  read_alturi_ini(text, link, problems);
  std::vector<std::string> texts;
  for (const rt::Problem& p : problems) texts.push_back(rt::to_string(p, "a.ini"));
  return texts;
}

TextLinkSpec linked(const DeviceSpec& spec) {
  std::vector<rt::Problem> problems;
  DeviceKeys keys(spec, "device.drone", problems);
  const TextLinkSpec link = read_text_link(keys);
  keys.finish();
  for (const rt::Problem& p : problems) ADD_FAILURE() << rt::to_string(p, "a.ini");
  return link;
}

std::string written(const wire::TextTemplate& text, const std::vector<double>& values) {
  std::array<char, 1000> out{};
  std::uint32_t sequence = 5;
  return {out.data(), text.write(values, sequence, out)};
}

TEST(AlturiIni, TheAirRobotsFileIsReadAsItIs) {
  const TextLinkSpec link = linked(read(file("airrobot.ini")));
  EXPECT_EQ(link.main.endpoint, "tcp:127.0.0.1:3000");
  ASSERT_EQ(link.drives.size(), 4u);
  EXPECT_EQ(link.drives[0].name, "AltitudeVelocity");
  EXPECT_EQ(link.drives[0].range.fitted(7.0), 5.0);
  EXPECT_NEAR(link.drives[0].range.fitted(0.123), 0.12, 1e-12);
  ASSERT_EQ(link.drive_lines.size(), 1u);
  EXPECT_EQ(written(link.drive_lines[0], {0.5, -1, 0, 0}),
            "DRIVE {AltitudeVelocity 0.50} {LinearVelocity -1.00} {LateralVelocity 0.00} {RotationalVelocity 0.00}");
  ASSERT_EQ(link.commands.size(), 1u);
  EXPECT_EQ(written(link.commands[0].text, {1.2}), "CAMERA {Rotation 0,0,1.20} {Zoom 0}");
  ASSERT_EQ(link.values.size(), 4u);
  EXPECT_EQ(link.values[3].name, "Location_2");
  EXPECT_EQ(link.values[3].message, "SEN");
  EXPECT_EQ(link.values[3].index, 2u);
}

TEST(AlturiIni, ThePioneersFileIsReadAsItIs) {
  const TextLinkSpec link = linked(read(file("p3at.ini")));
  EXPECT_EQ(written(link.drive_lines.at(0), {1, -1, 1, 0}), "DRIVE {Left 1.00} {Right -1.00} {Light 1} {Flip 0}");
}

TEST(AlturiIni, AFileForTheRealDroneIsSequenceNumbersAndFloatsAsBits) {
  const TextLinkSpec link = linked(
      read("[connection]\r\nSimIP4=192.168.1.1\r\nSimCommandPort=5556\r\nSimImagePort=5555\r\nSimSensorPort=5554\r\n"
           "[drives]\r\nDrivePrefix=AT*\r\nDriveTotal=2\r\nDriveFirstParameter=2\r\nDriveNormalize=0\r\n"
           "[drive1]\r\nKey=PCMD=%d,1,0,0,%d,0\r\nMin=-1.0\r\nMax=1.0\r\nIncrement=0.01\r\n"
           "[drive2]\r\nKey=PCMD=%d,1,0,%d,0,0\r\nMin=-1.0\r\nMax=1.0\r\nIncrement=0.01\r\n"
           "[commands]\r\nCommandPrefix=\r\nCommandTotal=2\r\n"
           "[command1]\r\nkey=AT*REF=%d,%d\r\nMin=290717696\r\nMax=290718208\r\nIncrement=512\r\n"
           "[command2]\r\nkey=AT*COMWDG=%d\r\nMin=0\r\nMax=0\r\nIncrement=0\r\n"
           "[messages]\r\nMessageTotal=0\r\n[message1]\r\nMessageName=STA\r\nKeyName=Battery\r\nIndex=0"));
  EXPECT_FALSE(link.main.tcp);
  EXPECT_EQ(link.main.peer.port, 5556);
  ASSERT_TRUE(link.state);
  EXPECT_EQ(link.state->peer.port, 5554);
  EXPECT_EQ(link.state->decoder, TextDecoder::navdata);
  EXPECT_EQ(link.line_end, "\r");
  ASSERT_EQ(link.drive_lines.size(), 2u) << "each drive is a command of its own";
  EXPECT_EQ(written(link.drive_lines[1], {-0.8}), "AT*PCMD=5,1,0,-1085485875,0,0");
  EXPECT_EQ(written(link.commands.at(0).text, {290718208}), "AT*REF=5,290718208");
  EXPECT_EQ(link.commands[0].range.fitted(290717900), 290717696);
  EXPECT_EQ(link.commands.at(1).text.values(), 0u);
  EXPECT_TRUE(link.values.empty()) << "what the total does not count is not there";
}

TEST(AlturiIni, NormalizedDrivesGoFromMinusToPlusAHundred) {
  const TextLinkSpec link =
      linked(read("[connection]\nSimIP4=1.2.3.4\nSimCommandPort=3000\n[drives]\nDriveTotal=1\n"
                  "DriveNormalize=1\n[drive1]\nKey={Left %d}\nMin=-5\nMax=5\nIncrement=1\n"));
  EXPECT_EQ(link.drives.at(0).range.max, 100.0);
  EXPECT_EQ(link.drives.at(0).range.min, -100.0);
}

TEST(AlturiIni, EveryProblemHasItsLine) {
  const auto all = problems_of(
      "[connection]\nSimIP4=1.2.3\nSimCommandPort=70000\nSimImagPort=80\n[drives]\nDriveTotal=2\n[drive1]\n"
      "Key={Left %1.2f}\nMin=5\nMax=1\nIncrement=x\n[messages]\nMessageTotal=1\n[message1]\nMessageName=STA\n"
      "Index=-1\n[drve2]\nwhat\n");
  EXPECT_THAT(all,
              ::testing::IsSupersetOf({HasSubstr("a.ini:2: connection.SimIP4"), HasSubstr("a.ini:3: connection."),
                                       HasSubstr("a.ini:4: connection.SimImagPort"),
                                       HasSubstr("a.ini:6: drives.DriveTotal"), HasSubstr("a.ini:10: drive1.Max"),
                                       HasSubstr("a.ini:11: drive1.Increment"), HasSubstr("a.ini:14: message1.KeyName"),
                                       HasSubstr("a.ini:17: [drve2]"), HasSubstr("a.ini:18: INI")}));
  EXPECT_FALSE(problems_of("").empty());
}

}  // namespace
}  // namespace sinew::drivers::alturi_ini_test
