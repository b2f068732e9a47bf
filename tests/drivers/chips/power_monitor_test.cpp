// INA219 and INA226 on simulated chips, and their keys in a robot file.
#include "drivers/chips/power_monitor.hpp"

#include <gmock/gmock.h>

#include <cmath>

#include "bench_os.hpp"
#include "drivers/board/driver_list.hpp"
#include "sim_hil/wire/sim_power_monitor.hpp"

namespace sinew::drivers::power_monitor_test {
namespace {

using namespace std::chrono_literals;
using sim_hil::BusFault, sim_hil::SimI2cBus, sim_hil::SimPowerMonitor;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using wire::ina2xx::Chip;

class PowerMonitors : public ::testing::TestWithParam<Chip> {
 protected:
  void make(PowerMonitorConfig config = {}) {
    config.chip = GetParam();
    chip = std::make_shared<SimPowerMonitor>(GetParam());
    bus->attach(0x40, chip);
    driver = std::make_unique<PowerMonitor>(os, WordRegisters(bus, 0x40), config);
  }
  void start(const PowerMonitorConfig& config = {}) {
    make(config);
    ASSERT_TRUE(driver->set_up(why)) << why;
  }
  hal::Status poll() {
    out.clear();
    return driver->poll(os.now(), out, why);
  }
  test::BenchOs os;
  std::shared_ptr<SimI2cBus> bus = std::make_shared<SimI2cBus>();
  std::shared_ptr<SimPowerMonitor> chip;
  std::unique_ptr<PowerMonitor> driver;
  std::vector<msg::BatterySample> out;
  std::string why;
};

TEST_P(PowerMonitors, EachConversionIsOneSampleInVoltsAndAmperes) {
  start({.shunt_ohm = 0.0005});
  EXPECT_EQ(chip->word(wire::ina2xx::kConfig), wire::ina2xx::facts(GetParam()).measuring);
  ASSERT_TRUE(poll());
  EXPECT_THAT(out, IsEmpty()) << "nothing was measured yet";
  chip->measure(15.2, 0.01);
  ASSERT_TRUE(poll()) << why;
  ASSERT_EQ(out.size(), 1u);
  EXPECT_NEAR(out[0].voltage_v, 15.2, 0.002);
  EXPECT_NEAR(out[0].current_a, 20, 0.02);
  EXPECT_TRUE(std::isnan(out[0].charge)) << "nobody said how many cells";
  EXPECT_NEAR(msg::seconds(os.now() - out[0].stamp), wire::ina2xx::facts(GetParam()).window_ms / 2e3, 1e-6);
  ASSERT_TRUE(poll());
  EXPECT_THAT(out, IsEmpty()) << "one conversion is one sample";
}

TEST_P(PowerMonitors, ACurrentIntoTheBatteryAndAReversedShuntHaveTheirSign) {
  start({.shunt_ohm = 0.001});
  chip->measure(15, -0.002);
  ASSERT_TRUE(poll());
  EXPECT_NEAR(out.at(0).current_a, -2, 0.02);
  start({.shunt_ohm = 0.001, .reversed = true});
  chip->measure(15, -0.002);
  ASSERT_TRUE(poll());
  EXPECT_NEAR(out.at(0).current_a, 2, 0.02);
}

TEST_P(PowerMonitors, BeyondTheShuntOnlyTheCurrentIsUnknown) {
  start({.shunt_ohm = 0.001, .cells = BatteryCells{.count = 4}});
  chip->measure(15.2, 0.4);
  ASSERT_TRUE(poll()) << why;
  ASSERT_EQ(out.size(), 1u);
  EXPECT_TRUE(std::isnan(out[0].current_a));
  EXPECT_NEAR(out[0].voltage_v, 15.2, 0.002);
  EXPECT_FALSE(std::isnan(out[0].charge));
  start({.shunt_ohm = 0.001, .cells = BatteryCells{.count = 4, .resistance_ohm = 0.02}});
  chip->measure(15.2, 0.4);
  ASSERT_TRUE(poll());
  EXPECT_TRUE(std::isnan(out.at(0).charge)) << "what the load hides is unknown, too";
}

TEST_P(PowerMonitors, ChargeIsThatOfTheCellsWithoutTheLoad) {
  start({.shunt_ohm = 0.001, .cells = BatteryCells{.count = 4, .empty_v = 3.5, .full_v = 4.2, .resistance_ohm = 0.03}});
  const auto charge = [&](double voltage_v, double current_a) {
    chip->measure(voltage_v, current_a * 0.001);
    EXPECT_TRUE(poll()) << why;
    return out.empty() ? -1.0 : out[0].charge;
  };
  EXPECT_NEAR(charge(15.4, 0), 0.5, 0.002);
  EXPECT_NEAR(charge(14.8, 20), 0.5, 0.002) << "0.6 V of it are the load's";
  EXPECT_EQ(charge(17.0, 0), 1);
  EXPECT_EQ(charge(13.0, 0), 0);
}

TEST_P(PowerMonitors, OneThatLostItsPowerSaysSoAndIsSetUpAgain) {
  start();
  chip->power_cycle();
  chip->measure(15, 0);
  ASSERT_FALSE(poll());
  EXPECT_THAT(why, HasSubstr("i2c 0x40: its set-up reads 0x"));
  EXPECT_THAT(why, HasSubstr("(it lost its power for a moment?)"));
  EXPECT_THAT(out, IsEmpty());
  ASSERT_TRUE(driver->set_up(why)) << why;
  chip->measure(15, 0);
  EXPECT_TRUE(poll());
  EXPECT_EQ(out.size(), 1u);
}

TEST_P(PowerMonitors, LinesThatAreHeldAreNoMeasurement) {
  start();
  chip->measure(15, 0);
  for (const auto fault : {BusFault::held_high, BusFault::held_low}) {
    bus->fault = fault;
    EXPECT_FALSE(poll());
    EXPECT_THAT(why, HasSubstr("(nobody there: wiring, power?)"));
    EXPECT_FALSE(driver->set_up(why));
    EXPECT_THAT(why, HasSubstr("(nobody there: wiring, power?)"));
  }
  bus->fault = BusFault::no_answer;
  EXPECT_FALSE(poll());
  EXPECT_EQ(why, "i2c 0x40: nothing answers (wiring, address, power?)");
}

TEST_P(PowerMonitors, AnotherChipIsNotTakenForIt) {
  const Chip other = GetParam() == Chip::ina226 ? Chip::ina219 : Chip::ina226;
  make();
  bus->attach(0x40, std::make_shared<SimPowerMonitor>(other));
  const auto done = driver->set_up(why);
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().code, hal::Errc::not_found);
  EXPECT_EQ(why,
            GetParam() == Chip::ina226
                ? "i2c 0x40: its ids are 0x0000, 0x0000; an INA226 says 0x5449, 0x2260 (nobody there: wiring, power?)"
                : "i2c 0x40: its set-up after a reset is 0x4127; an INA219 has 0x399f");
}

TEST_P(PowerMonitors, AVoltageThatItCannotMeasureIsGarbage) {
  start();
  chip->measure(32, 0);
  const bool fits = GetParam() == Chip::ina226;
  EXPECT_EQ(static_cast<bool>(poll()), fits);
  if (fits) {
    chip->measure(40, 0);
    EXPECT_FALSE(poll());
    EXPECT_EQ(why, "i2c 0x40: says 40.000000 V; the chip measures at most 36");
  } else {
    EXPECT_EQ(why, "i2c 0x40: says 32.000000 V; the chip measures at most 26");
  }
}

INSTANTIATE_TEST_SUITE_P(Of, PowerMonitors, testing::Values(Chip::ina219, Chip::ina226),
                         [](const auto& chip) { return std::string(wire::ina2xx::facts(chip.param).name); });

std::vector<std::string> said_of(const std::string& driver, const std::map<std::string, rt::ParamValue>& keys) {
  DeviceSpecs specs;
  DeviceSpec spec;
  spec.name = "battery", spec.driver = driver, spec.line = 1;
  int line = 1;
  for (const auto& [key, value] : keys) spec.keys[key] = {value, ++line};
  spec.keys["path"] = {std::string("/dev/i2c-1"), 9};
  specs.devices.push_back(spec);
  std::vector<std::string> out;
  for (const auto& p : check_devices(specs, all_drivers())) out.push_back(rt::to_string(p, "r.toml"));
  return out;
}

TEST(PowerMonitorKeys, NeedTheShuntAndTakeCellsAsAWhole) {
  EXPECT_THAT(said_of("ina226", {{"shunt_mohm", 0.5}}), IsEmpty());
  EXPECT_THAT(said_of("ina226", {}),
              ElementsAre("r.toml:1: device.battery.shunt_mohm: missing: a number from 0.01 to 1000; it is required"));
  EXPECT_THAT(said_of("ina226", {{"address", std::int64_t{0x50}}, {"shunt_mohm", 1.0}}),
              ElementsAre(HasSubstr("device.battery.address: 0x50: one of 0x40, 0x41")));
  EXPECT_THAT(said_of("ina226", {{"empty_v", 3.3}, {"shunt_mohm", 1.0}}),
              ElementsAre("r.toml:2: device.battery.empty_v: 3.3: none without `cells`"));
  EXPECT_THAT(said_of("ina226", {{"cells", std::int64_t{4}}, {"empty_v", 4.3}, {"shunt_mohm", 1.0}}),
              ElementsAre("r.toml:1: device.battery.full_v: default 4.2: a number above empty_v, 4.3"));
  EXPECT_THAT(said_of("ina226", {{"cells", std::int64_t{8}}, {"shunt_mohm", 1.0}}), IsEmpty());
  EXPECT_THAT(said_of("ina219", {{"cells", std::int64_t{8}}, {"shunt_mohm", 1.0}}),
              ElementsAre("r.toml:2: device.battery.cells: 8: at most 6, as the chip measures 26 V"));
}

}  // namespace
}  // namespace sinew::drivers::power_monitor_test
