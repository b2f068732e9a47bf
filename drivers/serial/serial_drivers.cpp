#include "drivers/serial/serial_drivers.hpp"

#include <array>

#include "drivers/device_place.hpp"
#include "drivers/polled_driver.hpp"
#include "drivers/serial/gnss_receiver.hpp"
#include "drivers/serial/rc_receiver.hpp"
#include "drivers/serial/tf_mini.hpp"

namespace sinew::drivers {
namespace {

using namespace std::chrono_literals;

hal::SerialSpec read_serial(DeviceKeys& keys, std::uint32_t bit_rate) {
  constexpr std::string_view kPath = "the path of a serial line, e.g. \"/dev/ttyS1\"";
  hal::SerialSpec spec;
  if (keys.read("path", spec.path, kPath, {.doc = "its serial line", .required = true}) && !is_path(spec.path))
    keys.problem("path", kPath);
  keys.claim("path", "serial line " + place_of_path(spec.path));
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

constexpr std::array kSerialDrivers{
    DriverKind{"tfmini", "range", read_tfmini},
    DriverKind{"gnss", "gnss", read_gnss},
    DriverKind{"sbus", "rc", read_rc<RcProtocol::sbus>},
    DriverKind{"crsf", "rc", read_rc<RcProtocol::crsf>},
};

}  // namespace

std::span<const DriverKind> serial_drivers() { return kSerialDrivers; }

}  // namespace sinew::drivers
