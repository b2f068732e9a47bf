#include "wire/text/usarsim.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "source_dir.hpp"

namespace sinew::wire::usarsim_test {
namespace {

UsarError error_of(std::string_view text) {
  static UsarLine line;
  return parse_usarsim(text, line);
}

const UsarLine& parsed(std::string_view text) {
  static UsarLine line;
  EXPECT_EQ(parse_usarsim(text, line), UsarError::none) << text;
  return line;
}

std::vector<std::string> lines_of(UsarLines& lines, std::string_view text) {
  std::vector<std::string> found;
  for (const char c : text)
    if (lines.push(c)) found.emplace_back(lines.line());
  return found;
}

TEST(Usarsim, LinesEndWithCrOrLfWhereverThePiecesEnd) {
  UsarLines lines;
  EXPECT_EQ(lines_of(lines, "A {B 1}\r\nC\rD\n\n\r\nE"), (std::vector<std::string>{"A {B 1}", "C", "D"}));
  EXPECT_EQ(lines_of(lines, "F\n"), (std::vector<std::string>{"EF"}));
  EXPECT_EQ(lines.dropped(), 0u);
}

TEST(Usarsim, ALineThatIsTooLongOrNoTextIsDroppedAndTheNextIsRead) {
  UsarLines lines;
  EXPECT_EQ(lines_of(lines, std::string(kUsarLine + 1, 'x') + "\nA\n"), (std::vector<std::string>{"A"}));
  EXPECT_EQ(lines.dropped(), 1u);
  EXPECT_EQ(lines_of(lines, std::string("B\0C\nD\n", 6)), (std::vector<std::string>{"D"}));
  EXPECT_EQ(lines.dropped(), 2u);
}

TEST(Usarsim, ALineThatTheConnectionCutDoesNotGoOnInTheNextConnection) {
  UsarLines lines;
  EXPECT_TRUE(lines_of(lines, "SEN {Ti").empty());
  EXPECT_TRUE(lines.reset());
  EXPECT_EQ(lines_of(lines, "STA\n"), (std::vector<std::string>{"STA"}));
  EXPECT_FALSE(lines.reset());
}

TEST(Usarsim, KeysKeepTheirOrderAndMayOccurAgain) {
  const UsarLine& line = parsed("MISPKG {Name CameraPanTilt} {Link 1} {Value 0.5} {Order 0} {Link 2} {Value -1}");
  EXPECT_EQ(line.type, "MISPKG");
  ASSERT_EQ(line.count, 6u);
  EXPECT_EQ(line.part[1].key, "Link");
  EXPECT_EQ(line.find("Value", line.index_of("Link", 2)).value, "-1");
  EXPECT_EQ(line.index_of("value"), line.count) << "case matters";
}

TEST(Usarsim, BlanksAreTakenAsRealProgramsWriteThem) {
  const UsarLine& line = parsed("  DRIVE{Left 1.0}{ Right   -1.0 }\t{} { Light true}  ");
  EXPECT_EQ(line.type, "DRIVE");
  ASSERT_EQ(line.count, 3u);
  EXPECT_EQ(line.find("Right").value, "-1.0");
  EXPECT_EQ(usar_number(line.find("Light").value), 1.0);
}

TEST(Usarsim, SeveralKeysInOneBraceAreAPartEach) {
  const UsarLine& line = parsed("SEN {Type Sonar} {Name F1 Range 0.5 Name F2 Range 0.75}");
  ASSERT_EQ(line.count, 5u);
  EXPECT_EQ(line.part[3].value, "F2");
  EXPECT_EQ(usar_number(line.find("Range", 4).value), 0.75);
  EXPECT_EQ(line.part[1].brace, line.part[4].brace);
}

TEST(Usarsim, StartPosesAreNotTakenForSeveralKeys) {
  const UsarLine& line = parsed("NFO {StartPoses 2} {Pose1 1,2,3 0,0,1.57 Pose2 4,5,6 0,0,0}");
  ASSERT_EQ(line.count, 2u);
  EXPECT_EQ(line.part[1].key, "Pose1");
  EXPECT_EQ(line.part[1].value, "1,2,3 0,0,1.57 Pose2 4,5,6 0,0,0");
  EXPECT_EQ(usar_number(line.part[1].value, 5), 1.57);
}

TEST(Usarsim, TornLinesAreRefusedByWhatIsWrongWithThem) {
  EXPECT_EQ(error_of("STA {Time 44.18} {LightIntensitReceived: SEN {Time 44.37} {Type GPS}"), UsarError::brace);
  EXPECT_EQ(error_of("SEN {Time 44.3"), UsarError::brace);
  EXPECT_EQ(error_of("GPS} {Name GPS}"), UsarError::brace);
  EXPECT_EQ(error_of("Received: SEN {Time 43.3761}"), UsarError::text);
  EXPECT_EQ(error_of("SEN {Time 1} ok"), UsarError::text);
  EXPECT_EQ(error_of("{Time 1}"), UsarError::text);
  EXPECT_EQ(error_of(" \t"), UsarError::empty);
  std::string many = "SEN";
  for (std::size_t i = 0; i <= kUsarParts; ++i) many += " {K 1}";
  EXPECT_EQ(error_of(many), UsarError::too_many);
}

TEST(Usarsim, NumbersOfAVectorAreFoundByTheirIndex) {
  EXPECT_EQ(usar_number("1.20,2.50,-2.05", 2), -2.05);
  EXPECT_EQ(usar_number("1.20, 2.50 ,-2.05", 1), 2.5);
  EXPECT_EQ(usar_number("1 2 3", 2), 3.0);
  EXPECT_EQ(usar_number("1.20,,3", 1), std::nullopt);
  EXPECT_EQ(usar_number("1.20,,3", 2), 3.0);
  EXPECT_EQ(usar_number("1.20,2.50", 2), std::nullopt);
  EXPECT_EQ(usar_number("47,40.33,N", 2), std::nullopt);
  EXPECT_EQ(usar_item("47,40.33,N", 2), "N");
  EXPECT_EQ(usar_count("47,40.33,N"), 3u);
  EXPECT_EQ(usar_number("nan"), std::nullopt);
  EXPECT_EQ(usar_number("1e999"), std::nullopt);
  EXPECT_EQ(usar_number("1.5x"), std::nullopt);
  EXPECT_EQ(usar_number("False"), 0.0);
}

TEST(Usarsim, ACommaIsThePointOfClientsWithSuchALocale) {
  EXPECT_EQ(usar_number("4,5 1,8 -0,25", 2, true), -0.25);
  EXPECT_EQ(usar_number("4,5;1,8", 1, true), 1.8);
  EXPECT_EQ(usar_count("4,5 1,8", true), 2u);
}

TEST(Usarsim, LinesAreWrittenAsTheSimulatorWritesThem) {
  std::array<char, 256> text{};
  UsarWriter out(text);
  const double location[] = {1.2, 2.5, 2.05};
  out.type("SEN").number("Time", 42.9771, 4).text("Type", "GroundTruth").vector("Location", location, 2);
  out.integer("Tick", -3).flag("Touch", true);
  out.open().word("Name").word("F1").word("Range").word(0.5, 4).close();
  EXPECT_EQ(out.line(),
            "SEN {Time 42.9771} {Type GroundTruth} {Location 1.20,2.50,2.05} {Tick -3} {Touch True} {Name F1 Range "
            "0.5000}\r\n");
}

TEST(Usarsim, ALineThatDoesNotFitIsEmpty) {
  std::array<char, 12> text{};
  UsarWriter out(text);
  EXPECT_EQ(out.type("SEN").number("Time", 42.9771, 4).line(), "");
}

TEST(Usarsim, FixedNumbersAreThoseOfTheCLibrary) {
  for (const double value : {0.0, -0.0, 0.125, 2.5, -1.005, 1e22, 123456.789, 5e-324, -0.004})
    for (const int decimals : {0, 1, 2, 4, 17}) {
      std::array<char, 352> own{}, libs{};
      const std::size_t n = write_fixed(value, decimals, own);
      std::snprintf(libs.data(), libs.size(), "%.*f", decimals, value);
      EXPECT_EQ(std::string_view(own.data(), n), std::string_view(libs.data())) << value << ' ' << decimals;
    }
  std::array<char, 8> small{};
  EXPECT_EQ(write_fixed(1e10, 2, small), 0u);
  EXPECT_EQ(write_fixed(std::nan(""), 2, small), 0u);
}

// ---- the session that altURI's author captured

struct Session {
  std::size_t good = 0, torn = 0, battery_rows = 0;
  std::vector<double> battery, time_s, height_m;
  double last_roll_rad = -1, torque = 0;
};

Session read_session(const std::string& path) {
  Session s;
  std::ifstream in(path, std::ios::binary);
  UsarLines lines;
  static UsarLine line;
  for (char c; in.get(c);) {
    if (!lines.push(c)) continue;
    if (parse_usarsim(lines.line(), line) != UsarError::none) {
      ++s.torn;
      continue;
    }
    ++s.good;
    if (line.type == "STA") s.battery.push_back(*usar_number(line.find("Battery").value));
    if (line.type == "MISSTA") s.torque = *usar_number(line.find("Torque").value);
    if (line.find("Type").value != "GroundTruth") continue;
    s.time_s.push_back(*usar_number(line.find("Time").value));
    s.height_m.push_back(*usar_number(line.find("Location").value, 2));
    s.last_roll_rad = *usar_number(line.find("Orientation").value, 0);
  }
  EXPECT_EQ(lines.dropped(), 0u);
  return s;
}

TEST(Usarsim, TheCapturedSessionIsDecodedAndItsTornLinesAreCounted) {
  std::string path = sinew::test::source_dir() + "/../shared/data/usarsim/airrobot_session.txt";
  if (!std::filesystem::exists(path))
    path = sinew::test::source_dir() + "/../../shared/data/usarsim/airrobot_session.txt";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "shared/data/usarsim is not beside the checkout";
  const Session s = read_session(path);
  // Of 85 lines eight hold the debugger's mark "Received:", four at their beginning and four in their middle, and the
  // last one goes over into the debugger's own text.
  EXPECT_EQ(s.torn, 9u);
  EXPECT_EQ(s.good, 76u);
  ASSERT_FALSE(s.battery.empty());
  EXPECT_EQ(s.battery.front(), 1182.0);
  EXPECT_EQ(s.battery.back(), 1178.0);
  ASSERT_FALSE(s.time_s.empty());
  EXPECT_EQ(s.time_s.front(), 42.9771);
  EXPECT_EQ(s.time_s.back(), 47.1767);
  for (const double height_m : s.height_m) EXPECT_EQ(height_m, 2.05);
  EXPECT_EQ(s.last_roll_rad, 0.0);
  EXPECT_EQ(s.torque, -20.0);
}

}  // namespace
}  // namespace sinew::wire::usarsim_test
