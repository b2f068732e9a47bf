#include "drivers/board/device_board.hpp"

#include <gmock/gmock.h>

#include "../no_connectors.hpp"
#include "drivers/board/driver_list.hpp"
#include "drivers/calibrated_imu.hpp"
#include "hal/platform.hpp"

namespace sinew::drivers::device_board_test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// An IMU that always has the same sample.
class FixedImu final : public hal::Imu, public hal::SelfReport {
 public:
  std::string trouble() const override { return wrong; }
  static inline std::string wrong;
  explicit FixedImu(const msg::ImuSample& sample) : sample_(sample) {}
  hal::Result<bool> read(msg::ImuSample& out) noexcept override {
    out = sample_;
    return true;
  }
  hal::Time ready_at() const noexcept override { return {}; }
  void set_wake(hal::Wake*) noexcept override {}

 private:
  msg::ImuSample sample_;
};

int opened = 0;

DeviceOpener read_fixed(DeviceKeys& keys, const DeviceSpecs&) {
  double rate_hz = 100;
  keys.read("rate_hz", rate_hz, 1, 1000, {});
  return [](DeviceContext&, std::string&) -> hal::Result<OpenedDevice> {
    ++opened;
    const auto imu = std::make_shared<FixedImu>(msg::ImuSample{{5}, {1, 2, 3}, {0, 0, 9.81}});
    OpenedDevice device;
    device.owner = imu;
    device.report = imu.get();
    device.sensor(hal::SensorKind::imu) = imu.get();
    return device;
  };
}

DeviceOpener read_absent(DeviceKeys& keys, const DeviceSpecs&) {
  std::string path;
  keys.read("path", path, "the path of a device", {.required = true});
  return [](DeviceContext& context, std::string& why) -> hal::Result<OpenedDevice> {
    auto bus = context.connectors.i2c("/dev/nothing", why);
    if (!bus) return bus.error();
    return OpenedDevice{};
  };
}

constexpr DriverKind kDrivers[] = {{"fixed", "imu", read_fixed}, {"absent", "nothing", read_absent}};

DeviceSpec device(const std::string& name, const std::string& driver, int line) {
  DeviceSpec spec;
  spec.name = name, spec.driver = driver, spec.line = line;
  return spec;
}

std::vector<std::string> texts(const DeviceSpecs& specs) {
  std::vector<std::string> out;
  for (const auto& p : check_devices(specs, kDrivers)) out.push_back(rt::to_string(p, "x.toml"));
  return out;
}

TEST(DeviceBoard, EveryWrongKeyIsNamedInOneRun) {
  DeviceSpecs specs;
  specs.devices.push_back(device("imu", "fixed", 3));
  specs.devices.back().keys["rate_hz"] = {rt::ParamValue{5000.0}, 4};
  specs.devices.back().keys["colour"] = {rt::ParamValue{std::string("red")}, 5};
  specs.devices.push_back(device("other", "absent", 7));
  specs.devices.push_back(device("odd", "magic", 9));
  specs.devices.push_back(device("new", "fixd", 11));
  EXPECT_THAT(texts(specs), ElementsAre("x.toml:4: device.imu.rate_hz: 5000: a number from 1 to 1000",
                                        "x.toml:5: device.imu.colour: \"red\": one of rate_hz",
                                        "x.toml:7: device.other.path: missing: the path of a device; it is required",
                                        "x.toml:9: device.odd.driver: \"magic\": one of \"fixed\", \"absent\"",
                                        "x.toml:11: device.new.driver: \"fixd\": one of \"fixed\", \"absent\"; "
                                        "did you mean fixed?"));
}

TEST(DeviceBoard, OpensADeviceOnceAndOnlyWhenAskedFor) {
  opened = 0;
  DeviceSpecs specs;
  specs.devices = {device("imu", "fixed", 0), device("spare", "fixed", 0)};
  ASSERT_THAT(texts(specs), IsEmpty());
  test::NoConnectors connectors;
  DeviceBoard board(specs, kDrivers, connectors, hal::system_os());
  EXPECT_EQ(opened, 0);
  const auto first = board.sensor<msg::ImuSample>("imu"), again = board.sensor<msg::ImuSample>("imu");
  ASSERT_TRUE(first);
  EXPECT_EQ(*first, *again);
  EXPECT_EQ(opened, 1);
}

TEST(DeviceBoard, SaysWhatIsWrongWithWhatIsOpenAndOnlyAsLongAsItIs) {
  DeviceSpecs specs;
  specs.devices = {device("imu", "fixed", 0), device("spare", "fixed", 0)};
  test::NoConnectors connectors;
  DeviceBoard board(specs, kDrivers, connectors, hal::system_os());
  ASSERT_TRUE(board.sensor<msg::ImuSample>("imu"));
  EXPECT_THAT(board.complaints(), IsEmpty());
  FixedImu::wrong = "imu: /dev/i2c-1: repeats itself";
  EXPECT_THAT(board.complaints(), ElementsAre("imu: /dev/i2c-1: repeats itself"));
  FixedImu::wrong.clear();
  EXPECT_THAT(board.complaints(), IsEmpty());
}

