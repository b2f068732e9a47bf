#pragma once
#include <memory>
#include <string>
#include <vector>

#include "apps/robot_file/robot_file.hpp"
#include "drivers/board/device_board.hpp"
#include "hal/os.hpp"

namespace sinew::app {

/// Whether any device of this robot comes from the board "linux".
bool uses_linux_board(const rt::GraphSpec& robot);

/// What is wrong with the tables of the robot's devices and buses; nothing is opened.
std::vector<rt::Problem> check_linux_devices(const RobotFile& robot);

/// The board "linux": this machine's buses and ports with Sinew's drivers on them.
/// Thread:  owner, configure only.
class LinuxBoard {
 public:
  /// Errors: those of starting the thread that watches descriptors; `why` has the text.
  static hal::Result<std::unique_ptr<LinuxBoard>> open(const RobotFile& robot, hal::Os& os, std::string& why);
  ~LinuxBoard();
  hal::Board& board() { return *board_; }
  /// Starts the threads of the buses: after everything is configured, before the first cycle. Errors: problem() says.
  hal::Status start();
  /// All failures so far in words, one a line; empty: none.
  const std::string& problem() const { return board_->problem(); }
  /// Prints problem() on standard error.
  void print_problems() const;
  /// Prints DeviceBoard::notes() on standard error.
  void print_notes() const;
  /// Prints on standard error, and returns, the warnings of opening and the complaints so far.
  std::vector<std::string> print_warnings() const;
  /// What is wrong now with its devices and buses, one a line; see drivers::DeviceBoard. Thread: any, after start().
  std::vector<std::string> complaints() const { return board_->complaints(); }
  /// Threads of its devices that did not get what they asked for. After start().
  std::vector<std::string> shortfalls() const { return board_->shortfalls(); }

 private:
  LinuxBoard() = default;
  std::unique_ptr<hal::Connectors> connectors_;
  std::unique_ptr<drivers::DeviceBoard> board_;
};

}  // namespace sinew::app
