// The MPU-6050 driver on a simulated chip: its samples, and the texts for the user when something is wrong. On a real
// bus where SINEW_I2C says "1:0x68" (bus:address; i2c-stub, too).
#include "drivers/chips/mpu6050.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>

#include "bench_os.hpp"
#include "hal/linux/devices/i2c.hpp"
#include "hal/platform.hpp"
#include "sim_hil/wire/sim_imu_chips.hpp"

namespace sinew::drivers::mpu6050_test {
namespace {

using namespace std::chrono_literals;
using sim_hil::BusFault;
using ::testing::HasSubstr;

msg::ImuSample sample(double k) { return {{}, {0.1 + 0.01 * k, -0.2, 0.3}, {1, -2 + 0.01 * k, 9.81}}; }

class Mpu6050Test : public ::testing::Test {
 protected:
  void make(Mpu6050Config config = {}, std::uint8_t who_am_i = 0x68) {
    chip = std::make_shared<sim_hil::SimMpu6050>(who_am_i);
    bus = std::make_shared<sim_hil::SimI2cBus>();
    bus->attach(0x68, chip);
    driver = std::make_unique<Mpu6050>(os, std::make_unique<I2cRegisters>(bus, 0x68), config);
  }
  hal::Status poll() {
    out.clear();
    return driver->poll(os.now(), out, why);
  }
  test::BenchOs os;
  std::shared_ptr<sim_hil::SimMpu6050> chip;
  std::shared_ptr<sim_hil::SimI2cBus> bus;
  std::unique_ptr<Mpu6050> driver;
  std::vector<msg::ImuSample> out;
  std::string why;
};

TEST_F(Mpu6050Test, EverySampleOfTheFifoComesInOrderAndInSiUnits) {
  make();
  ASSERT_TRUE(driver->set_up(why)) << why;
  for (int i = 0; i < 45; ++i) chip->measure(sample(i)), os.pass(1ms);
  ASSERT_TRUE(poll()) << why;
  ASSERT_EQ(out.size(), 45u) << "three reads of the FIFO";
  for (std::size_t i = 0; i < out.size(); ++i) {
    const msg::ImuSample want = sample(static_cast<double>(i));
    EXPECT_NEAR(out[i].accel_mps2.y, want.accel_mps2.y, 0.0013) << "half a count at 8 g";
    EXPECT_NEAR(out[i].gyro_radps.x, want.gyro_radps.x, 0.0006);
    if (i > 0) {
      EXPECT_EQ(out[i].stamp - out[i - 1].stamp, 1ms);
    }
  }
  EXPECT_LE(out.back().stamp, os.now() - 2800us) << "less the filter's delay";
  EXPECT_GE(out.back().stamp, os.now() - 4ms);
  ASSERT_TRUE(poll());
  EXPECT_TRUE(out.empty());
}

TEST_F(Mpu6050Test, WithoutFifoTheNewestSampleIsTakenOnce) {
  Mpu6050Config config;
  config.chip.fifo = false;
  make(config);
  ASSERT_TRUE(driver->set_up(why)) << why;
  chip->measure(sample(1)), os.pass(1ms), chip->measure(sample(2));
  ASSERT_TRUE(poll()) << why;
  ASSERT_EQ(out.size(), 1u);
  EXPECT_NEAR(out[0].gyro_radps.x, 0.12, 0.0006);
  ASSERT_TRUE(poll());
  EXPECT_TRUE(out.empty()) << "not ready: said by the chip";
}

TEST_F(Mpu6050Test, TheMountTurnsBothVectors) {
  Mpu6050Config config;
  config.mount.yaw_deg = 90;  // the chip's x points to the robot's left
  make(config);
  ASSERT_TRUE(driver->set_up(why)) << why;
  chip->measure({{}, {1, 0, 0}, {0, 2, 9}});
  ASSERT_TRUE(poll());
  ASSERT_EQ(out.size(), 1u);
  EXPECT_NEAR(out[0].gyro_radps.y, 1, 0.001);
  EXPECT_NEAR(out[0].accel_mps2.x, -2, 0.002);
}

TEST_F(Mpu6050Test, NewerChipsAreTakenOnSpiToo) {
  chip = std::make_shared<sim_hil::SimMpu6050>(0x71);
  auto spi = std::make_shared<sim_hil::SimSpiDevice>(chip);
  driver = std::make_unique<Mpu6050>(os, std::make_unique<SpiRegisters>(spi), Mpu6050Config{});
  ASSERT_TRUE(driver->set_up(why)) << why;
  EXPECT_EQ(chip->peek(wire::mpu6050::kUserControl) & wire::mpu6050::kI2cOff, wire::mpu6050::kI2cOff);
  chip->measure(sample(0));
  ASSERT_TRUE(poll()) << why;
  EXPECT_EQ(out.size(), 1u);
}

TEST_F(Mpu6050Test, AFifoThatRanOverIsEmptiedAndCounted) {
  make();
  ASSERT_TRUE(driver->set_up(why)) << why;
  for (int i = 0; i < 200; ++i) chip->measure(sample(i));
  ASSERT_TRUE(poll()) << why;
  EXPECT_TRUE(out.empty()) << "packets may be cut";
  EXPECT_EQ(driver->overflows(), 1u);
  EXPECT_EQ(chip->fifo_size(), 0u);
  chip->measure(sample(7));
  ASSERT_TRUE(poll()) << why;
  ASSERT_EQ(out.size(), 1u);
  EXPECT_NEAR(out[0].gyro_radps.x, 0.17, 0.0006);
}

TEST_F(Mpu6050Test, AfterABurstThatFailedHalfWayNoSampleIsMadeOfTwoHalves) {
  for (const int cut : {2, 6, 11, 17}) {
    make();
    ASSERT_TRUE(driver->set_up(why)) << why;
    for (int i = 0; i < 5; ++i) chip->measure(sample(i)), os.pass(1ms);
    bus->cut_next_after = cut;
    EXPECT_FALSE(poll());
    EXPECT_TRUE(out.empty());
    int got = 0;
    for (int i = 5; i < 15; ++i) {
      chip->measure(sample(i)), os.pass(1ms);
      ASSERT_TRUE(poll()) << why;
      for (const msg::ImuSample& s : out) {
        ++got;
        EXPECT_NEAR(s.gyro_radps.y, -0.2, 0.001) << "cut after " << cut;
        EXPECT_NEAR(s.accel_mps2.z, 9.81, 0.002) << "cut after " << cut;
      }
    }
    EXPECT_EQ(got, 9) << "the poll after the failure emptied the FIFO";
  }
}

TEST_F(Mpu6050Test, AFifoThatStaysOffItsBeatIsEmptied) {
  make();
  ASSERT_TRUE(driver->set_up(why)) << why;
  for (int i = 0; i < 3; ++i) chip->measure(sample(i)), os.pass(1ms);
  std::uint8_t byte = 0;
  const std::uint8_t fifo = wire::mpu6050::kFifoData;
  ASSERT_TRUE(bus->transfer(0x68, {&fifo, 1}, {&byte, 1})) << "somebody else takes a byte";
  for (int i = 3; i < 13; ++i) {
    chip->measure(sample(i)), os.pass(1ms);
    ASSERT_TRUE(poll()) << why;
    for (const msg::ImuSample& s : out) EXPECT_NEAR(s.gyro_radps.y, -0.2, 0.001);
  }
  EXPECT_EQ(out.size(), 1u);
  EXPECT_EQ(driver->overflows(), 1u);
}

// ---- faults, in words

TEST_F(Mpu6050Test, AnAbsentChipIsToldWithItsAddress) {
  make();
  bus->fault = BusFault::no_answer;
  const auto done = driver->set_up(why);
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().code, hal::Errc::not_found);
  EXPECT_EQ(why, "i2c 0x68: nothing answers (wiring, address, power?)");
}

TEST_F(Mpu6050Test, AnotherChipIsToldByItsAnswer) {
  make({}, 0x47);
  EXPECT_FALSE(driver->set_up(why));
  EXPECT_EQ(why, "i2c 0x68: answers who-am-i with 0x47; an MPU-6050 says 0x68, 6500 0x70, 9250 0x71");
}

TEST_F(Mpu6050Test, ASetUpThatTheChipDoesNotHaveIsRefused) {
  Mpu6050Config config;
  config.chip.rate_hz = 300;
  make(config);
  const auto done = driver->set_up(why);
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().code, hal::Errc::bad_argument);
  EXPECT_THAT(why, HasSubstr("rate_hz 1000 / n from 4 to 1000"));
}

