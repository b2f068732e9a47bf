#include "apps/robot/linux_board.hpp"

#include <algorithm>
#include <cstdio>
#include <sstream>

#include "drivers/board/driver_list.hpp"
#include "hal/linux/devices/connectors.hpp"

namespace sinew::app {

bool uses_linux_board(const rt::GraphSpec& robot) {
  return robot.board == "linux" || std::any_of(robot.device_boards.begin(), robot.device_boards.end(),
                                               [](const auto& device) { return device.second.value == "linux"; });
}

std::vector<rt::Problem> check_linux_devices(const RobotFile& robot) {
  return drivers::check_devices(robot.devices, drivers::all_drivers());
}

hal::Result<std::unique_ptr<LinuxBoard>> LinuxBoard::open(const RobotFile& robot, hal::Os& os, std::string& why) {
  auto connectors = hal::LinuxConnectors::open(os, why);
  if (!connectors) return connectors.error();
  std::unique_ptr<LinuxBoard> board(new LinuxBoard);
  board->connectors_ = std::move(*connectors);
  board->board_ =
      std::make_unique<drivers::DeviceBoard>(robot.devices, drivers::all_drivers(), *board->connectors_, os);
  return board;
}

LinuxBoard::~LinuxBoard() = default;

static void print_lines(const std::string& text) {
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) std::fprintf(stderr, "sinew: %s\n", line.c_str());
}

void LinuxBoard::print_problems() const { print_lines(problem()); }
void LinuxBoard::print_notes() const { print_lines(board_->notes()); }

std::vector<std::string> LinuxBoard::print_warnings() const {
  std::vector<std::string> all = board_->warnings();
  for (std::string& text : board_->complaints())
    if (std::find(all.begin(), all.end(), text) == all.end()) all.push_back(std::move(text));
  for (const std::string& text : all) std::fprintf(stderr, "warning: %s\n", text.c_str());
  return all;
}

hal::Status LinuxBoard::start() { return board_->start(); }

}  // namespace sinew::app
