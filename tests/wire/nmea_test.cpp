#include "wire/nmea.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "bytes.hpp"

namespace sinew::wire::nmea_test {
namespace {

using test::Bytes, test::bytes_of, test::frames_in, test::joined;

constexpr const char* kGga = "$GPGGA,123519,4807.038,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,*47\r\n";
constexpr const char* kRmc = "$GPRMC,123519,A,4807.038,N,01131.000,E,022.4,084.4,230394,003.1,W*6A\r\n";
constexpr const char* kVtg = "$GPVTG,054.7,T,034.4,M,005.5,N,010.2,K*48\r\n";
constexpr const char* kGsa = "$GPGSA,A,3,04,05,,09,12,,,24,,,,,2.5,1.3,2.1*39\r\n";

/// The only sentence of a text; its frame lives on.
struct One {
  explicit One(std::string_view text) {
    NmeaScanner scanner;
    frames = frames_in(scanner, bytes_of(text));
    EXPECT_EQ(frames.size(), 1u) << text;
    if (!frames.empty()) sentence = split_nmea(frames[0]).value_or(NmeaSentence{});
  }
  std::vector<Bytes> frames;
  NmeaSentence sentence;
};

/// Puts the right checksum behind a body.
std::string closed(std::string body) {
  unsigned sum = 0;
  for (const char c : body) sum ^= static_cast<unsigned char>(c);
  char end[8];
  std::snprintf(end, sizeof end, "*%02X\r\n", sum);
  return "$" + body + end;
}

TEST(Nmea, GgaHoldsThePosition) {
  const One one(kGga);
  EXPECT_EQ(one.sentence.talker, "GP");
  const auto g = decode_gga(one.sentence);
  ASSERT_TRUE(g);
  EXPECT_DOUBLE_EQ(g->time_s, 12 * 3600 + 35 * 60 + 19);
  EXPECT_NEAR(g->latitude_deg, 48.1173, 1e-9);
  EXPECT_NEAR(g->longitude_deg, 11.0 + 31.0 / 60, 1e-12);
  EXPECT_DOUBLE_EQ(g->altitude_m, 545.4);
  EXPECT_DOUBLE_EQ(g->hdop, 0.9);
  EXPECT_EQ(g->quality, 1);
  EXPECT_EQ(g->satellites, 8);
}

TEST(Nmea, RmcHoldsSpeedCourseAndDate) {
  const One one(kRmc);
  const auto r = decode_rmc(one.sentence);
  ASSERT_TRUE(r);
  EXPECT_TRUE(r->valid);
  EXPECT_NEAR(r->speed_mps, 22.4 * 0.514444, 1e-4);
  EXPECT_DOUBLE_EQ(r->course_deg, 84.4);
  EXPECT_EQ(r->day, 23);
  EXPECT_EQ(r->month, 3);
  EXPECT_EQ(r->year, 2094) << "two digits are of this century";
}

TEST(Nmea, VtgAndGsaAreRead) {
  const One vtg(kVtg), gsa(kGsa);
  ASSERT_TRUE(decode_vtg(vtg.sentence));
  EXPECT_NEAR(decode_vtg(vtg.sentence)->speed_mps, 10.2 / 3.6, 1e-12);
  EXPECT_DOUBLE_EQ(decode_vtg(vtg.sentence)->course_deg, 54.7);
  const auto g = decode_gsa(gsa.sentence);
  ASSERT_TRUE(g);
  EXPECT_EQ(g->fix, 3);
  EXPECT_DOUBLE_EQ(g->vdop, 2.1);
  EXPECT_FALSE(decode_gga(gsa.sentence)) << "another kind of sentence";
}

TEST(Nmea, SouthAndWestAreNegative) {
  const One one(closed("GNGGA,000000.00,3351.000,S,15112.000,W,4,20,0.5,1.0,M,,M,,"));
  const auto g = decode_gga(one.sentence);
  ASSERT_TRUE(g);
  EXPECT_DOUBLE_EQ(g->latitude_deg, -33.85);
  EXPECT_DOUBLE_EQ(g->longitude_deg, -151.2);
}

TEST(Nmea, WhatTheReceiverLeavesOutIsUnknown) {
  const One one(closed("GNGGA,,,,,,0,00,99.99,,,,,,"));
  const auto g = decode_gga(one.sentence);
  ASSERT_TRUE(g);
  EXPECT_EQ(g->quality, 0);
  EXPECT_TRUE(std::isnan(g->latitude_deg));
  EXPECT_TRUE(std::isnan(g->altitude_m));
  EXPECT_TRUE(std::isnan(g->time_s));
}

TEST(Nmea, AFieldThatIsNoSuchNumberSpoilsTheSentence) {
  for (const char* body : {"GPGGA,123519,48x7.038,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,",
                           "GPGGA,123519,4807.038,Q,01131.000,E,1,08,0.9,545.4,M,46.9,M,,",
                           "GPGGA,123519,9907.038,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,",
                           "GPGGA,123519,4861.038,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,",
                           "GPGGA,253519,4807.038,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,",
                           "GPGGA,123519,4807.038,N,01131.000,E,1,-8,0.9,545.4,M,46.9,M,,",
                           "GPGGA,123519,4807.038,N,01131.000,E,1,08,nan,545.4,M,46.9,M,,"}) {
    const One one(closed(body));
    EXPECT_FALSE(decode_gga(one.sentence)) << body;
  }
}

TEST(Nmea, AWrongChecksumIsNoSentenceAndTheNextOneIs) {
  std::string bad = kGga;
  bad[20] ^= 1;
  NmeaScanner scanner;
  const auto frames = frames_in(scanner, bytes_of(bad + kRmc));
  ASSERT_EQ(frames.size(), 1u);
  EXPECT_EQ(split_nmea(frames[0])->kind, "RMC");
  EXPECT_EQ(scanner.stats().broken, 1u);
}

TEST(Nmea, ASentenceThatIsCutShortDoesNotSwallowTheNext) {
  NmeaScanner scanner;
  const auto frames = frames_in(scanner, bytes_of(std::string("$GPGGA,1235") + kRmc));
  ASSERT_EQ(frames.size(), 1u);
  EXPECT_EQ(split_nmea(frames[0])->kind, "RMC");
}

TEST(Nmea, EndlessLinesAndOtherBytesArePassedOver) {
  NmeaScanner scanner;
  const auto frames = frames_in(scanner, joined({Bytes(5000, 'A'), bytes_of("$" + std::string(500, 'B')),
                                                 Bytes{0xB5, 0x62, 0, 0xFF}, bytes_of(kGga)}));
  EXPECT_EQ(frames.size(), 1u);
}

TEST(Nmea, MakersOwnSentencesAreNotMistaken) {
  NmeaScanner scanner;
  const auto frames = frames_in(scanner, bytes_of(closed("PUBX,00,1,2")));
  ASSERT_EQ(frames.size(), 1u);
  EXPECT_FALSE(split_nmea(frames[0]));
}

}  // namespace
}  // namespace sinew::wire::nmea_test
