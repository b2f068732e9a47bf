#pragma once
// The load of a CAN bus and clashes on it, known before anything is opened: the check of a robot file and the hub of
// the open bus call the same functions.
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/joints/joint_hub.hpp"

namespace sinew::drivers {

struct BusLoad {
  std::size_t servos = 0;
  double tick_hz = 0, bit_rate = 0;
  double part = 0;  // of the bit rate, with the most stuff bits
};
BusLoad plan_load(std::span<const std::unique_ptr<BusService>> services, std::span<const ServoProtocol* const> servos,
                  double tick_hz, double bit_rate);
/// "8 servos at 1000 Hz need 271 % of 1000 kbit/s: fewer servos, a lower tick_hz, or another bus"
std::string to_string(const BusLoad& load);

/// A servo that cannot share a bus with an earlier one: frames of one would be taken for the other's.
struct BusClash {
  std::size_t first = 0, second = 0;  // by their place in the list
  std::string_view key;               // the key to change, in the second one's table
  std::uint32_t number = 0;           // its value
  std::string why;                    // the values that it may have
};
/// Each servo that clashes, with the first one that it clashes with.
/// - Two of one protocol with one number; of DroneCAN, where a node may have several: with one place in a command.
/// - A MIT motor that answers under an identifier that is a command to another motor.
/// - Two of different protocols that listen to the same identifier.
std::vector<BusClash> find_clashes(std::span<const ServoProtocol* const> servos);

}  // namespace sinew::drivers
