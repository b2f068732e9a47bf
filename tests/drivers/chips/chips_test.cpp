// ICM-42600, BMP280 and QMC5883L on simulated chips.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "bench_os.hpp"
#include "drivers/chips/bmp280.hpp"
#include "drivers/chips/icm42600.hpp"
#include "drivers/chips/qmc5883l.hpp"
#include "sim_hil/wire/sim_imu_chips.hpp"

namespace sinew::drivers::chips_test {
namespace {

using namespace std::chrono_literals;
using sim_hil::BusFault, sim_hil::SimChip, sim_hil::SimI2cBus;
using ::testing::HasSubstr;

class ChipTest : public ::testing::Test {
 protected:
  std::unique_ptr<Registers> at(std::uint8_t address, std::shared_ptr<SimChip> chip) {
    bus->attach(address, std::move(chip));
    return std::make_unique<I2cRegisters>(bus, address);
  }
  template <class M>
  hal::Status poll(PolledDevice<M>& driver, std::vector<M>& out) {
    out.clear();
    return driver.poll(os.now(), out, why);
  }
  test::BenchOs os;
  std::shared_ptr<SimI2cBus> bus = std::make_shared<SimI2cBus>();
  std::string why;
};

// ---- ICM-42600

class Icm42600Test : public ChipTest {
 protected:
  void make(Icm42600Config config = {}, std::uint8_t who = 0x47) {
    chip = std::make_shared<sim_hil::SimIcm42600>(who);
    driver = std::make_unique<Icm42600>(os, at(0x68, chip), config);
  }
  std::shared_ptr<sim_hil::SimIcm42600> chip;
  std::unique_ptr<Icm42600> driver;
  std::vector<msg::ImuSample> out;
};

msg::ImuSample sample(double k) { return {{}, {0.1 + 0.01 * k, -0.2, 0.3}, {1, -2 + 0.01 * k, 9.81}}; }

TEST_F(Icm42600Test, EverySampleOfTheFifoComesInOrderAndInSiUnits) {
  Icm42600Config config;
  config.chip.accel_g = 4;
  config.chip.gyro_dps = 500;
  make(config);
  ASSERT_TRUE(driver->set_up(why)) << why;
  for (int i = 0; i < 40; ++i) chip->measure(sample(i)), os.pass(1ms);
  ASSERT_TRUE(poll(*driver, out)) << why;
  ASSERT_EQ(out.size(), 40u);
  for (std::size_t i = 0; i < out.size(); ++i) {
    EXPECT_NEAR(out[i].accel_mps2.y, sample(static_cast<double>(i)).accel_mps2.y, 0.0007);
    EXPECT_NEAR(out[i].gyro_radps.x, sample(static_cast<double>(i)).gyro_radps.x, 0.0002);
    if (i > 0) {
      EXPECT_EQ(out[i].stamp - out[i - 1].stamp, 1ms);
    }
  }
  EXPECT_LE(out.back().stamp, os.now());
}

TEST_F(Icm42600Test, WithoutFifoTheNewestSampleIsTakenOnce) {
  Icm42600Config config;
  config.chip.fifo = false;
  make(config);
  ASSERT_TRUE(driver->set_up(why)) << why;
  chip->measure(sample(1));
  ASSERT_TRUE(poll(*driver, out)) << why;
  ASSERT_EQ(out.size(), 1u);
  ASSERT_TRUE(poll(*driver, out));
  EXPECT_TRUE(out.empty());
}

TEST_F(Icm42600Test, AFifoThatRanOverIsEmptiedAndCounted) {
  make();
  ASSERT_TRUE(driver->set_up(why)) << why;
  for (int i = 0; i < 200; ++i) chip->measure(sample(i));
  ASSERT_TRUE(poll(*driver, out)) << why;
  EXPECT_TRUE(out.empty());
  EXPECT_EQ(driver->overflows(), 1u);
  chip->measure(sample(7));
  ASSERT_TRUE(poll(*driver, out)) << why;
  EXPECT_EQ(out.size(), 1u);
}

TEST_F(Icm42600Test, AfterABurstThatFailedHalfWayNoSampleIsMadeOfTwoHalves) {
  for (const int cut : {3, 8, 15, 17}) {
    make();
    ASSERT_TRUE(driver->set_up(why)) << why;
    for (int i = 0; i < 5; ++i) chip->measure(sample(i)), os.pass(1ms);
    bus->cut_next_after = cut;
    EXPECT_FALSE(poll(*driver, out));
    int got = 0;
    for (int i = 5; i < 15; ++i) {
      chip->measure(sample(i)), os.pass(1ms);
      ASSERT_TRUE(poll(*driver, out)) << why;
      for (const msg::ImuSample& s : out) {
        ++got;
        EXPECT_NEAR(s.gyro_radps.y, -0.2, 0.001) << "cut after " << cut;
        EXPECT_NEAR(s.accel_mps2.z, 9.81, 0.01) << "cut after " << cut;
      }
    }
    EXPECT_EQ(got, 9) << "the poll after the failure emptied the FIFO";
  }
}

TEST_F(Icm42600Test, WhatIsWrongIsToldInWords) {
  make({}, 0x68);
  EXPECT_FALSE(driver->set_up(why));
  EXPECT_EQ(why, "i2c 0x68: answers who-am-i with 0x68; an ICM-42605 says 0x42, an ICM-42688-P 0x47");
  Icm42600Config config;
  config.chip.rate_hz = 400;
  make(config);
  EXPECT_FALSE(driver->set_up(why));
  EXPECT_THAT(why, HasSubstr("rate_hz 25, 50, 100, 200, 500, 1000"));
  make();
  ASSERT_TRUE(driver->set_up(why)) << why;
  bus->fault = BusFault::held_high;
  EXPECT_FALSE(poll(*driver, out));
  EXPECT_EQ(why, "i2c 0x68: says 65535 bytes are in a FIFO of 2048");
  bus->fault = BusFault::gone;
  const auto done = poll(*driver, out);
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().code, hal::Errc::closed);
}

TEST_F(Icm42600Test, AChipThatRepeatsItselfIsStuck) {
  make();
  ASSERT_TRUE(driver->set_up(why)) << why;
  hal::Status done;
  int polls = 0;
  for (; polls < 600 && done; ++polls) {
    chip->measure(sample(3)), os.pass(1ms);
    done = poll(*driver, out);
  }
  ASSERT_FALSE(done);
  EXPECT_EQ(why, "i2c 0x68: repeats the same numbers");
  EXPECT_EQ(polls, 501);
}

// ---- BMP280

/// The chip of the datasheet's example; its registers stand still but for the reset.
std::shared_ptr<SimChip> bmp280() {
  struct Bmp : SimChip {
    void on_write(std::uint8_t address, std::uint8_t value) override {
      if (address != wire::bmp280::kReset) poke(address, value);
    }
  };
  auto chip = std::make_shared<Bmp>();
  chip->poke(wire::bmp280::kId, 0x58);
  constexpr int kWords[] = {27504, 26435, -1000, 36477, -10685, 3024, 2855, 140, -7, 15500, -14600, 6000};
  std::uint8_t at = wire::bmp280::kCalibration;
  for (const int word : kWords) {
    chip->poke(at++, static_cast<std::uint8_t>(word));
    chip->poke(at++, static_cast<std::uint8_t>(static_cast<unsigned>(word) >> 8));
  }
  at = wire::bmp280::kPressure;
  for (const int byte : {0x65, 0x5A, 0xC0, 0x7E, 0xED, 0x00}) chip->poke(at++, static_cast<std::uint8_t>(byte));
  return chip;
}

TEST_F(ChipTest, Bmp280MeasuresPressureAndTemperature) {
  Bmp280 driver(os, at(0x76, bmp280()));
  ASSERT_TRUE(driver.set_up(why)) << why;
  std::vector<msg::BaroSample> out;
  ASSERT_TRUE(poll(driver, out)) << why;
  ASSERT_EQ(out.size(), 1u);
  EXPECT_NEAR(out[0].pressure_pa, 100653.27, 0.02);
  EXPECT_NEAR(out[0].temperature_c, 25.08, 0.005);
  EXPECT_EQ(out[0].stamp, os.now() - 22ms);
}

TEST_F(ChipTest, Bmp280HandsAMeasurementOnOnce) {
  auto chip = bmp280();
  Bmp280 driver(os, at(0x76, chip));
  ASSERT_TRUE(driver.set_up(why)) << why;
  std::vector<msg::BaroSample> out;
  ASSERT_TRUE(poll(driver, out)) << why;
  EXPECT_EQ(out.size(), 1u);
  os.pass(40ms);
  ASSERT_TRUE(poll(driver, out)) << why;
  EXPECT_TRUE(out.empty()) << "it has not measured since";
  chip->poke(wire::bmp280::kPressure + 2, 0xD0);
  os.pass(40ms);
  ASSERT_TRUE(poll(driver, out)) << why;
  EXPECT_EQ(out.size(), 1u);
}

TEST_F(ChipTest, Bmp280ThatHasNotMeasuredSaysNothing) {
  auto chip = bmp280();
  std::uint8_t at_ = wire::bmp280::kPressure;
  for (const int byte : {0x80, 0, 0, 0x80, 0, 0}) chip->poke(at_++, static_cast<std::uint8_t>(byte));
  Bmp280 driver(os, at(0x76, chip));
  ASSERT_TRUE(driver.set_up(why)) << why;
  std::vector<msg::BaroSample> out;
  ASSERT_TRUE(poll(driver, out));
  EXPECT_TRUE(out.empty());
}

TEST_F(ChipTest, Bmp280TellsGarbageInWords) {
  auto chip = bmp280();
  Bmp280 driver(os, at(0x76, chip));
  std::vector<msg::BaroSample> out;
  ASSERT_TRUE(driver.set_up(why)) << why;
  bus->fault = BusFault::held_high;
  EXPECT_FALSE(poll(driver, out));
  EXPECT_THAT(why, HasSubstr("the chip measures 30000 to 110000"));
  EXPECT_FALSE(driver.set_up(why));
  EXPECT_EQ(why,
            "i2c 0x76: its id is 0xff; a BMP280 says 0x58, a BME280 0x60 (nobody there: wiring, power, chip select?)");
  bus->fault = BusFault::none;
  for (int i = 0; i < 24; ++i) chip->poke(static_cast<std::uint8_t>(wire::bmp280::kCalibration + i), 0);
  EXPECT_FALSE(driver.set_up(why));
  EXPECT_EQ(why, "i2c 0x76: its calibration is empty (power, pull-ups?)");
}

// ---- QMC5883L

TEST_F(ChipTest, Qmc5883lMeasuresInTheBaseFrame) {
  struct Qmc : SimChip {
    void on_write(std::uint8_t address, std::uint8_t value) override {
      if (value != wire::qmc5883l::kSoftReset) poke(address, value);
    }
  };
  auto chip = std::make_shared<Qmc>();
  chip->poke(wire::qmc5883l::kChipId, 0xFF);
  Qmc5883l driver(os, at(0x0D, chip), {.range_gauss = 8, .rate_hz = 100}, {.yaw_deg = 180});
  ASSERT_TRUE(driver.set_up(why)) << why;
  EXPECT_EQ(chip->peek(wire::qmc5883l::kControl1), 0x19);
  std::vector<msg::MagSample> out;
  ASSERT_TRUE(poll(driver, out));
  EXPECT_TRUE(out.empty()) << "not ready";
  chip->poke(0, 0xB8), chip->poke(1, 0x0B), chip->poke(wire::qmc5883l::kStatus, wire::qmc5883l::kReady);
  ASSERT_TRUE(poll(driver, out));
  ASSERT_EQ(out.size(), 1u);
  EXPECT_DOUBLE_EQ(out[0].field_t.x, -1e-4);
  chip->poke(wire::qmc5883l::kStatus, wire::qmc5883l::kOverflow);
  EXPECT_FALSE(poll(driver, out));
  EXPECT_EQ(why, "i2c 0x0d: the field is beyond its range (a magnet or motor cable beside it?)");
  chip->poke(wire::qmc5883l::kChipId, 0x00);
  EXPECT_FALSE(driver.set_up(why));
  EXPECT_THAT(why, HasSubstr("its id is 0x00; a QMC5883L says 0xff"));
}

}  // namespace
}  // namespace sinew::drivers::chips_test
