#include "drivers/driver_list.hpp"

#include <vector>

#include "drivers/can_servos.hpp"
#include "drivers/chip_drivers.hpp"
#include "drivers/kernel_drivers.hpp"

namespace sinew::drivers {

std::span<const DriverKind> all_drivers() {
  static const std::vector<DriverKind> all = [] {
    std::vector<DriverKind> list;
    for (const auto group : {kernel_drivers(), chip_drivers()}) list.insert(list.end(), group.begin(), group.end());
    list.push_back({"can_servos", "actuators, joints", read_can_servos});
    list.push_back({"joints_of", "joints", read_joints_of});
    return list;
  }();
  return all;
}

bool gives(const DriverKind& driver, std::string_view what) {
  std::string_view rest = driver.measures;  // a list: "actuators, joints"
  while (!rest.empty()) {
    const std::size_t end = rest.find(", ");
    if (rest.substr(0, end) == what) return true;
    rest = end == std::string_view::npos ? std::string_view() : rest.substr(end + 2);
  }
  return false;
}

}  // namespace sinew::drivers
