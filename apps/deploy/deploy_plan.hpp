#pragma once
// `sinew deploy`, thought through without touching anything: what is copied, whether it fits, and what went wrong.
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "apps/deploy/board_shell.hpp"
#include "apps/robot_file/robot_file.hpp"

namespace sinew::app {

/// For which machine a program was built.
struct ElfTarget {
  std::uint16_t machine = 0;  // EM_...
  bool wide = false;          // 64 bit
  bool big_endian = false;
};

/// From the first bytes of a program; nothing when it is none. Source: System V ABI, chapter 4, "ELF Header".
std::optional<ElfTarget> elf_target(std::span<const unsigned char> head);
/// "aarch64, 64 bit".
std::string to_text(const ElfTarget& target);
/// Whether a kernel that says `machine` (uname -m) can run it at all. A 64-bit kernel may run its 32-bit programs, too:
/// that its libraries are there only a try on the board shows.
bool fits(const ElfTarget& target, std::string_view machine);

/// What apps/deploy/probe.sh tells.
struct BoardFacts {
  enum class Root : std::uint8_t { is, sudo, password, no };
  std::string folder, machine, user;
  bool writes = false;  // this login may write the folder
  Root root = Root::no;
  bool tar = false, systemd = false;
  std::optional<std::uint64_t> free_bytes{};
  std::vector<int> cpus{};
  std::vector<std::string> groups{};  // of devices, that it has

  bool can_be_root() const { return root == Root::is || root == Root::sudo; }
};
std::optional<BoardFacts> parse_board(const MarkedText& text);

/// One file that goes to the board.
struct DeployFile {
  std::string from, name;  // here; there, below the folder of the version
  bool executable = false;
  std::string text{};  // what is sent in place of the file's content; empty: that
};

struct DeployFiles {
  std::vector<DeployFile> files{};  // the program first, then the robot file
  std::string robot{};              // name of the robot file there
  std::string calibration{};        // name of the calibration file there; empty: the robot has none beside it
  std::vector<std::string> notes{};
};
/// The program, with libsinew_libcamera.so where a device needs it; the robot file, its calibration, and every file
/// beside it that it names: values of modules and devices that are relative paths of existing files.
DeployFiles files_of(const RobotFile& robot, const std::string& program);

/// Why this robot has nothing to run with on a board: a device of it is simulated, or recorded. Empty: it has.
std::string refuse_simulated(const RobotFile& robot);

/// Why this cannot go to that board; empty: it can. `as_root`: a unit is installed.
std::string refuse_board(const BoardFacts& board, const ElfTarget& target, std::uint64_t bytes, bool as_root);

}  // namespace sinew::app
