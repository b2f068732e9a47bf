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

ChipPlace read_place(DeviceKeys& keys, int address) {
  ChipPlace place;
  keys.require("path", place.path, "the bus of the chip: \"/dev/i2c-1\" or \"/dev/spidev0.0\"");
  place.address = address;
  place.spi.path = place.path;
  if (place.is_spi()) {
    keys.read_integer("spi_hz", place.spi.hz, 10'000, 50'000'000);
    place.spi.mode = 3;  // what all chips here take
    keys.read_integer("spi_mode", place.spi.mode, 0, 3);
    keys.claim("path", "chip at " + place.path);
  } else {
    keys.read_integer("address", place.address, 3, 0x77);
    keys.claim("address", "chip at " + place.path + ", address " + std::to_string(place.address));
  }
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
  keys.read_integer("priority", poll.fifo_priority, 0, 99);
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

// The chip's own ranges are what the datasheet offers; what it does not offer, its set-up refuses by name.
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

DeviceOpener read_mpu6050(DeviceKeys& keys, const DeviceSpecs&) {
  const ChipPlace place = read_place(keys, 0x68);
  Mpu6050Config config;
  keys.read_integer("accel_g", config.chip.accel_g, 2, 16);
  keys.read_integer("gyro_dps", config.chip.gyro_dps, 250, 2000);
  keys.read_integer("filter", config.chip.filter, 1, 6);
  keys.read_integer("rate_hz", config.chip.rate_hz, 4, 1000);
  keys.read("fifo", config.chip.fifo);
  config.chip.spi = place.is_spi();
  return imu_opener<Mpu6050>(place, config, read_poll(keys, place.path, Mpu6050::period(config)),
                             ImuCalibration::read(keys));
}

DeviceOpener read_icm42600(DeviceKeys& keys, const DeviceSpecs&) {
  const ChipPlace place = read_place(keys, 0x68);
  Icm42600Config config;
  keys.read_integer("accel_g", config.chip.accel_g, 2, 16);
  keys.read_integer("gyro_dps", config.chip.gyro_dps, 250, 2000);
  keys.read_integer("rate_hz", config.chip.rate_hz, 25, 8000);
  keys.read("fifo", config.chip.fifo);
  return imu_opener<Icm42600>(place, config, read_poll(keys, place.path, Icm42600::period(config)),
                              ImuCalibration::read(keys));
}

DeviceOpener read_bmp280(DeviceKeys& keys, const DeviceSpecs&) {
  const ChipPlace place = read_place(keys, 0x76);
  const PollOptions poll = read_poll(keys, place.path, 40ms);
  return [=](DeviceContext& context, std::string& why) -> hal::Result<OpenedDevice> {
    auto registers = open_registers(place, context, why);
    if (!registers) return registers.error();
    return started<msg::BaroSample>(context, std::make_unique<Bmp280>(context.os, std::move(*registers)), poll, why);
  };
}

DeviceOpener read_qmc5883l(DeviceKeys& keys, const DeviceSpecs&) {
  const ChipPlace place = read_place(keys, wire::qmc5883l::kAddress);
  wire::qmc5883l::Setup setup;
  keys.read_integer("range_gauss", setup.range_gauss, 2, 8);
  keys.read_integer("rate_hz", setup.rate_hz, 10, 200);
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
  hal::SerialSpec spec;
  keys.require("path", spec.path, "a serial line, e.g. \"/dev/ttyS1\"");
  keys.claim("path", "serial line " + spec.path);
  spec.bit_rate = bit_rate;
  keys.read_integer("bit_rate", spec.bit_rate, 300, 4'000'000);
  return spec;
}

// The connectors live as long as the board, and so do its devices.
SerialOpener opener_of(const hal::SerialSpec& spec, DeviceContext& context) {
  return [spec, &connectors = context.connectors](std::string& why) { return connectors.serial(spec, why); };
}

DeviceOpener read_tfmini(DeviceKeys& keys, const DeviceSpecs&) {
  const hal::SerialSpec spec = read_serial(keys, 115200);
  std::uint16_t weakest = 100;
  keys.read_integer("weakest_echo", weakest, 0, 65535);
  const PollOptions poll = read_poll(keys, spec.path, 10ms);
  return [=](DeviceContext& context, std::string& why) {
    return started<msg::RangeSample>(context, std::make_unique<TfMini>(opener_of(spec, context), weakest), poll, why);
  };
}

DeviceOpener read_gnss(DeviceKeys& keys, const DeviceSpecs&) {
  const hal::SerialSpec spec = read_serial(keys, 9600);
  GnssConfig config;
  keys.read("configure_ubx", config.configure_ubx);
  keys.read_integer("period_ms", config.period_ms, 25, 10'000);
  double delay_ms = 0;
  if (keys.read("delay_ms", delay_ms, 0, 2000)) config.delay = hal::Duration{static_cast<std::int64_t>(delay_ms * 1e6)};
  keys.read("error_per_hdop_m", config.error_per_hdop_m, 0.01, 100);
  PollOptions poll = read_poll(keys, spec.path, 20ms);
  poll.silent_after = 3s;
  return [=](DeviceContext& context, std::string& why) {
    return started<msg::GnssSample>(context, std::make_unique<GnssReceiver>(opener_of(spec, context), config), poll,
                                    why);
  };
}

template <RcProtocol kProtocol>
DeviceOpener read_rc(DeviceKeys& keys, const DeviceSpecs&) {
  hal::SerialSpec spec = read_serial(keys, kProtocol == RcProtocol::sbus ? 100'000 : 420'000);
  spec.even_parity = spec.two_stop_bits = kProtocol == RcProtocol::sbus;
  // Not inverted by default: no call of the kernel inverts a line; an inverter or the device tree does.
  if (kProtocol == RcProtocol::sbus) keys.read("inverted", spec.inverted);
  RcConfig config;
  config.protocol = kProtocol;
  double lost_ms = 200;
  if (keys.read("lost_after_ms", lost_ms, 20, 10'000))
    config.lost_after = hal::Duration{static_cast<std::int64_t>(lost_ms * 1e6)};
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
