// The names that somebody may have meant who wrote one that does not exist.
#include "hal/did_you_mean.hpp"

#include <gtest/gtest.h>

namespace sinew::hal::did_you_mean_test {
namespace {

const std::vector<std::string> kNames{
    "imu.raw", "filter.state", "filter.status", "search_height_m", "control::Mixer", "kp_yaw",
    "kd_yaw",  "seed",         "run",           "--virtual"};

TEST(DidYouMean, LettersThatAreMissingTooManyWrongOrExchanged) {
  for (const auto& [asked, meant] : {std::pair{"imu.rw", "imu.raw"},
                                     {"imu.rraw", "imu.raw"},
                                     {"imu.riw", "imu.raw"},
                                     {"imu.rwa", "imu.raw"},
                                     {"sede", "seed"},
                                     {"rnu", "run"},
                                     {"--viritual", "--virtual"},
                                     {"control::Mxier", "control::Mixer"}})
    EXPECT_EQ(did_you_mean(asked, kNames), "; did you mean " + std::string(meant) + "?") << asked;
}

TEST(DidYouMean, TheUnitTheSourceOrTheNamespaceMayBeMissing) {
  EXPECT_EQ(did_you_mean("search_height", kNames), "; did you mean search_height_m?");
  EXPECT_EQ(did_you_mean("imu", kNames), "; did you mean imu.raw?");
  EXPECT_EQ(did_you_mean("Mixer", kNames), "; did you mean control::Mixer?");
  EXPECT_EQ(did_you_mean("Mixxer", kNames), "; did you mean control::Mixer?") << "and a letter wrong";
  EXPECT_EQ(did_you_mean("filt", kNames), "") << "the middle of a word is no end";
}

TEST(DidYouMean, CapitalLettersAndDashesAreNoDifference) {
  EXPECT_EQ(did_you_mean("SEED", kNames), "; did you mean seed?");
  EXPECT_EQ(did_you_mean("search-height-m", kNames), "; did you mean search_height_m?");
}

TEST(DidYouMean, TheNearestNameAloneAndTwoThatAreEquallyNear) {
  EXPECT_EQ(did_you_mean("filter.stat", kNames), "; did you mean filter.state?") << "one letter, not two";
  EXPECT_EQ(did_you_mean("ki_yaw", kNames), "; did you mean kp_yaw or kd_yaw?");
  const std::vector<std::string> three{"aa1", "aa2", "aa3"};
  EXPECT_EQ(did_you_mean("aa4", three), "; did you mean aa1 or aa2?") << "the first two, in their order";
}

TEST(DidYouMean, ANameThatResemblesNoneGetsNoAnswer) {
  for (const char* asked : {"", "x", "moon", "nobody", "fly", "imu.magnetometer"})
    EXPECT_EQ(did_you_mean(asked, kNames), "") << asked;
  EXPECT_EQ(did_you_mean(std::string(100'000, 'a'), kNames), "") << "and takes no time";
  EXPECT_EQ(did_you_mean("seed", {}), "");
}

}  // namespace
}  // namespace sinew::hal::did_you_mean_test
