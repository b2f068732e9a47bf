#include "dataset/dataset_files.hpp"

#include <gtest/gtest.h>

#include "dataset/ground_truth.hpp"

namespace sinew::dataset::dataset_files_test {
namespace {

std::string imu_problem(std::string_view text) {
  std::vector<msg::ImuSample> out;
  std::string why;
  const bool good = parse_imu_csv(text, "imu0.csv", out, why);
  EXPECT_EQ(good, why.empty());
  return why;
}
std::string list_problem(std::string_view text) {
  std::vector<ImageEntry> out;
  std::string why;
  const bool good = parse_image_list(text, "data.csv", out, why);
  EXPECT_EQ(good, why.empty());
  return why;
}

TEST(DatasetFiles, ImuLinesAreReadAsWritten) {
  std::vector<msg::ImuSample> out;
  std::string why;
  ASSERT_TRUE(
      parse_imu_csv("#timestamp [ns],w,w,w,a,a,a\n"
                    "1403715273262142976,-0.0020943951023931952,1e-3,2,9.0874956666666655,-3,0.5\r\n"
                    "\n"
                    "1403715273267142912, 1, 2, 3, 4, 5, 6, a further column\n"
                    "1403715273272143104,7,8,9,10,11,12",  // no end of line
                    "f", out, why))
      << why;
  ASSERT_EQ(out.size(), 3u);
  EXPECT_EQ(out[0].stamp.ns, 1403715273262142976);
  EXPECT_EQ(out[0].gyro_radps.x, -0.0020943951023931952);
  EXPECT_EQ(out[0].gyro_radps.y, 1e-3);
  EXPECT_EQ(out[0].accel_mps2.x, 9.0874956666666655);
  EXPECT_EQ(out[1].accel_mps2, (msg::Vec3{4, 5, 6}));
  EXPECT_EQ(out[2].gyro_radps, (msg::Vec3{7, 8, 9}));
}

TEST(DatasetFiles, EveryProblemNamesFileLineAndColumn) {
  EXPECT_EQ(imu_problem("# head\n1,0,0,0,0,0,0\n2,0,zero,0,0,0,0\n"),
            "imu0.csv:3: column 3: 'zero' is not a finite number");
  EXPECT_EQ(imu_problem("1,0,0,0,0,0,nan\n"), "imu0.csv:1: column 7: 'nan' is not a finite number");
  EXPECT_EQ(imu_problem("1,0,0,0,0,1e999,0\n"), "imu0.csv:1: column 6: '1e999' is not a finite number");
  EXPECT_EQ(imu_problem("1,0,0,0,0,0,\n"), "imu0.csv:1: column 7: '' is not a finite number");
  EXPECT_EQ(imu_problem("1.5,0,0,0,0,0,0\n"), "imu0.csv:1: column 1: '1.5' is not a time stamp in nanoseconds");
  EXPECT_EQ(imu_problem("-5,0,0,0,0,0,0\n"), "imu0.csv:1: column 1: '-5' is not a time stamp in nanoseconds");
  EXPECT_EQ(imu_problem("99999999999999999999,0,0,0,0,0,0"),
            "imu0.csv:1: column 1: '99999999999999999999' is not a time stamp in nanoseconds");
  EXPECT_EQ(imu_problem("7,0,0,0,0,0,0\n\n7,0,0,0,0,0,0\n"),
            "imu0.csv:3: column 1: stamp 7 is not after the one before, 7");
  EXPECT_EQ(imu_problem("7,0,0,0\n"), "imu0.csv:1: 4 columns; at least 7 are needed");
  EXPECT_EQ(imu_problem(std::string("1,0,0,0,0,0,\x01\x80") + std::string(60, 'x')),
            "imu0.csv:1: column 7: '??" + std::string(38, 'x') + "...' is not a finite number");
}

TEST(DatasetFiles, ImageNamesStayInsideTheFolder) {
  EXPECT_EQ(list_problem("1,a.png\n2,b.png\n"), "");
  EXPECT_EQ(list_problem("1,a.png\n2,../b.png\n"),
            "data.csv:2: column 2: '../b.png' is not a file name without folders");
  EXPECT_EQ(list_problem("1,/etc/x\n"), "data.csv:1: column 2: '/etc/x' is not a file name without folders");
  EXPECT_EQ(list_problem("1,..\n"), "data.csv:1: column 2: '..' is not a file name without folders");
  EXPECT_EQ(list_problem("1,\n"), "data.csv:1: column 2: '' is not a file name without folders");
  EXPECT_EQ(list_problem("1\n"), "data.csv:1: 1 columns; at least 2 are needed");
  std::int64_t stamp = 0;
  EXPECT_TRUE(stamp_of_image_name("1403715273262142976.png", stamp));
  EXPECT_EQ(stamp, 1403715273262142976);
  for (const char* bad : {"x.png", ".png", "12.jpg", "-1.png", "1 .png", "9999999999999999999999.png"})
    EXPECT_FALSE(stamp_of_image_name(bad, stamp)) << bad;
}

std::string truth_line(std::int64_t stamp, const std::string& quat, const std::string& v = "1,2,3") {
  return std::to_string(stamp) + ",0.5,0.25,1," + quat + "," + v + ",0.1,0.2,0.3,0.4,0.5,0.6\n";
}

TEST(GroundTruth, IsInterpolatedBetweenSamplesAndAbsentOutside) {
  std::vector<GroundTruthSample> samples;
  std::string why;
  // A quarter turn about z; the second is written with the opposite sign, the same rotation.
  ASSERT_TRUE(parse_ground_truth_csv(
      truth_line(1000, "1,0,0,0") + truth_line(2000, "-0.70710678,0,0,-0.70710678", "3,2,1"), "f", samples, why))
      << why;
  const GroundTruth truth(samples);
  GroundTruthSample s;
  ASSERT_TRUE(truth.at(1500, s));
  EXPECT_NEAR(s.v_world_mps.x, 2, 1e-12);
  EXPECT_NEAR(s.q_world_base.w, 0.92388, 1e-4);  // cos(22.5 deg)
  EXPECT_NEAR(s.q_world_base.z, 0.38268, 1e-4);
  EXPECT_EQ(s.accel_bias_mps2, (msg::Vec3{0.4, 0.5, 0.6}));
  ASSERT_TRUE(truth.at(1000, s));
  EXPECT_EQ(s.q_world_base, (msg::Quat{1, 0, 0, 0}));
  EXPECT_TRUE(truth.at(2000, s));
  EXPECT_FALSE(truth.at(999, s));
  EXPECT_FALSE(truth.at(2001, s));
  EXPECT_FALSE(GroundTruth({}).at(0, s));
}

TEST(GroundTruth, AQuaternionThatIsNoneIsRefused) {
  std::vector<GroundTruthSample> samples;
  std::string why;
  EXPECT_FALSE(parse_ground_truth_csv(truth_line(1, "0,0,0,0"), "gt.csv", samples, why));
  EXPECT_EQ(why, "gt.csv:1: columns 5 to 8 are not a unit quaternion");
  EXPECT_FALSE(parse_ground_truth_csv("1,2,3,4,5,6,7,8\n", "gt.csv", samples, why));
  EXPECT_EQ(why, "gt.csv:1: 8 columns; at least 17 are needed");
}

}  // namespace
}  // namespace sinew::dataset::dataset_files_test
