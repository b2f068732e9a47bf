#pragma once
#include <cstdint>
#include <string>
#include <vector>

namespace sinew::app {

struct DevicesOptions {
  std::string robot;                       // robot file; empty: only `buses`
  std::vector<std::string> buses{};        // TRANSPORT:ADDRESS
  std::vector<std::string> ask{}, set{};   // families (empty: all); --set
  std::vector<std::uint32_t> bit_rates{};  // of serial lines; empty: the robot file's, else the usual ones
  bool json = false;
};

/// Lists a robot's devices and asks its CAN buses and serial lines who is there (drivers::CanScan, SerialScan). Exit
/// code 0: every joint of the file that was asked for answers; 1: one does not, or a bus takes no frame; 2: it could
/// not be begun.
int devices_command(const DevicesOptions& options);

}  // namespace sinew::app
