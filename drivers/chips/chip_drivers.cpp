#include "drivers/chips/chip_drivers.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "drivers/calibrated_imu.hpp"
#include "drivers/chips/bmp280.hpp"
#include "drivers/chips/icm42600.hpp"
#include "drivers/chips/mpu6050.hpp"
#include "drivers/chips/power_monitor.hpp"
#include "drivers/chips/qmc5883l.hpp"
#include "drivers/chips/registers.hpp"
#include "drivers/chips/reopened_bus.hpp"
#include "drivers/device_place.hpp"
#include "drivers/key_number.hpp"
#include "drivers/polled_driver.hpp"

namespace sinew::drivers {
namespace {

using namespace std::chrono_literals;

// Where a chip's registers are.
struct ChipPlace {
  std::string path;
  int address = 0;
  hal::SpiSpec spi;
  bool is_spi() const { return path.find("spi") != std::string::npos; }
};

/// `addresses`: those that the chip can have, the usual one first.
ChipPlace read_place(DeviceKeys& keys, std::initializer_list<std::int64_t> addresses, bool has_spi = true) {
  ChipPlace place;
  const std::string_view buses = has_spi ? "the path of the chip's bus, \"/dev/i2c-1\" or \"/dev/spidev0.0\""
                                         : "the path of the chip's bus, \"/dev/i2c-1\"";
  if (keys.read("path", place.path, buses, {.doc = "the bus of the chip", .required = true}) &&
      (!is_path(place.path) || (place.is_spi() && !has_spi)))
    keys.problem("path", buses);
  place.spi.path = place.path;
  place.address = static_cast<int>(*addresses.begin());
  keys.read_one_of("address", place.address, addresses, {.doc = "on I2C", .hex = true});
  if (place.is_spi() && keys.has("address")) keys.problem("address", "none on SPI: `path` has its chip select");
  if (place.is_spi())
    keys.claim("path", "chip at " + place_of_path(place.path));
  else
    keys.claim("address", "chip at " + place_of_path(place.path) + ", address " + std::to_string(place.address));
  if (!has_spi) return place;
  place.spi.mode = 3;  // what all chips here take
  keys.read_integer("spi_hz", place.spi.hz, 10'000, 50'000'000, {.unit = "Hz", .doc = "clock of SPI"});
  keys.read_integer("spi_mode", place.spi.mode, 0, 3, {.doc = "mode of SPI"});
  for (const char* key : {"spi_hz", "spi_mode"})
    if (!place.is_spi() && keys.has(key)) keys.problem(key, "none on I2C: `path` is no /dev/spidev");
  return place;
}

hal::Result<std::shared_ptr<hal::I2cBus>> open_i2c(const ChipPlace& place, DeviceContext& context, std::string& why) {
  auto bus = std::make_shared<ReopenedI2c>();
  // The connectors live as long as the board, and so do its devices.
  const auto opener = [&connectors = context.connectors, path = place.path](std::string& text) {
    return connectors.i2c(path, text);
  };
  if (auto done = bus->open(opener, why); !done) return done.error();
  return std::shared_ptr<hal::I2cBus>(std::move(bus));
}

hal::Result<std::unique_ptr<Registers>> open_registers(const ChipPlace& place, DeviceContext& context,
                                                       std::string& why) {
  // The connectors live as long as the board, and so do its devices.
  hal::Connectors& connectors = context.connectors;
  if (place.is_spi()) {
    auto bus = std::make_shared<ReopenedSpi>();
    const auto opener = [&connectors, spi = place.spi](std::string& text) { return connectors.spi(spi, text); };
    if (auto done = bus->open(opener, why); !done) return done.error();
    return std::unique_ptr<Registers>(std::make_unique<SpiRegisters>(std::move(bus)));
  }
  auto bus = open_i2c(place, context, why);
  if (!bus) return bus.error();
  return std::unique_ptr<Registers>(
      std::make_unique<I2cRegisters>(std::move(*bus), static_cast<std::uint8_t>(place.address)));
}

template <class Chip, class Config>
DeviceOpener imu_opener(const ChipPlace& place, const Config& config, const PollOptions& poll,
                        const ImuCalibration& calibration) {
  PollOptions brisk = poll;
  brisk.silent_after = std::max<hal::Duration>(100ms, 10 * poll.period);  // a loop depends on it
  return [=](DeviceContext& context, std::string& why) -> hal::Result<OpenedDevice> {
    auto registers = open_registers(place, context, why);
    if (!registers) return registers.error();
    auto sensor = PolledSensor<msg::ImuSample>::start(
        context.os, std::make_unique<Chip>(context.os, std::move(*registers), config), brisk, why);
    if (!sensor) return sensor.error();
    return opened_imu(std::move(*sensor), calibration);
  };
}

// The keys that all of these chips have.
template <class Setup>
void read_ranges(DeviceKeys& keys, Setup& chip) {
  keys.read_one_of("accel_g", chip.accel_g, {2, 4, 8, 16}, {.unit = "g", .doc = "full scale of the accelerometer"});
  keys.read_one_of("gyro_dps", chip.gyro_dps, {250, 500, 1000, 2000},
                   {.unit = "deg/s", .doc = "full scale of the gyroscope"});
  keys.read(
      "fifo", chip.fifo,
      {.doc = "every sample, from the chip's FIFO; false: the newest one, for an adapter that only speaks SMBus"});
}

DeviceOpener read_mpu6050(DeviceKeys& keys, const DeviceSpecs&) {
  const ChipPlace place = read_place(keys, {0x68, 0x69});
  Mpu6050Config config;
  read_ranges(keys, config.chip);
  keys.read_integer(
      "filter", config.chip.filter, 1, 6,
      {.doc = "low pass of the gyroscope: 1 to 6 are 184, 94, 44, 21, 10, 5 Hz; its delay is taken off the stamps"});
  keys.read_one_of("rate_hz", config.chip.rate_hz, {4, 5, 8, 10, 20, 25, 40, 50, 100, 125, 200, 250, 500, 1000},
                   {.unit = "Hz", .doc = "samples a second"});
  config.chip.spi = place.is_spi();
  const PollOptions poll = read_poll(keys, place.path, Mpu6050::period(config));
  return imu_opener<Mpu6050>(place, config, poll, ImuCalibration::read(keys));
}

DeviceOpener read_icm42600(DeviceKeys& keys, const DeviceSpecs&) {
  const ChipPlace place = read_place(keys, {0x68, 0x69});
  Icm42600Config config;
  read_ranges(keys, config.chip);
  keys.read_one_of("rate_hz", config.chip.rate_hz, {25, 50, 100, 200, 500, 1000, 2000, 4000, 8000},
                   {.unit = "Hz", .doc = "samples a second"});
  const PollOptions poll = read_poll(keys, place.path, Icm42600::period(config));
  return imu_opener<Icm42600>(place, config, poll, ImuCalibration::read(keys));
}

DeviceOpener read_bmp280(DeviceKeys& keys, const DeviceSpecs&) {
  const ChipPlace place = read_place(keys, {0x76, 0x77});
  const PollOptions poll = read_poll(keys, place.path, 40ms);
  return [=](DeviceContext& context, std::string& why) -> hal::Result<OpenedDevice> {
    auto registers = open_registers(place, context, why);
    if (!registers) return registers.error();
    return started<msg::BaroSample>(context, std::make_unique<Bmp280>(context.os, std::move(*registers)), poll, why);
  };
}

DeviceOpener read_qmc5883l(DeviceKeys& keys, const DeviceSpecs&) {
  const ChipPlace place = read_place(keys, {wire::qmc5883l::kAddress}, false);
  wire::qmc5883l::Setup setup;
  keys.read_one_of("range_gauss", setup.range_gauss, {2, 8}, {.unit = "G", .doc = "full scale"});
  keys.read_one_of("rate_hz", setup.rate_hz, {10, 50, 100, 200}, {.unit = "Hz", .doc = "samples a second"});
  const MountAngles mount = read_mount(keys);
  const PollOptions poll = read_poll(keys, place.path, hal::Duration{500'000'000 / setup.rate_hz});
  return [=](DeviceContext& context, std::string& why) -> hal::Result<OpenedDevice> {
    auto registers = open_registers(place, context, why);
    if (!registers) return registers.error();
    return started<msg::MagSample>(context, std::make_unique<Qmc5883l>(context.os, std::move(*registers), setup, mount),
                                   poll, why);
  };
}

std::optional<BatteryCells> read_cells(DeviceKeys& keys, double most_v) {
  BatteryCells cells;
  const bool given =
      keys.read_integer("cells", cells.count, 1, 8,
                        {.doc = "in series; without them the charge is not known (NaN)", .otherwise = "none"});
  keys.read("empty_v", cells.empty_v, 0.5, 5,
            {.unit = "V", .doc = "of a cell without a load: charge 0; in between in a straight line"});
  keys.read("full_v", cells.full_v, 0.5, 5, {.unit = "V", .doc = "of a cell without a load: charge 1"});
  double mohm = 0;
  keys.read("resistance_mohm", mohm, 0, 1000,
            {.unit = "mohm", .doc = "of all cells and wires: what a load takes from the voltage, for the charge"});
  cells.resistance_ohm = mohm / 1e3;
  for (const char* key : {"empty_v", "full_v", "resistance_mohm"})
    if (!given && keys.has(key)) keys.problem(key, "none without `cells`");
  if (!(cells.empty_v < cells.full_v)) keys.problem("full_v", "a number above empty_v, " + key_number(cells.empty_v));
  if (given && cells.count * cells.full_v > most_v)
    keys.problem("cells", "at most " + key_number(std::floor(most_v / cells.full_v)) + ", as the chip measures " +
                              key_number(most_v) + " V");
  return given ? std::optional(cells) : std::nullopt;
}

template <wire::ina2xx::Chip kChip>
DeviceOpener read_power_monitor(DeviceKeys& keys, const DeviceSpecs&) {
  const ChipPlace place = read_place(
      keys, {0x40, 0x41, 0x42, 0x43, 0x44, 0x45, 0x46, 0x47, 0x48, 0x49, 0x4A, 0x4B, 0x4C, 0x4D, 0x4E, 0x4F}, false);
  PowerMonitorConfig config;
  config.chip = kChip;
  double mohm = 0;
  if (keys.read(
          "shunt_mohm", mohm, 0.01, 1000,
          {.unit = "mohm",
           .doc = kChip == wire::ina2xx::Chip::ina219 ? "the shunt; 320 mV over it is the most that it measures"
                                                      : "the shunt; 81.92 mV over it is the most that it measures",
           .required = true}))
    config.shunt_ohm = mohm / 1e3;
  keys.read("reversed", config.reversed,
            {.doc = "the shunt is wired the other way round: a current drawn reads below 0"});
  config.cells = read_cells(keys, wire::ina2xx::facts(kChip).most_bus_v);
  const PollOptions poll = read_poll(keys, place.path, 10ms);
  return [=](DeviceContext& context, std::string& why) -> hal::Result<OpenedDevice> {
    auto bus = open_i2c(place, context, why);
    if (!bus) return bus.error();
    WordRegisters registers(std::move(*bus), static_cast<std::uint8_t>(place.address));
    return started<msg::BatterySample>(
        context, std::make_unique<PowerMonitor>(context.os, std::move(registers), config), poll, why);
  };
}

constexpr std::array kChipDrivers{
    DriverKind{"mpu6050", "imu", read_mpu6050},
    DriverKind{"icm42600", "imu", read_icm42600},
    DriverKind{"bmp280", "baro", read_bmp280},
    DriverKind{"qmc5883l", "mag", read_qmc5883l},
    DriverKind{"ina219", "battery", read_power_monitor<wire::ina2xx::Chip::ina219>},
    DriverKind{"ina226", "battery", read_power_monitor<wire::ina2xx::Chip::ina226>},
};

}  // namespace

std::span<const DriverKind> chip_drivers() { return kChipDrivers; }

}  // namespace sinew::drivers
