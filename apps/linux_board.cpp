#include "apps/linux_board.hpp"

#include <algorithm>
#include <cstdio>
#include <sstream>

#include "drivers/driver_list.hpp"
#include "hal/linux/connectors.hpp"

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

void LinuxBoard::tell_changes() {
  std::set<std::string> now;
  for (const std::string& line : board_->complaints()) {
    std::string same = line;  // "for 3 s", "tried 4 times": the same complaint as a second ago
    std::erase_if(same, [](char c) { return (c >= '0' && c <= '9') || c == '.'; });
    now.insert(same);
    if (stood_.contains(same) && told_.insert(same).second) std::fprintf(stderr, "sinew: %s\n", line.c_str());
  }
  if (now.empty() && !told_.empty()) std::fprintf(stderr, "sinew: all devices are well again\n");
  std::erase_if(told_, [&](const std::string& t) { return !now.contains(t); });
  stood_ = std::move(now);
}

hal::Status LinuxBoard::start() { return board_->start(); }

}  // namespace sinew::app
