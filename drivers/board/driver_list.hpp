#pragma once
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/board/device_board.hpp"

namespace sinew::drivers {

/// Every driver of the house, in the order of docs/reference/device-keys.md.
std::span<const DriverKind> all_drivers();

/// The part of a robot file that uses devices which measure `measured` (DriverKind::measures): the type of a [module],
/// or [actuator.NAME]. Empty: there is none.
std::string_view reader_of(std::string_view measured);

/// The keys of one driver, bus or joint, as its reader declares them.
struct KeyTable {
  std::string_view header;                // "[device.NAME]", "[[device.NAME.joint]]", "[bus.NAME]"
  std::string_view driver, measures;      // measures: of devices only
  std::vector<std::string_view> readers;  // reader_of() of each thing that it measures
  std::vector<KeyRow> rows;
};
/// All there are: devices, buses, joints.
std::vector<KeyTable> key_tables();
/// Whether devices of this driver give `what`, e.g. "imu".
bool gives(const DriverKind& driver, std::string_view what);

}  // namespace sinew::drivers
