#include "wire/text/text_template.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <limits>

namespace sinew::wire::text_template_test {
namespace {

std::string written(std::string_view text, std::vector<double> values, std::vector<std::string> words = {},
                    std::uint32_t sequence = 7) {
  std::string why;
  const auto made = TextTemplate::parse(text, std::move(words), why);
  EXPECT_TRUE(made) << text << ": " << why;
  if (!made) return "?";
  std::array<char, 1500> out{};
  return {out.data(), made->write(values, sequence, out)};
}

std::string refused(std::string_view text, std::vector<std::string> words = {}) {
  std::string why;
  EXPECT_FALSE(TextTemplate::parse(text, std::move(words), why)) << text;
  return why;
}

TEST(TextTemplate, CommandsOfAltUrisFilesAreWritten) {
  EXPECT_EQ(written("DRIVE {AltitudeVelocity %1.2f} {LinearVelocity %1.2f}", {0.5, -5}),
            "DRIVE {AltitudeVelocity 0.50} {LinearVelocity -5.00}");
  EXPECT_EQ(written("{Light %i}", {1}), "{Light 1}");
  EXPECT_EQ(written("CAMERA {Rotation 0,0,%1.2f} {Zoom 0}", {3.1}), "CAMERA {Rotation 0,0,3.10} {Zoom 0}");
}

TEST(TextTemplate, AtCommandsHaveASequenceAndTheBitsOfTheirFloats) {
  // -0.8 is -1085485875 in Parrot's Developer Guide 2.0, section 6.2; 0.05 is 1028443341 there.
  EXPECT_EQ(written("AT*PCMD=%q,1,%b,%b,%b,%b\r", {0, 0, 0.05, -0.8}), "AT*PCMD=7,1,0,0,1028443341,-1085485875\r");
  std::string why;
  const auto two = TextTemplate::parse("AT*REF=%q,%d\rAT*COMWDG=%q\r", {}, why);
  std::uint32_t sequence = 41;
  std::array<char, 100> out{};
  const double land[] = {290717696};
  EXPECT_EQ(std::string(out.data(), two->write(land, sequence, out)), "AT*REF=41,290717696\rAT*COMWDG=42\r");
  EXPECT_EQ(sequence, 43u);
  EXPECT_EQ(written("%b", {-0.0}), "-2147483648");
  EXPECT_EQ(written("%b", {1e39}), "") << "no float";
}

TEST(TextTemplate, WordsAreChosenByTheirNumber) {
  EXPECT_EQ(written("%s", {1}, {"land", "takeoff"}), "takeoff");
  EXPECT_EQ(written("%8s|%-6s|", {0, 0}, {"land"}), "    land|land  |");
  EXPECT_EQ(written("%s", {2}, {"land", "takeoff"}), "");
  EXPECT_EQ(written("%s", {-1}, {"land", "takeoff"}), "");
}

TEST(TextTemplate, NumbersAreThoseOfPrintf) {
  for (const char* format :
       {"%f", "%1.2f", "%+.3e", "%08.2f", "%-10.1f|", "% g", "%.10g", "%G", "%E", "%.0f", "%+010.3f"})
    for (const double value : {0.0, 1.0, -1.5, 0.005, 123456789.0, 1e-7, -2e30, 9.995, 1.0 / 3}) {
      std::array<char, 400> libs{};
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wformat-nonliteral"
      std::snprintf(libs.data(), libs.size(), format, value);
#pragma GCC diagnostic pop
      EXPECT_EQ(written(format, {value}), libs.data()) << format << ' ' << value;
    }
  EXPECT_EQ(written("%+05d|%3i|%-4d|%u|% d", {12, 7, -3, 4, 5}), "+0012|  7|-3  |4| 5");
}

TEST(TextTemplate, WholeNumbersAreRounded) {
  EXPECT_EQ(written("%d %d %d %d", {0.49, 0.5, -1.5, -0.2}), "0 1 -2 0");
  EXPECT_EQ(written("%d", {1e300}), "");
  EXPECT_EQ(written("%u", {-1}), "") << "no such number without a sign";
}

TEST(TextTemplate, WhatIsNoNumberIsNeverWritten) {
  for (const char* format : {"%f", "%d", "%u", "%g", "%b"}) {
    EXPECT_EQ(written(format, {std::nan("")}), "") << format;
    EXPECT_EQ(written(format, {std::numeric_limits<double>::infinity()}), "") << format;
  }
  EXPECT_EQ(written("%f", {}), "") << "too few values";
}

TEST(TextTemplate, WhatDoesNotFitIsNotWritten) {
  std::string why;
  const auto made = TextTemplate::parse("%f", {}, why);
  std::uint32_t sequence = 1;
  std::array<char, 8> out{};
  const double value[] = {1.5};
  EXPECT_EQ(made->write(value, sequence, out), 8u);
  const double large[] = {12.5};
  EXPECT_EQ(made->write(large, sequence, out), 0u);
}

TEST(TextTemplate, OnlyTheListedConversionsAreTaken) {
  EXPECT_NE(refused("x %n").find("\"%n\" is no conversion"), std::string::npos);
  for (const char* bad : {"%p", "%x", "%ld", "%hhd", "%*d", "%1$d", "%c", "%", "50%", "%a", "%-", "%#x", "%L"})
    EXPECT_FALSE(refused(bad).empty()) << bad;
  EXPECT_FALSE(refused("%65d").empty());
  EXPECT_FALSE(refused("%99999999999999999999d").empty());
  EXPECT_FALSE(refused("%.18f").empty());
  EXPECT_FALSE(refused("%.2d").empty());
  EXPECT_FALSE(refused("%5%").empty());
  EXPECT_FALSE(refused("%s").empty()) << "without words";
  EXPECT_FALSE(refused(std::string(1001, 'x')).empty());
  EXPECT_EQ(written("100%%", {}), "100%");
}

}  // namespace
}  // namespace sinew::wire::text_template_test
