#include "drivers/chip_drivers.hpp"

#include <algorithm>
#include <array>

#include "drivers/bmp280.hpp"
#include "drivers/calibrated_imu.hpp"
#include "drivers/gnss_receiver.hpp"
#include "drivers/icm42600.hpp"
#include "drivers/mpu6050.hpp"
#include "drivers/polled_sensor.hpp"
#include "drivers/qmc5883l.hpp"
#include "drivers/rc_receiver.hpp"
#include "drivers/registers.hpp"
#include "drivers/reopened_bus.hpp"
#include "drivers/tf_mini.hpp"

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

bool is_path(std::string_view path) { return path.size() > 1 && path.front() == '/'; }

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
  if (!has_spi) return place;
  place.spi.mode = 3;  // what all chips here take
  keys.read_integer("spi_hz", place.spi.hz, 10'000, 50'000'000, {.unit = "Hz", .doc = "clock of SPI"});
  keys.read_integer("spi_mode", place.spi.mode, 0, 3, {.doc = "mode of SPI"});
  for (const char* key : {"spi_hz", "spi_mode"})
    if (!place.is_spi() && keys.has(key)) keys.problem(key, "none on I2C: `path` is no /dev/spidev");
  return place;
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
  auto bus = std::make_shared<ReopenedI2c>();
  const auto opener = [&connectors, path = place.path](std::string& text) { return connectors.i2c(path, text); };
  if (auto done = bus->open(opener, why); !done) return done.error();
  return std::unique_ptr<Registers>(
      std::make_unique<I2cRegisters>(std::move(bus), static_cast<std::uint8_t>(place.address)));
}

PollOptions read_poll(DeviceKeys& keys, const std::string& path, hal::Duration period) {
  PollOptions poll;
  poll.name = keys.spec().name;
  poll.path = path;
  poll.period = period;
  poll.fifo_priority = 88;  // above the loops that wait for it
  keys.read_integer("priority", poll.fifo_priority, 0, 99, {.doc = "SCHED_FIFO of its thread; 0: an ordinary one"});
  return poll;
}

template <class M>
hal::Result<OpenedDevice> started(DeviceContext& context, std::unique_ptr<PolledDevice<M>> chip,
                                  const PollOptions& poll, std::string& why) {
  auto sensor = PolledSensor<M>::start(context.os, std::move(chip), poll, why);
  if (!sensor) return sensor.error();
  const std::shared_ptr<PolledSensor<M>> shared = std::move(*sensor);
  OpenedDevice device;
  device.owner = shared;
  device.report = shared.get();
  device.sensor(hal::kSensorKind<M>) = static_cast<hal::Sensor<M>*>(shared.get());
  return device;
}

template <class Chip, class Config>
DeviceOpener imu_opener(const ChipPlace& place, const Config& config, const PollOptions& poll,
                        const ImuCalibration& calibration) {
  PollOptions brisk = poll;
  brisk.silent_after = std::max<hal::Duration>(100ms, 10 * poll.period);  // a loop hangs on it
  return [=](DeviceContext& context, std::string& why) -> hal::Result<OpenedDevice> {
    auto registers = open_registers(place, context, why);
    if (!registers) return registers.error();
    auto sensor = PolledSensor<msg::ImuSample>::start(
        context.os, std::make_unique<Chip>(context.os, std::move(*registers), config), brisk, why);
    if (!sensor) return sensor.error();
    return opened_imu(std::move(*sensor), calibration);
  };
}

// What all of these chips offer.
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
  return imu_opener<Mpu6050>(place, config, read_poll(keys, place.path, Mpu6050::period(config)),
                             ImuCalibration::read(keys));
}