TEST_F(Mpu6050Test, ALineHeldHighOrLowIsNoMeasurement) {
  for (const BusFault fault : {BusFault::held_high, BusFault::held_low}) {
    Mpu6050Config config;
    config.chip.fifo = false;
    make(config);
    ASSERT_TRUE(driver->set_up(why)) << why;
    chip->measure(sample(1));
    bus->fault = fault;
    const auto done = poll();
    ASSERT_FALSE(done);
    EXPECT_EQ(done.error().code, hal::Errc::bad_data);
    EXPECT_EQ(why, "i2c 0x68: reads only 0x00 or 0xff (power, pull-ups?)");
    EXPECT_TRUE(out.empty());
  }
  make();
  ASSERT_TRUE(driver->set_up(why)) << why;
  bus->fault = BusFault::held_high;
  EXPECT_FALSE(poll());
  EXPECT_EQ(why, "i2c 0x68: says 65535 bytes are in a FIFO of 1024");
}

TEST_F(Mpu6050Test, AChipThatRepeatsItselfIsStuck) {
  make();
  ASSERT_TRUE(driver->set_up(why)) << why;
  int good = 0;
  hal::Status done;
  for (int i = 0; i < 600 && done; ++i) {
    chip->measure(sample(3)), os.pass(1ms);
    done = poll();
    good += done ? 1 : 0;
  }
  ASSERT_FALSE(done);
  EXPECT_EQ(why, "i2c 0x68: repeats the same numbers");
  EXPECT_EQ(good, 500) << "stuck_after";
}

