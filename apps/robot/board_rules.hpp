#pragma once
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "rt/graph_spec.hpp"

namespace sinew::app {

/// Properties of a kind of board that decide with which other boards it may be mixed.
struct BoardKind {
  std::string_view name;
  bool real = false;       // its devices are in the real world and do not wait for a grant
  bool actuators = false;  // it can have some
};

/// The boards that this program knows.
std::span<const BoardKind> known_boards();

/// The board of a device.
const std::string& board_of(const rt::GraphSpec& robot, const std::string& device);

/// Whether any device of this robot is in a plant.
bool needs_plant(const rt::GraphSpec& robot);

struct BoardUse {
  bool virtual_time = false;
  bool real_actuators = false;  // --real-actuators
};

/// Whether this robot may run with these boards, all problems at once; before any device is opened.
/// - Boards are known ones; a board without actuators is given none.
/// - Virtual time takes no real device: it would have to wait for a grant.
/// - Real actuators with simulated sensors need the explicit permission: the sensors do not show what the actuators do.
/// - A record that is the board takes no real device beside it; a real board takes a record beside it.
/// - With a plant, the plant is the board, and other boards are named per device: there is one source of time.
std::vector<rt::Problem> check_boards(const rt::GraphSpec& robot, const BoardUse& use,
                                      std::span<const BoardKind> boards = known_boards());

/// Why a fault of the plant ("DEVICE:KIND...") has no effect: this robot takes DEVICE from another board. Empty: it
/// has one, and for "radio" something that uses it. The plant itself judges faults of the link and of devices that no
/// robot names.
std::string unfelt_fault(const rt::GraphSpec& robot, const std::string& fault);

}  // namespace sinew::app