DeviceOpener read_icm42600(DeviceKeys& keys, const DeviceSpecs&) {
  const ChipPlace place = read_place(keys, {0x68, 0x69});
  Icm42600Config config;
  read_ranges(keys, config.chip);
  keys.read_one_of("rate_hz", config.chip.rate_hz, {25, 50, 100, 200, 500, 1000, 2000, 4000, 8000},
                   {.unit = "Hz", .doc = "samples a second"});
  return imu_opener<Icm42600>(place, config, read_poll(keys, place.path, Icm42600::period(config)),
                              ImuCalibration::read(keys));
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

hal::SerialSpec read_serial(DeviceKeys& keys, std::uint32_t bit_rate) {
  constexpr std::string_view kPath = "the path of a serial line, e.g. \"/dev/ttyS1\"";
  hal::SerialSpec spec;
  if (keys.read("path", spec.path, kPath, {.doc = "its serial line", .required = true}) && !is_path(spec.path))
    keys.problem("path", kPath);
  spec.bit_rate = bit_rate;
  return spec;
}

constexpr KeyInfo kBitRate{.unit = "bit/s", .doc = "as the device is set"};

// The connectors live as long as the board, and so do its devices.
SerialOpener opener_of(const hal::SerialSpec& spec, DeviceContext& context) {
  return [spec, &connectors = context.connectors](std::string& why) { return connectors.serial(spec, why); };
}

DeviceOpener read_tfmini(DeviceKeys& keys, const DeviceSpecs&) {
  hal::SerialSpec spec = read_serial(keys, 115'200);
  keys.read_integer("bit_rate", spec.bit_rate, 9'600, 921'600, kBitRate);
  std::uint16_t weakest = 100;
  keys.read_integer("weakest_echo", weakest, 0, 65535, {.doc = "a distance whose echo is weaker is none"});
  const PollOptions poll = read_poll(keys, spec.path, 10ms);
  return [=](DeviceContext& context, std::string& why) {
    return started<msg::RangeSample>(context, std::make_unique<TfMini>(opener_of(spec, context), weakest), poll, why);
  };
}

DeviceOpener read_gnss(DeviceKeys& keys, const DeviceSpecs&) {
  hal::SerialSpec spec = read_serial(keys, 9'600);
  // NMEA 0183's own is the first; the others are those that receivers and serial lines have in common.
  keys.read_one_of("bit_rate", spec.bit_rate,
                   {4'800, 9'600, 14'400, 19'200, 38'400, 57'600, 115'200, 230'400, 460'800, 921'600, 1'000'000,
                    1'500'000, 2'000'000, 3'000'000, 4'000'000},
                   kBitRate);
  GnssConfig config;
  keys.read("configure_ubx", config.configure_ubx, {.doc = "asks a u-blox receiver for NAV-PVT at period_ms"});
  keys.read_integer("period_ms", config.period_ms, 25, 10'000, {.unit = "ms", .doc = "with configure_ubx"});
  keys.read_ms("delay_ms", config.delay, 0, 2000,
               {.doc = "from the instant of a solution to its coming in, taken off the stamps: the receiver's manual"});
  keys.read("error_per_hdop_m", config.error_per_hdop_m, 0.01, 100,
            {.unit = "m", .doc = "NMEA tells no accuracy: one sigma is this times the dilution"});
  PollOptions poll = read_poll(keys, spec.path, 20ms);
  poll.silent_after = 3s;
  return [=](DeviceContext& context, std::string& why) {
    return started<msg::GnssSample>(context, std::make_unique<GnssReceiver>(opener_of(spec, context), config), poll,
                                    why);
  };
}

template <RcProtocol kProtocol>
DeviceOpener read_rc(DeviceKeys& keys, const DeviceSpecs&) {
  constexpr bool kIsSbus = kProtocol == RcProtocol::sbus;
  hal::SerialSpec spec = read_serial(keys, kIsSbus ? 100'000 : 420'000);
  if (kIsSbus)
    keys.read_one_of("bit_rate", spec.bit_rate, {100'000, 200'000}, {.unit = "bit/s", .doc = "200000: its fast mode"});
  else  // 416666 by its makers, 420000 by most, and receivers that can be set to others
    keys.read_integer("bit_rate", spec.bit_rate, 115'200, 4'000'000, kBitRate);
  spec.even_parity = spec.two_stop_bits = kIsSbus;
  // Not inverted by default: no call of the kernel inverts a line; an inverter or the device tree does.
  if (kIsSbus)
    keys.read("inverted", spec.inverted,
              {.doc = "the line comes inverted; Linux cannot undo that, an inverter or the device tree does"});
  RcConfig config;
  config.protocol = kProtocol;
  keys.read_ms("lost_after_ms", config.lost_after, 20, 10'000, {.doc = "no frame for so long: the pilot is lost"});
  const PollOptions poll = read_poll(keys, spec.path, 5ms);
  return [=](DeviceContext& context, std::string& why) {
    return started<msg::RcSample>(context, std::make_unique<RcReceiver>(opener_of(spec, context), config), poll, why);
  };
}

constexpr std::array kDrivers{
    DriverKind{"mpu6050", "imu", read_mpu6050},          DriverKind{"icm42600", "imu", read_icm42600},
    DriverKind{"bmp280", "baro", read_bmp280},           DriverKind{"qmc5883l", "mag", read_qmc5883l},
    DriverKind{"tfmini", "range", read_tfmini},          DriverKind{"gnss", "gnss", read_gnss},
    DriverKind{"sbus", "rc", read_rc<RcProtocol::sbus>}, DriverKind{"crsf", "rc", read_rc<RcProtocol::crsf>},
};

}  // namespace

std::span<const DriverKind> chip_drivers() { return kDrivers; }

}  // namespace sinew::drivers