TEST_F(Mpu6050Test, ErrorsOfTheBusComeWithTheirNumber) {
  make();
  ASSERT_TRUE(driver->set_up(why)) << why;
  bus->fault = BusFault::errors;
  EXPECT_FALSE(poll());
  EXPECT_EQ(why, "i2c 0x68: input/output error (errno 5)");
}

TEST_F(Mpu6050Test, ARegisterThatKeepsNothingIsToldByItsAddress) {
  struct Forgetful : sim_hil::SimChip {
    Forgetful() { poke(wire::mpu6050::kWhoAmI, 0x68); }
    void on_write(std::uint8_t, std::uint8_t) override {}
  };
  bus = std::make_shared<sim_hil::SimI2cBus>();
  bus->attach(0x69, std::make_shared<Forgetful>());
  driver = std::make_unique<Mpu6050>(os, std::make_unique<I2cRegisters>(bus, 0x69), Mpu6050Config{});
  EXPECT_FALSE(driver->set_up(why));
  EXPECT_EQ(why, "i2c 0x69: register 0x6b does not keep what is written (another chip, or a bad line)");
}

// ---- as a device, on its own thread

class Mpu6050Sensor : public Mpu6050Test {
 protected:
  using Sensor = PolledSensor<msg::ImuSample>;
  std::unique_ptr<Sensor> start() {
    chip = std::make_shared<sim_hil::SimMpu6050>();
    bus = std::make_shared<sim_hil::SimI2cBus>();
    bus->attach(0x68, chip);
    PollOptions options;
    options.name = "imu";
    options.retry_first = 2ms;
    options.retry_most = 10ms;
    options.silent_after = 100ms;
    auto& real = hal::system_os();
    auto sensor =
        Sensor::start(real, std::make_unique<Mpu6050>(real, std::make_unique<I2cRegisters>(bus, 0x68), Mpu6050Config{}),
                      options, why);
    return sensor ? std::move(*sensor) : nullptr;
  }
  template <class F>
  bool wait_until(F&& holds) {
    auto& real = hal::system_os();
    const hal::Time deadline = real.now() + 10s;
    while (real.now() < deadline) {
      if (holds()) return true;
      real.sleep_until(real.now() + 1ms);
    }
    return false;
  }
  /// Measures until a sample comes through.
  bool delivers(Sensor& sensor) {
    msg::ImuSample got;
    return wait_until([&] {
      chip->measure(sample(++k_));
      const auto read = sensor.read(got);
      return read && *read;
    });
  }
  double k_ = 0;
};

TEST_F(Mpu6050Sensor, DeliversAndIsSetUpAgainAfterErrors) {
  auto sensor = start();
  ASSERT_TRUE(sensor) << why;
  ASSERT_TRUE(delivers(*sensor));
  bus->fault = BusFault::errors;
  msg::ImuSample got;
  ASSERT_TRUE(wait_until([&] {
    const auto read = sensor->read(got);
    return !read && read.error().code == hal::Errc::closed;
  }));
  EXPECT_EQ(sensor->trouble(), "imu: i2c 0x68: input/output error (errno 5)");
  bus->fault = BusFault::none;
  ASSERT_TRUE(wait_until([&] { return sensor->stats().restarts == 1; }));
  ASSERT_TRUE(delivers(*sensor)) << sensor->trouble();
  EXPECT_TRUE(wait_until([&] { return delivers(*sensor) && sensor->trouble().empty(); })) << sensor->trouble();
  EXPECT_GE(sensor->stats().errors, 3u);
}