TEST(DeviceBoard, SaysInWordsWhatItCannotGive) {
  DeviceSpecs specs;
  specs.devices = {device("imu", "fixed", 0), device("range", "absent", 0)};
  test::NoConnectors connectors;
  DeviceBoard board(specs, kDrivers, connectors, hal::system_os());
  EXPECT_EQ(board.sensor<msg::BaroSample>("baro").error().code, hal::Errc::not_found);
  EXPECT_EQ(board.problem(), "device 'baro': the robot file has no [device.baro]; it has: imu, range");
  EXPECT_EQ(board.sensor<msg::BaroSample>("imu").error().code, hal::Errc::not_found);
  EXPECT_THAT(board.problem(), HasSubstr("device 'imu' is no barometer"));
  EXPECT_EQ(board.camera("imu").error().code, hal::Errc::not_found);
  EXPECT_EQ(board.radio("imu").error().code, hal::Errc::not_found);
  EXPECT_EQ(board.actuators("imu").error().code, hal::Errc::not_found);
  EXPECT_EQ(board.sensor<msg::RangeSample>("range").error().code, hal::Errc::not_found);
  EXPECT_EQ(board.sensor<msg::RangeSample>("range").error().code, hal::Errc::not_found) << "told once";
  EXPECT_EQ(board.problem(),
            "device 'baro': the robot file has no [device.baro]; it has: imu, range\n"
            "device 'imu' is no barometer; [device.imu] has the driver of something else\n"
            "device 'imu' is no camera; [device.imu] has the driver of something else\n"
            "device 'imu' is no radio; [device.imu] has the driver of something else\n"
            "device 'imu' is no actuator group; [device.imu] has the driver of something else\n"
            "device 'range' (driver absent): /dev/nothing: no such file");
}

/// A machine that notes how it is asked, and has nothing.
class NotingConnectors final : public test::NoConnectors {
 public:
  hal::Result<std::unique_ptr<hal::Serial>> serial(const hal::SerialSpec& spec, std::string& why) override {
    line = spec;
    return NoConnectors::serial(spec, why);
  }
  hal::Result<std::unique_ptr<hal::Imu>> iio_imu(const hal::IioSpec& spec, std::string& why) override {
    iio = spec;
    return NoConnectors::iio_imu(spec, why);
  }
  hal::SerialSpec line;
  hal::IioSpec iio;
};

// Opens the one device of `spec`, which fails, and answers how the machine was asked.
NotingConnectors asked(const DeviceSpec& spec) {
  NotingConnectors connectors;
  DeviceSpecs specs;
  specs.devices = {spec};
  EXPECT_THAT(check_devices(specs, all_drivers()), IsEmpty());
  DeviceBoard board(specs, all_drivers(), connectors, hal::system_os());
  static_cast<void>(board.open_sensor(hal::SensorKind::rc, spec.name));
  return connectors;
}

TEST(Drivers, SbusIsOpenedAsItsPageSaysAndInvertsOnlyWhenTold) {
  DeviceSpec rc = device("rc", "sbus", 0);
  rc.keys["path"] = {rt::ParamValue{std::string("/dev/ttyS1")}};
  const hal::SerialSpec line = asked(rc).line;
  EXPECT_EQ(line.bit_rate, 100'000u);
  EXPECT_TRUE(line.even_parity && line.two_stop_bits);
  EXPECT_FALSE(line.inverted) << "no kernel can: the documented file must open";
  rc.keys["inverted"] = {rt::ParamValue{true}};
  EXPECT_TRUE(asked(rc).line.inverted);
}

TEST(Drivers, AnImuOfTheKernelIsReadAboveTheLoopsThatWaitForIt) {
  DeviceSpec imu = device("imu", "iio", 0);
  imu.keys["name"] = {rt::ParamValue{std::string("mpu6050")}};
  EXPECT_EQ(asked(imu).iio.fifo_priority, 88);
  imu.keys["priority"] = {rt::ParamValue{std::int64_t{91}}};
  EXPECT_EQ(asked(imu).iio.fifo_priority, 91);
}

TEST(CalibratedImu, TakesBiasThenScaleThenTurnsIntoTheBaseFrame) {
  DeviceSpec spec = device("imu", "fixed", 0);
  spec.keys["gyro_bias_x_radps"] = {rt::ParamValue{0.5}};
  spec.keys["accel_scale_z"] = {rt::ParamValue{1.1}};
  spec.keys["mount_yaw_deg"] = {rt::ParamValue{std::int64_t{90}}};
  std::vector<rt::Problem> problems;
  DeviceKeys keys(spec, "device.imu", problems);
  const ImuCalibration calibration = ImuCalibration::read(keys);
  keys.finish();
  EXPECT_TRUE(problems.empty());
  FixedImu raw({{5}, {1, 2, 3}, {0, 0, 10}});
  CalibratedImu imu(raw, calibration);
  msg::ImuSample sample;
  ASSERT_TRUE(*imu.read(sample));
  EXPECT_EQ(sample.stamp.ns, 5);
  // Chip's x is the base's y, chip's y the base's -x.
  EXPECT_EQ(sample.gyro_radps, (msg::Vec3{-2, 0.5, 3}));
  EXPECT_EQ(sample.accel_mps2, (msg::Vec3{0, 0, 11}));
}

TEST(CalibratedImu, ChipUpsideDownFeelsGravityUpwardInTheBase) {
  DeviceSpec spec = device("imu", "fixed", 0);
  spec.keys["mount_roll_deg"] = {rt::ParamValue{180.0}};
  std::vector<rt::Problem> problems;
  DeviceKeys keys(spec, "device.imu", problems);
  FixedImu raw({{5}, {1, 2, 3}, {0, 0, -9.81}});
  CalibratedImu imu(raw, ImuCalibration::read(keys));
  msg::ImuSample sample;
  ASSERT_TRUE(*imu.read(sample));
  EXPECT_EQ(sample.gyro_radps, (msg::Vec3{1, -2, -3}));
  EXPECT_EQ(sample.accel_mps2, (msg::Vec3{0, 0, 9.81}));
}

}  // namespace
}  // namespace sinew::drivers::device_board_test
