// The keys of a device, a bus and a joint in a robot file, and the texts for other keys and values.
#include "drivers/device_keys.hpp"

#include <gmock/gmock.h>

#include "drivers/board/driver_list.hpp"
#include "wire/icm42600.hpp"
#include "wire/mpu6050.hpp"
#include "wire/qmc5883l.hpp"

namespace sinew::drivers::device_keys_test {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

using Keys = std::map<std::string, rt::ParamValue>;
const std::string kI2c = "/dev/i2c-1", kSpi = "/dev/spidev0.0", kSerial = "/dev/ttyS1";

/// Line 1 is the table's, the keys' are 2, 3, ... in the order of the alphabet.
DeviceSpec table(const std::string& name, const std::string& driver, const Keys& keys) {
  DeviceSpec spec;
  spec.name = name, spec.driver = driver, spec.line = 1;
  int line = 1;
  for (const auto& [key, value] : keys) spec.keys[key] = {value, ++line};
  return spec;
}

std::vector<std::string> texts(const DeviceSpecs& specs) {
  std::vector<std::string> out;
  for (const auto& p : check_devices(specs, all_drivers())) out.push_back(rt::to_string(p, "r.toml"));
  return out;
}

std::vector<std::string> of_device(const std::string& driver, const Keys& keys) {
  DeviceSpecs specs;
  specs.devices.push_back(table("d", driver, keys));
  return texts(specs);
}

std::vector<std::string> of_bus(const std::string& driver, const Keys& keys) {
  DeviceSpecs specs;
  specs.buses.push_back(table("can0", driver, keys));
  return texts(specs);
}

/// A joint that is right, but for `more`.
std::vector<std::string> of_joint(const std::string& driver, const Keys& more, const Keys& bus = {}) {
  DeviceSpecs specs;
  Keys on = bus;
  on.emplace("address", std::string("can0"));
  specs.buses.push_back(table("can0", "socketcan", on));
  specs.devices.push_back(table("head", "can_servos", {}));
  Keys keys = more;
  keys.emplace("bus", std::string("can0"));
  keys.emplace("id", std::int64_t{1});
  if (driver == "cia402") keys.emplace("counts_per_turn", 65536.0);
  if (driver == "mit") keys.emplace("motor", std::string("ak80_9"));
  if (driver == "dronecan") keys.emplace("actuator_id", std::int64_t{0});
  DeviceSpec joint = table("pan", driver, keys);
  joint.line = 1;
  specs.devices.back().joints.push_back(joint);
  return texts(specs);
}

TEST(DeviceKeys, ReadingDeclaresARowWithTheDefaultThatWasThere) {
  const DeviceSpec spec = table("imu", "x", {});
  std::vector<rt::Problem> problems;
  DeviceKeys keys(spec, "device.imu", problems);
  double rate_hz = 100;
  int range = 8;
  hal::Duration wait = std::chrono::milliseconds(250);
  std::string path;
  EXPECT_FALSE(keys.read("rate_hz", rate_hz, 1, 1e6, {.unit = "Hz", .doc = "how often"}));
  EXPECT_FALSE(keys.read_one_of("range", range, {2, 8}, {.hex = true}));
  EXPECT_FALSE(keys.read_ms("wait_ms", wait, 1, 500, {.otherwise = "as it is"}));
  EXPECT_FALSE(keys.read("path", path, "a path", {.required = true}));
  ASSERT_EQ(keys.rows().size(), 4u);
  const KeyRow& rate = keys.rows()[0];
  EXPECT_EQ(rate.key + " " + rate.type + " " + rate.unit + " " + rate.otherwise + " " + rate.allowed + " " + rate.doc,
            "rate_hz number Hz 100 1 to 1000000 how often");
  EXPECT_EQ(keys.rows()[1].allowed, "0x2, 0x8");
  EXPECT_EQ(keys.rows()[1].otherwise, "0x8");
  EXPECT_EQ(keys.rows()[2].unit, "ms");
  EXPECT_EQ(keys.rows()[2].otherwise, "as it is");
  EXPECT_TRUE(keys.rows()[3].required);
  ASSERT_EQ(problems.size(), 1u);
  EXPECT_EQ(rt::to_string(problems[0], "r.toml"), "r.toml:1: device.imu.path: missing: a path; it is required");
}

TEST(DeviceKeys, AProblemIsToldOnceAKeyAndWithTheDefaultWhereThereIsNone) {
  const DeviceSpec spec = table("imu", "x", {{"a", 5.0}});
  std::vector<rt::Problem> problems;
  DeviceKeys keys(spec, "d", problems);
  double a = 1, b = 50;
  keys.read("a", a, 0, 2, {});
  keys.read("b", b, 0, 100, {});
  keys.problem("a", "something else");
  keys.problem("b", "at least 60");
  EXPECT_EQ(a, 1) << "the default stays";
  ASSERT_EQ(problems.size(), 2u);
  EXPECT_EQ(rt::to_string(problems[0], "r.toml"), "r.toml:2: d.a: 5: a number from 0 to 2");
  EXPECT_EQ(rt::to_string(problems[1], "r.toml"), "r.toml:1: d.b: default 50: at least 60");
}

TEST(DeviceKeys, WhatBelongsToNoRowIsUnknownButForAFamily) {
  const auto said = of_device("v4l2", {{"path", std::string("/dev/video0")},
                                       {"control_gain", std::int64_t{3}},
                                       {"control_", 1.0},
                                       {"control_gamma", std::string("x")},
                                       {"exposure", 1.0},
                                       {"heigth", 1.0}});
  EXPECT_THAT(said, ElementsAre("r.toml:2: device.d.control_: 1: a number from -1e+12 to 1e+12",
                                "r.toml:4: device.d.control_gamma: \"x\": a number from -1e+12 to 1e+12",
                                "r.toml:5: device.d.exposure: 1: one of buffers, control_NAME, format, height, memory, "
                                "path, rate_hz, root, width",
                                "r.toml:6: device.d.heigth: 1: one of buffers, control_NAME, format, height, memory, "
                                "path, rate_hz, root, width; did you mean height?"));
}

TEST(DeviceKeys, AnImuThatIsPolledHasARate) {
  EXPECT_THAT(of_device("iio", {{"name", std::string("mpu6050")}, {"buffered", false}}),
              ElementsAre(HasSubstr("device.d.rate_hz: default 0: a number above 0, at most 32000; required with "
                                    "buffered = false")));
  EXPECT_THAT(of_device("iio", {{"name", std::string("mpu6050")}, {"buffered", false}, {"rate_hz", 200.0}}), IsEmpty());
}

TEST(DriverKeys, RangesAreThoseThatTheChipsHave) {
  const Keys base = {{"path", kI2c}};
  const auto is_fine = [&](const std::string& driver, const std::string& key, int value) {
    Keys keys = base;
    keys[key] = std::int64_t{value};
    return of_device(driver, keys).empty();
  };
  for (int v = 0; v <= 8100; ++v) {
    wire::mpu6050::Setup mpu;
    mpu.rate_hz = v;
    ASSERT_EQ(is_fine("mpu6050", "rate_hz", v), setup_writes(mpu, wire::mpu6050::Chip::mpu6050).has_value()) << v;
    wire::icm42600::Setup icm;
    icm.rate_hz = v;
    ASSERT_EQ(is_fine("icm42600", "rate_hz", v), setup_writes(icm).has_value()) << v;
    if (v > 2100) continue;
    wire::mpu6050::Setup fast;
    fast.gyro_dps = v;
    ASSERT_EQ(is_fine("mpu6050", "gyro_dps", v), setup_writes(fast, wire::mpu6050::Chip::mpu6050).has_value()) << v;
    wire::icm42600::Setup quick;
    quick.gyro_dps = v;
    ASSERT_EQ(is_fine("icm42600", "gyro_dps", v), setup_writes(quick).has_value()) << v;
    if (v > 250) continue;
    wire::mpu6050::Setup strong;
    strong.accel_g = v;
    ASSERT_EQ(is_fine("mpu6050", "accel_g", v), setup_writes(strong, wire::mpu6050::Chip::mpu6050).has_value()) << v;
    wire::mpu6050::Setup smooth;
    smooth.filter = v;
    ASSERT_EQ(is_fine("mpu6050", "filter", v), setup_writes(smooth, wire::mpu6050::Chip::mpu6050).has_value()) << v;
    wire::icm42600::Setup firm;
    firm.accel_g = v;
    ASSERT_EQ(is_fine("icm42600", "accel_g", v), setup_writes(firm).has_value()) << v;
    wire::qmc5883l::Setup mag;
    mag.rate_hz = v;
    ASSERT_EQ(is_fine("qmc5883l", "rate_hz", v), setup_writes(mag).has_value()) << v;
    mag = {};
    mag.range_gauss = v;
    ASSERT_EQ(is_fine("qmc5883l", "range_gauss", v), setup_writes(mag).has_value()) << v;
    ASSERT_EQ(is_fine("bmp280", "address", v), v == 0x76 || v == 0x77);
    ASSERT_EQ(is_fine("mpu6050", "address", v), v == 0x68 || v == 0x69);
  }
  EXPECT_THAT(of_device("mpu6050", {{"accel_g", std::int64_t{5}}, {"gyro_dps", std::int64_t{300}}, {"path", kI2c}}),
              ElementsAre("r.toml:2: device.d.accel_g: 5: one of 2, 4, 8, 16",
                          "r.toml:3: device.d.gyro_dps: 300: one of 250, 500, 1000, 2000"));
  EXPECT_THAT(of_device("mpu6050", {{"address", std::int64_t{0x70}}, {"path", kI2c}}),
              ElementsAre("r.toml:2: device.d.address: 0x70: one of 0x68, 0x69"));
}

TEST(DriverKeys, APlaceIsOnOneKindOfBus) {
  EXPECT_THAT(of_device("bmp280", {{"address", std::int64_t{0x76}}, {"path", kSpi}}),
              ElementsAre("r.toml:2: device.d.address: 0x76: none on SPI: `path` has its chip select"));
  EXPECT_THAT(of_device("bmp280", {{"path", kI2c}, {"spi_hz", std::int64_t{1'000'000}}, {"spi_mode", std::int64_t{3}}}),
              ElementsAre("r.toml:3: device.d.spi_hz: 1000000: none on I2C: `path` is no /dev/spidev",
                          "r.toml:4: device.d.spi_mode: 3: none on I2C: `path` is no /dev/spidev"));
  EXPECT_THAT(of_device("qmc5883l", {{"path", kSpi}}),
              ElementsAre("r.toml:2: device.d.path: \"/dev/spidev0.0\": the path of the chip's bus, \"/dev/i2c-1\""));
  EXPECT_THAT(of_device("bmp280", {{"path", std::string("i2c-1")}}),
              ElementsAre(HasSubstr("device.d.path: \"i2c-1\"")));
  EXPECT_THAT(of_device("gnss", {{"path", std::string("ttyS1")}}),
              ElementsAre("r.toml:2: device.d.path: \"ttyS1\": the path of a serial line, e.g. \"/dev/ttyS1\""));
}

TEST(DriverKeys, SerialLinesRunAtRatesThatTheirDevicesHave) {
  const auto at = [](const char* driver, std::int64_t rate) {
    return of_device(driver, {{"bit_rate", rate}, {"path", kSerial}});
  };
  EXPECT_THAT(at("gnss", 38400), IsEmpty());
  EXPECT_THAT(at("gnss", 38401), ElementsAre(HasSubstr("bit_rate: 38401: one of 4800, 9600")));
  EXPECT_THAT(at("sbus", 115200), ElementsAre("r.toml:2: device.d.bit_rate: 115200: one of 100000, 200000"));
  EXPECT_THAT(at("crsf", 416666), IsEmpty());
  EXPECT_THAT(at("crsf", 9600), ElementsAre("r.toml:2: device.d.bit_rate: 9600: an integer from 115200 to 4000000"));
  EXPECT_THAT(at("tfmini", 4800), ElementsAre("r.toml:2: device.d.bit_rate: 4800: an integer from 9600 to 921600"));
}

TEST(DriverKeys, ARadioHasAGroupOrPeers) {
  const auto one = [](const char* key, const rt::ParamValue& value) { return of_device("udp", {{key, value}}); };
  EXPECT_THAT(of_device("udp", {}), IsEmpty());
  EXPECT_THAT(one("group", std::string("224.0.0.251:5353")), IsEmpty());
  for (const char* bad : {"10.0.0.1:4580", "239.72.1.1", "239.72.1.1:0", "everyone"})
    EXPECT_THAT(one("group", std::string(bad)), ElementsAre("r.toml:2: device.d.group: \"" + std::string(bad) +
                                                            "\": a multicast address and a port, \"239.72.1.1:4580\""));
  EXPECT_THAT(one("peers", std::string("10.0.0.2:4580,10.0.0.3:4581 , 10.0.0.4:1")), IsEmpty());
  for (const char* bad : {"robot2:4580", "239.72.1.1:4580", "10.0.0.2", "10.0.0.2:1,,10.0.0.3:1", ","})
    EXPECT_THAT(one("peers", std::string(bad)), ElementsAre(HasSubstr("addresses and ports with commas")));
  EXPECT_THAT(one("ttl", std::int64_t{0}), ElementsAre(HasSubstr("device.d.ttl: 0: an integer from 1 to 255")));
  EXPECT_THAT(one("port", std::int64_t{4580}),
              ElementsAre(HasSubstr("device.d.port: 4580: no such key without peers")));
  EXPECT_THAT(of_device("udp", {{"interface", std::string("wlan0")}, {"peers", std::string("10.0.0.2:4580")}}),
              ElementsAre(HasSubstr("device.d.interface: \"wlan0\": no such key beside peers")));
}

TEST(DriverKeys, TwoRadiosDoNotHaveOneGroupOrOnePort) {
  DeviceSpecs specs;
  specs.devices = {table("a", "udp", {}), table("b", "udp", {{"group", std::string("239.72.1.1:4580")}})};
  EXPECT_THAT(texts(specs), ElementsAre(HasSubstr("device.b.group: \"radio 239.72.1.1:4580\": one that no other has")));
  const std::string peer = "10.0.0.2:4580";
  specs.devices = {table("a", "udp", {{"peers", peer}}),
                   table("b", "udp", {{"peers", peer}, {"port", std::int64_t{4580}}})};
  EXPECT_THAT(texts(specs), ElementsAre(HasSubstr("device.b.port: \"UDP port 4580\": one that no other has")));
  specs.devices[1] = table("b", "udp", {{"peers", peer}, {"port", std::int64_t{4581}}});
  EXPECT_THAT(texts(specs), IsEmpty());
}

TEST(BusKeys, AddressIsWrittenAsItsTransportWantsIt) {
  const auto at = [](const char* driver, const rt::ParamValue& address) {
    return of_bus(driver, {{"address", address}});
  };
  for (const char* good : {"can0", "vcan0", "slcan_left"}) EXPECT_THAT(at("socketcan", std::string(good)), IsEmpty());
  for (const char* bad : {"can0:1", "host:1/can0", "a name of 16 ch.", "sixteencharacter", ".."})
    EXPECT_THAT(at("socketcan", std::string(bad)), ElementsAre(HasSubstr("the name of an interface, e.g. \"can0\"")));
  EXPECT_THAT(at("socketcan", std::int64_t{0}), ElementsAre(HasSubstr("r.toml:2: bus.can0.address: 0: the name of")));
  for (const char* good : {"7", "239.65.82.7", "7:eth0", "239.65.82.255:lo"})
    EXPECT_THAT(at("udp", std::string(good)), IsEmpty()) << good;
  EXPECT_THAT(at("udp", std::int64_t{255}), IsEmpty());
  for (const char* bad : {"can0", "256", "239.65.82.", "239.65.83.1", "7:", "-1", "localhost:29536/can0"})
    EXPECT_THAT(at("udp", std::string(bad)),
                ElementsAre("r.toml:2: bus.can0.address: \"" + std::string(bad) +
                            "\": 0 to 255 or \"239.65.82.N\"; as a text with \":INTERFACE\" where that is not lo"));
  EXPECT_THAT(at("udp", std::int64_t{256}), ElementsAre(HasSubstr("bus.can0.address: 256: 0 to 255")));
  for (const char* good : {"localhost:29536/can0", "[::1]:29536/can0", "192.168.0.2:1/vcan3"})
    EXPECT_THAT(at("socketcand", std::string(good)), IsEmpty()) << good;
  for (const char* bad : {"can0", "localhost/can0", "localhost:29536", ":29536/can0", "localhost:0/can0",
                          "localhost:70000/can0", "localhost:29536/", "localhost:x/can0"})
    EXPECT_THAT(at("socketcand", std::string(bad)), ElementsAre(HasSubstr("\"HOST:PORT/BUS\""))) << bad;
}

TEST(BusKeys, BitRatesAreThoseOfControllers) {
  EXPECT_THAT(of_bus("socketcan", {{"address", std::string("can0")}, {"bit_rate", std::int64_t{123456}}}),
              ElementsAre("r.toml:3: bus.can0.bit_rate: 123456: one of 10000, 20000, 33333, 50000, 83333, 100000, "
                          "125000, 250000, 500000, 800000, 1000000"));
  EXPECT_THAT(of_bus("socketcan", {{"address", std::string("can0")}, {"data_bit_rate", std::int64_t{3}}}),
              ElementsAre("r.toml:3: bus.can0.data_bit_rate: 3: one of 0, 500000, 1000000, 2000000, 4000000, 5000000, "
                          "8000000"));
}

TEST(BusKeys, OfAnUnknownDriverNothingElseIsSaid) {
  EXPECT_THAT(
      of_bus("usb", {{"address", std::string("can0")}, {"colour", 1.0}}),
      ElementsAre("r.toml:1: bus.can0.driver: \"usb\": one of \"socketcan\", \"udp\", \"socketcand\", \"serial\""));
  EXPECT_THAT(of_joint("servo", {{"colour", 1.0}}),
              ElementsAre("r.toml:1: device.head.joint.pan.driver: \"servo\": one of \"cia402\", \"mit\", "
                          "\"cybergear\", \"dronecan\", \"dynamixel\", \"feetech\""));
}

TEST(JointKeys, ErrorsGoByTheKeysOfTheFileAndHaveTheRange) {
  EXPECT_THAT(of_joint("mit", {}),
              ElementsAre("r.toml:1: device.head.joint.pan.kp: missing: a number above 0, at most 500; required for "
                          "mode position",
                          "r.toml:1: device.head.joint.pan.kd: missing: a number above 0, at most 5; required for mode "
                          "position and velocity"));
  EXPECT_THAT(of_joint("mit", {{"gear_ratio", 2.0}, {"kd", 1.0}, {"kp", 2001.0}}),
              ElementsAre(HasSubstr("joint.pan.kp: 2001: a number above 0, at most 2000; required for mode position")));
  EXPECT_THAT(of_joint("cia402", {{"id", std::int64_t{0}}}),
              ElementsAre("r.toml:4: device.head.joint.pan.id: 0: an integer from 1 to 127"));
  EXPECT_THAT(of_joint("cia402", {{"id", std::int64_t{126}}}),
              ElementsAre("r.toml:4: device.head.joint.pan.id: 126: another number than the bus's master_node"));
  EXPECT_THAT(of_joint("cia402", {{"max_rad", -1.0}, {"min_rad", 1.0}}),
              ElementsAre("r.toml:5: device.head.joint.pan.max_rad: -1: a number above min_rad, 1"));
  EXPECT_THAT(of_joint("cia402", {{"homing_method", std::int64_t{99}}}),
              ElementsAre("r.toml:4: device.head.joint.pan.homing_method: 99: 0 (none), 1 to 14, 17 to 30, 33 to 35, "
                          "37, or -128 to -1 (the maker's own)"));
  EXPECT_THAT(of_joint("cia402", {{"counts_per_turn", std::int64_t{0}}}),
              ElementsAre("r.toml:3: device.head.joint.pan.counts_per_turn: 0: a number from 1 to 1000000000"));
  EXPECT_THAT(of_joint("cia402", {{"on_stop", std::string("damp")}}),
              ElementsAre("r.toml:5: device.head.joint.pan.on_stop: \"damp\": one of \"torque_off\", \"quick_stop\", "
                          "\"hold\""));
  EXPECT_THAT(of_joint("cia402", {{"on_stop", std::string("quickstop")}}),
              ElementsAre(HasSubstr("\"hold\"; did you mean quick_stop?")));
  EXPECT_THAT(of_joint("dronecan", {}),
              ElementsAre("r.toml:1: device.head.joint.pan.on_stop: default \"torque_off\": \"hold\"; an actuator in "
                          "mode position has no other"));
  EXPECT_THAT(of_joint("dronecan", {{"id", std::int64_t{10}}, {"on_stop", std::string("hold")}}),
              ElementsAre("r.toml:4: device.head.joint.pan.id: 10: another number than the bus's dronecan_node"));
}

TEST(JointKeys, ADeviceTimeOutLeavesRoomForTheHeartbeatThatFeedsIt) {
  EXPECT_THAT(of_joint("cia402", {{"device_timeout_ms", std::int64_t{1}}}),
              ElementsAre("r.toml:4: device.head.joint.pan.device_timeout_ms: 1: 0 (as the drive is set) or at least "
                          "30, as our signs of life come every 10 ms (the bus's master_heartbeat_ms)"));
  EXPECT_THAT(of_joint("cia402", {{"device_timeout_ms", std::int64_t{30}}}), IsEmpty());
  EXPECT_THAT(of_joint("cia402", {{"device_timeout_ms", std::int64_t{30}}}, {{"tick_hz", std::int64_t{50}}}),
              ElementsAre(HasSubstr("device_timeout_ms: 30: 0 (as the drive is set) or at least 60, as our signs of "
                                    "life come every 20 ms (the bus's tick_hz)")));
  EXPECT_THAT(of_joint("cybergear", {{"device_timeout_ms", std::int64_t{5}}, {"kd", 1.0}, {"kp", 10.0}}),
              ElementsAre(HasSubstr("device_timeout_ms: 5: 0 (as the drive is set) or at least 6, as our signs of life "
                                    "come every 2 ms (the bus's tick_hz)")));
}

TEST(JointKeys, EachProtocolHasItsOwn) {
  EXPECT_THAT(of_joint("cia402", {{"kp", 5.0}}),
              ElementsAre(HasSubstr("joint.pan.kp: 5: one of bus, counts_per_turn")));
  EXPECT_THAT(of_joint("mit", {{"counts_per_turn", 5.0}, {"kd", 1.0}, {"kp", 5.0}}),
              ElementsAre(HasSubstr("joint.pan.counts_per_turn: 5: one of")));
  EXPECT_THAT(of_joint("mit", {{"device_timeout_ms", 50.0}, {"kd", 1.0}, {"kp", 5.0}}),
              ElementsAre(HasSubstr("joint.pan.device_timeout_ms: 50: one of")));
  EXPECT_THAT(of_joint("mit", {{"id", std::int64_t{200}}, {"kd", 1.0}, {"kp", 5.0}}), IsEmpty());
  EXPECT_THAT(of_joint("mit", {{"id", std::int64_t{16}}, {"kd", 1.0}, {"kp", 5.0}, {"motor", std::string("dm4310")}}),
              ElementsAre(HasSubstr("joint.pan.id: 16: an integer from 1 to 15, for this motor")));
}

TEST(JointKeys, AMotorOfOnesOwnNeedsAllItsRanges) {
  const Keys gains = {{"kd", 1.0}, {"kp", 5.0}, {"motor", std::string("custom")}};
  const auto said = of_joint("mit", gains);
  EXPECT_EQ(said.size(), 5u);
  EXPECT_THAT(said, Contains("r.toml:1: device.head.joint.pan.range_effort_nm: missing: a number from 0.001 to 10000; "
                             "required with motor = \"custom\""));
  Keys all = gains;
  for (const char* key : {"range_position_rad", "range_velocity_radps", "range_effort_nm", "range_kp", "range_kd"})
    all[key] = 100.0;
  EXPECT_THAT(of_joint("mit", all), IsEmpty());
}

TEST(JointKeys, DeratingIsWholeOrNotThere) {
  EXPECT_THAT(of_joint("cia402", {{"derate_start_c", 60.0}, {"max_effort_nm", 2.0}}),
              ElementsAre(HasSubstr("joint.pan.derate_end_c: missing: a number above derate_start_c, 60")));
  EXPECT_THAT(of_joint("cia402", {{"derate_end_c", 80.0}, {"derate_start_c", 60.0}}),
              ElementsAre(HasSubstr("joint.pan.max_effort_nm: missing: a number above 0; required with derate_start_c "
                                    "and derate_end_c")));
  EXPECT_THAT(of_joint("cia402", {{"derate_end_c", 80.0}, {"derate_start_c", 60.0}, {"max_effort_nm", 2.0}}),
              IsEmpty());
}

TEST(JointKeys, WhatIsWrongWithTheBusIsToldOnceAtTheBus) {
  DeviceSpecs specs;
  specs.buses.push_back(table("can0", "socketcan", {{"address", std::string("can0")}, {"tick_hz", std::int64_t{300}}}));
  specs.devices.push_back(table("head", "can_servos", {}));
  for (const std::int64_t id : {1, 2})
    specs.devices.back().joints.push_back(
        table("j" + std::to_string(id), "cia402",
              {{"bus", std::string("can0")}, {"counts_per_turn", std::int64_t{4096}}, {"id", id}}));
  EXPECT_THAT(texts(specs), ElementsAre(HasSubstr("r.toml:3: bus.can0.tick_hz: 300: with cia402 on it a rate whose "
                                                  "period 60C2h holds")));
}

TEST(JointKeys, ABusIsThereOrNamed) {
  EXPECT_THAT(of_joint("cia402", {{"bus", std::string("can9")}}),
              ElementsAre("r.toml:2: device.head.joint.pan.bus: \"can9\": the name of a [bus.NAME]: can0"));
  DeviceSpecs specs;
  specs.devices.push_back(table("head", "can_servos", {}));
  specs.devices.back().joints.push_back(
      table("pan", "cia402",
            {{"bus", std::string("can0")}, {"counts_per_turn", std::int64_t{4096}}, {"id", std::int64_t{1}}}));
  EXPECT_THAT(texts(specs),
              ElementsAre("r.toml:2: device.head.joint.pan.bus: \"can0\": the name of a [bus.NAME]: there is none"));
  specs.devices = {table("joints", "joints_of", {{"group", std::string("head")}})};
  EXPECT_THAT(texts(specs), ElementsAre("r.toml:2: device.joints.group: \"head\": the name of a device with can_servos "
                                        "or serial_servos: there is none"));
}

}  // namespace
}  // namespace sinew::drivers::device_keys_test