TEST_F(Mpu6050Sensor, ASilentChipIsTold) {
  auto sensor = start();
  ASSERT_TRUE(sensor) << why;
  EXPECT_TRUE(wait_until([&] { return sensor->trouble() == "imu: answers, but sends nothing (its clock or power?)"; }))
      << sensor->trouble();
}

TEST_F(Mpu6050Sensor, AChipThatLostItsPowerForAMomentIsSetUpAgain) {
  auto sensor = start();
  ASSERT_TRUE(sensor) << why;
  ASSERT_TRUE(delivers(*sensor));
  {
    const auto held = chip->lock();  // its registers are those of power-on: it answers and sleeps
    chip->poke(wire::mpu6050::kPower1, 0x40);
    chip->poke(wire::mpu6050::kUserControl, 0), chip->poke(wire::mpu6050::kFifoEnable, 0);
  }
  ASSERT_TRUE(wait_until([&] {
    chip->measure(sample(++k_));
    return sensor->stats().restarts == 1;
  })) << sensor->trouble();
  EXPECT_TRUE(wait_until([&] { return delivers(*sensor) && sensor->trouble().empty(); })) << sensor->trouble();
}

TEST_F(Mpu6050Sensor, AStuckChipIsResetAndHeals) {
  auto sensor = start();
  ASSERT_TRUE(sensor) << why;
  EXPECT_TRUE(wait_until([&] {
    chip->measure(sample(0));
    return sensor->stats().restarts > 0;
  }));
  EXPECT_GE(chip->resets(), 2);
  EXPECT_TRUE(delivers(*sensor)) << sensor->trouble();
}

TEST_F(Mpu6050Sensor, AnAbsentChipDoesNotStart) {
  auto& real = hal::system_os();
  bus = std::make_shared<sim_hil::SimI2cBus>();
  auto sensor =
      Sensor::start(real, std::make_unique<Mpu6050>(real, std::make_unique<I2cRegisters>(bus, 0x68), Mpu6050Config{}),
                    {.name = "imu", .cpus = {}}, why);
  ASSERT_FALSE(sensor);
  EXPECT_EQ(why, "imu: i2c 0x68: nothing answers (wiring, address, power?)");
}

/// On a real bus (tests/vm): SINEW_I2C=0:0x68, chip registers filled before, status register 0x3a = 1.
TEST(Mpu6050Kernel, TheRealBusDelivers) {
  const char* where = std::getenv("SINEW_I2C");
  if (!where) GTEST_SKIP() << "SINEW_I2C names no bus: no real kernel to try";
  char* end = nullptr;
  const long bus = std::strtol(where, &end, 10);
  ASSERT_EQ(*end, ':') << "SINEW_I2C is bus:address";
  const long address = std::strtol(end + 1, nullptr, 0);
  std::string why;
  auto opened = hal::open_i2c("/dev/i2c-" + std::to_string(bus), why);
  ASSERT_TRUE(opened) << why;
  Mpu6050Config config;
  config.chip.fifo = false;  // a stub has none, and SMBus cannot read one
  config.stuck_after = {};   // a stub's registers stand still
  auto& os = hal::system_os();
  auto registers = std::make_unique<I2cRegisters>(std::shared_ptr<hal::I2cBus>(std::move(*opened)),
                                                  static_cast<std::uint8_t>(address));
  Mpu6050 driver(os, std::move(registers), config);
  ASSERT_TRUE(driver.set_up(why)) << why;
  std::vector<msg::ImuSample> out;
  const hal::Time deadline = os.now() + 10s;
  while (out.empty() && os.now() < deadline) {
    ASSERT_TRUE(driver.poll(os.now(), out, why)) << why;
    os.sleep_until(os.now() + 1ms);
  }
  ASSERT_FALSE(out.empty()) << "no data ready";
  RecordProperty("accel_x_mps2", std::to_string(out[0].accel_mps2.x));
  if (const char* want = std::getenv("SINEW_I2C_ACCEL_X_COUNTS")) {
    EXPECT_NEAR(out[0].accel_mps2.x, std::atof(want) * 8 * 9.80665 / 32768, 1e-9);
  }
}

}  // namespace
}  // namespace sinew::drivers::mpu6050_test
