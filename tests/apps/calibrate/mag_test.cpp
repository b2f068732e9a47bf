// calibrate mag: from a recording with readings to parameters of the robot file's estimator.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "apps/calibrate/calibration_output.hpp"
#include "apps/calibrate/mag_command.hpp"
#include "apps/command/command.hpp"
#include "apps/module_list.hpp"
#include "control/magnetic_model.hpp"
#include "hal/linux/file.hpp"
#include "math/random.hpp"
#include "msg/cdr.hpp"
#include "msg/ros2msg.hpp"
#include "msg/sensors.hpp"
#include "record/writer.hpp"

namespace sinew::app::mag_test {
namespace {

using math::Quat;
using math::Vec3;
using ::testing::HasSubstr;

constexpr const char* kRobot = R"(robot = { name = "glider", board = "none" }
[[thread]]
name = "control"
period_us = 1000
priority = 10
order = ["filter"]
[module.filter]
type = "control::ErrorStateFilter"
in = { imu = "imu.raw", mag = "mag.raw" }
)";

const Vec3 kHard_t{12e-6, -30e-6, 7e-6};

class MagCommand : public ::testing::Test {
 protected:
  MagCommand() { std::filesystem::create_directory(folder_); }
  ~MagCommand() override { std::filesystem::remove_all(folder_); }

  std::string path(const char* name) const { return (folder_ / name).string(); }

  template <class M>
  void put(record::Writer& writer, std::uint16_t channel, const M& message) {
    std::vector<std::uint8_t> bytes(msg::cdr_size(msg::type_info<M>(), &message));
    msg::cdr_encode(msg::type_info<M>(), &message, bytes);
    const auto at = static_cast<std::uint64_t>(message.stamp.ns);
    ASSERT_TRUE(writer.write(channel, {0, at, at}, std::as_bytes(std::span(bytes))));
  }
  template <class M>
  std::uint16_t channel(record::Writer& writer, const char* topic) {
    const msg::TypeInfo& type = msg::type_info<M>();
    const auto schema = writer.add_schema(msg::ros2_name(type), "ros2msg", msg::ros2msg_schema(type));
    return *writer.add_channel(topic, "cdr", *schema);
  }
  /// A vehicle with hard iron near Zurich that is turned about all axes, or stays level.
  void record_turns(bool level, bool gnss) {
    auto file = hal::create_file(path("turns.mcap"));
    ASSERT_TRUE(file);
    auto opened = record::Writer::open(std::move(*file), {});
    const auto writer = std::move(*opened);
    ASSERT_TRUE(writer->add_metadata({"sinew.run", {{"robot", "glider"}, {"unix_ns", "1790000000000000000"}}}));
    ASSERT_TRUE(writer->attach({0, 0, "robot.toml", "application/toml", kRobot}));
    const std::uint16_t mag = channel<msg::MagSample>(*writer, "mag.raw");
    if (gnss) {
      msg::GnssSample fix;
      fix.latitude_deg = 47.4, fix.longitude_deg = 8.5, fix.altitude_m = 400, fix.fix = msg::GnssFix::full;
      put(*writer, channel<msg::GnssSample>(*writer, "gnss.raw"), fix);
    }
    math::Random random(3, 1);
    for (int i = 0; i < 800; ++i) {
      const double t = i / 800.0, tilt = level ? 0.05 : math::kPi;
      const Quat q = Quat::from_axis_angle({0, 0, 1}, 2 * math::kPi * 9 * t) *
                     Quat::from_axis_angle({1, 0, 0}, tilt * math::sin(2 * math::kPi * 5 * t)) *
                     Quat::from_axis_angle({0, 1, 0}, tilt * math::cos(2 * math::kPi * 2 * t));
      const Vec3 noise{random.normal(0, 2e-7), random.normal(0, 2e-7), random.normal(0, 2e-7)};
      msg::MagSample s;
      s.stamp.ns = 20'000'000 * (i + 1);
      s.field_t = (q.conjugate().rotate(field_) + kHard_t + noise).to<msg::Vec3>();
      put(*writer, mag, s);
    }
    ASSERT_TRUE(writer->finish());
  }
  int run(MagOptions o) {
    o.recording = path("turns.mcap");
    testing::internal::CaptureStdout();
    testing::internal::CaptureStderr();
    const int code = calibrate_mag(o, all_modules());
    said_ = testing::internal::GetCapturedStdout();
    complained_ = testing::internal::GetCapturedStderr();
    return code;
  }
  double written(const char* file, std::string_view name) {
    Calibration all;
    EXPECT_TRUE(read_calibration(path(file), all));
    for (const OverlayParam& p : all.params.params)
      if (p.module == "filter" && p.param == name) return std::get<double>(p.value);
    ADD_FAILURE() << name << " is not written";
    return math::kNan;
  }

  const Vec3 field_ = *control::earth_field_t({47.4, 8.5, 400}, 2026.72);
  std::string said_, complained_;

 private:
  std::filesystem::path folder_ = std::filesystem::path(::testing::TempDir()) / "sinew_mag";
};

TEST_F(MagCommand, WritesWhatTheEstimatorTakesByThePlaceOfTheRecordingsFix) {
  record_turns(false, true);
  ASSERT_EQ(run({.file = path("glider_cal.toml")}), 0) << complained_;
  EXPECT_THAT(said_, HasSubstr("mag.raw: 800 readings; field 48."));
  EXPECT_THAT(said_, HasSubstr("World Magnetic Model at 47.4000 8.5000 of gnss.raw, 2026.7"));
  EXPECT_NEAR(written("glider_cal.toml", "mag_hard_y_t"), kHard_t.y, 1e-7);
  EXPECT_NEAR(written("glider_cal.toml", "mag_soft_xx"), 1, 0.005);
  EXPECT_NEAR(written("glider_cal.toml", "mag_soft_zy"), 0, 0.005);
}

TEST_F(MagCommand, WithoutAPlaceSoftIronKeepsVolumesAndWithOneInNumbersItDoesNot) {
  record_turns(false, false);
  ASSERT_EQ(run({.file = path("a.toml")}), 0) << complained_;
  EXPECT_THAT(said_, HasSubstr("not known there: soft iron keeps volumes"));
  EXPECT_NEAR(written("a.toml", "mag_soft_zz"), 1, 0.005);
  ASSERT_EQ(run({.file = path("b.toml"), .field_ut = 24.0}), 0) << complained_;
  EXPECT_NEAR(written("b.toml", "mag_soft_zz"), 24e-6 / norm(field_), 0.005);
}

TEST_F(MagCommand, WhatIsNotShownIsSaidAndNothingIsWritten) {
  record_turns(true, false);
  EXPECT_EQ(run({.file = path("a.toml")}), kFailed);
  EXPECT_THAT(complained_, testing::AnyOf(HasSubstr("turn the vehicle until the field comes from there"),
                                          HasSubstr("turn the vehicle about more axes")));
  EXPECT_FALSE(std::filesystem::exists(path("a.toml")));
  EXPECT_EQ(run({.topic = "mag2.raw"}), kNotBegun);
  EXPECT_THAT(complained_, HasSubstr("--topic mag2.raw: there is none; it has: mag.raw"));
  EXPECT_EQ(run({.at_deg = {91, 0}}), kNotBegun);
  EXPECT_THAT(complained_, HasSubstr("latitudes from -89.9 to 89.9"));
}

}  // namespace
}  // namespace sinew::app::mag_test
