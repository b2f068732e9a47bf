#pragma once
// Decisions of `sinew deploy`, without side effects: which files it copies, whether they fit, and what went wrong.
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "apps/deploy/board_shell.hpp"
#include "apps/robot_file/robot_file.hpp"

namespace sinew::app {

/// The machine that a program was built for.
struct ElfTarget {
  std::uint16_t machine = 0;  // EM_...
  bool wide = false;          // 64 bit
  bool big_endian = false;
};

/// From the first bytes of a program; nothing when it is none. Source: System V ABI, chapter 4, "ELF Header".
std::optional<ElfTarget> elf_target(std::span<const unsigned char> head);
/// "aarch64, 64 bit".
std::string to_text(const ElfTarget& target);
/// Whether a kernel that says `machine` (uname -m) can run it at all. A 64-bit kernel may also run 32-bit programs;
/// only a try on the board shows whether it has their libraries.
bool fits(const ElfTarget& target, std::string_view machine);

/// The answers of apps/deploy/probe.sh.
struct BoardFacts {
  enum class Root : std::uint8_t { is, sudo, password, no };
  std::string folder, machine, user;
  bool writes = false;  // this login may write the folder
  Root root = Root::no;
  bool tar = false, systemd = false;
  std::optional<std::uint64_t> free_bytes{};
  std::vector<int> cpus{};
  std::vector<std::string> groups{};  // groups of devices that the board has

  bool can_be_root() const { return root == Root::is || root == Root::sudo; }
};
std::optional<BoardFacts> parse_board(const MarkedText& text);

/// One file that goes to the board.
struct DeployFile {
  std::string from, name;  // path here; path on the board, below the folder of the version
  bool executable = false;
  std::string text{};  // sent in place of the file's content; empty: the content is sent
};

struct DeployFiles {
  std::vector<DeployFile> files{};  // the program first, then the robot file
  std::string robot{};              // name of the robot file there
  std::string calibration{};        // name of the calibration file there; empty: the robot has none beside it
  std::vector<std::string> notes{};
};
/// The program, with libsinew_libcamera.so where a device needs it; the robot file, its calibration, and each file that
/// the robot file names: a value of a module or device that is the relative path of an existing file beside the robot
/// file.
DeployFiles files_of(const RobotFile& robot, const std::string& program);

/// Why this robot cannot run on a board: it has a simulated or recorded device. Empty: it can.
std::string refuse_simulated(const RobotFile& robot);

/// Why this cannot go to that board; empty: it can. `as_root`: to install a unit.
std::string refuse_board(const BoardFacts& board, const ElfTarget& target, std::uint64_t bytes, bool as_root);

}  // namespace sinew::app
