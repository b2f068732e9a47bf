#include "apps/deploy/deploy_plan.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <filesystem>

#include "apps/robot_file/calibration.hpp"
#include "hal/linux/camera/libcamera_plugin.hpp"
#include "hal/linux/system_files.hpp"

namespace sinew::app {
namespace {

namespace fs = std::filesystem;

struct Machine {
  std::uint16_t elf;
  bool wide;
  const char* name;
  std::array<std::string_view, 6> kernels;  // beginnings of the output of uname -m
};
// Source: elf.h (EM_...); arch/*/Makefile and uname of the kernels.
constexpr Machine kMachines[] = {
    {62, true, "x86_64", {"x86_64"}},    {3, false, "i386", {"i386", "i486", "i586", "i686", "x86_64"}},
    {183, true, "aarch64", {"aarch64"}}, {40, false, "arm", {"armv", "aarch64"}},
    {8, false, "mips", {"mips"}},        {8, true, "mips64", {"mips64"}},
    {243, true, "riscv64", {"riscv64"}}, {243, false, "riscv32", {"riscv32"}}};

const Machine* machine_of(const ElfTarget& target) {
  for (const auto& m : kMachines)
    if (m.elf == target.machine && m.wide == target.wide) return &m;
  return nullptr;
}

BoardFacts::Root root_of(std::string_view answer) {
  if (answer == "yes") return BoardFacts::Root::is;
  if (answer == "sudo") return BoardFacts::Root::sudo;
  return answer == "password" ? BoardFacts::Root::password : BoardFacts::Root::no;
}

void take_fact(std::string_view key, const std::string& value, BoardFacts& b) {
  std::uint64_t kib = 0;
  if (key == "dir") b.folder = value;
  if (key == "machine") b.machine = value;
  if (key == "user") b.user = value;
  if (key == "writes") b.writes = value == "yes";
  if (key == "root") b.root = root_of(value);
  if (key == "tar") b.tar = true;
  if (key == "systemd") b.systemd = true;
  if (key == "free_kib" && std::from_chars(value.data(), value.data() + value.size(), kib).ec == std::errc())
    b.free_bytes = kib * 1024;
  if (key == "cpus") b.cpus = hal::cpu_list(value);
  if (key == "group") b.groups.push_back(value);
}

/// A relative path that stays below its folder.
bool stays_below(const fs::path& path) {
  return !path.empty() && path.is_relative() && std::find(path.begin(), path.end(), "..") == path.end();
}

class FileList {
 public:
  FileList(const RobotFile& robot, const std::string& program) : beside_(fs::path(robot.path).parent_path()) {
    list_.robot = fs::path(robot.path).filename().string();
    list_.files.push_back({program, "bin/sinew", true});
    list_.files.push_back({robot.path, list_.robot, false, robot.extended ? robot.text : std::string()});
  }
  void calibration(const RobotFile& robot) {
    const fs::path named = robot.calibration.value;
    if (named.empty()) return;
    if (!stays_below(named)) {
      list_.notes.push_back(named.string() + ": the calibration is not beside the robot file: not copied");
      return;
    }
    list_.calibration = named.lexically_normal().string();
    if (!add(named)) list_.notes.push_back(named.string() + ": there is no calibration yet");
  }
  void network(const std::string& named) {
    if (!add(named)) list_.notes.push_back(named + ": the network is not beside the robot file: not copied");
  }
  /// Adds the library for cameras of libcamera, from the place where the program itself would load it.
  void libcamera(const std::string& program) {
    const std::string name = std::string("bin/") + hal::kLibcameraPluginFile;
    std::error_code none;
    const auto same = [&](const DeployFile& f) { return f.name == name; };
    if (std::any_of(list_.files.begin(), list_.files.end(), same)) return;
    const auto paths = hal::libcamera_plugin_paths(program);
    for (const std::string& path : paths)
      if (fs::is_regular_file(path, none)) return list_.files.push_back({path, name, false});
    list_.notes.push_back(paths.front() +
                          ": there is no such file, and the driver libcamera needs it: build it where libcamera-dev is "
                          "installed");
  }
  void value(const rt::ParamValue& value) {
    if (const auto* text = std::get_if<std::string>(&value)) add(*text);
  }
  void device(const drivers::DeviceSpec& spec) {
    for (const auto& key : spec.keys) value(key.second.value);
    for (const auto& joint : spec.joints) device(joint);
  }
  DeployFiles take() { return std::move(list_); }

 private:
  bool add(const fs::path& named) {
    std::error_code none;
    if (!stays_below(named) || !fs::is_regular_file(beside_ / named, none)) return false;
    const std::string name = named.lexically_normal().string();
    const auto same = [&](const DeployFile& f) { return f.name == name; };
    if (std::any_of(list_.files.begin(), list_.files.end(), same)) return true;
    const auto mode = fs::status(beside_ / named, none).permissions();
    list_.files.push_back(
        {(beside_ / named).string(), name, !none && (mode & fs::perms::owner_exec) != fs::perms::none});
    return true;
  }

  fs::path beside_;
  DeployFiles list_;
};

std::string mib(std::uint64_t bytes) { return fmt::format("{} MiB", (bytes + (1 << 20) - 1) >> 20); }

}  // namespace

std::optional<ElfTarget> elf_target(std::span<const unsigned char> head) {
  if (head.size() < 20 || head[0] != 0x7f || head[1] != 'E' || head[2] != 'L' || head[3] != 'F') return std::nullopt;
  if (head[4] < 1 || head[4] > 2 || head[5] < 1 || head[5] > 2) return std::nullopt;
  ElfTarget target{0, head[4] == 2, head[5] == 2};
  const unsigned low = head[target.big_endian ? 19 : 18], high = head[target.big_endian ? 18 : 19];
  target.machine = static_cast<std::uint16_t>(high << 8 | low);
  return target;
}

std::string to_text(const ElfTarget& target) {
  const Machine* m = machine_of(target);
  return fmt::format("{}, {} bit{}", m ? m->name : fmt::format("machine {}", target.machine), target.wide ? 64 : 32,
                     target.big_endian ? ", big-endian" : "");
}

bool fits(const ElfTarget& target, std::string_view machine) {
  const Machine* m = machine_of(target);
  // All kernels named here are little-endian, except MIPS: "mips" names both byte orders.
  if (!m || (target.big_endian && target.machine != 8)) return false;
  return std::any_of(m->kernels.begin(), m->kernels.end(),
                     [&](std::string_view k) { return !k.empty() && machine.starts_with(k); });
}

std::optional<BoardFacts> parse_board(const MarkedText& text) {
  const auto facts = text.after("board");
  if (!facts) return std::nullopt;
  BoardFacts board;
  each_line(*facts, [&](std::string_view line) {
    if (const auto equals = line.find('='); equals != std::string_view::npos)
      take_fact(line.substr(0, equals), std::string(line.substr(equals + 1)), board);
  });
  if (board.machine.empty() || board.folder.empty()) return std::nullopt;
  return board;
}

DeployFiles files_of(const RobotFile& robot, const std::string& program) {
  FileList list(robot, program);
  list.calibration(robot);
  for (const PolicyTable& p : robot.policies) list.network(p.file->path);
  for (const auto& module : robot.graph.modules)
    for (const auto& param : module.params) list.value(param.second.value);
  for (const auto& device : robot.devices.devices) {
    list.device(device);
    if (device.driver == "libcamera") list.libcamera(program);
  }
  for (const auto& bus : robot.devices.buses) list.device(bus);
  return list.take();
}

std::string refuse_simulated(const RobotFile& robot) {
  const auto elsewhere = [](const std::string& board) { return board == "sim" || board == "dataset"; };
  if (elsewhere(robot.graph.board))
    return fmt::format(
        "robot.board: \"{}\": on a robot's own computer it is \"linux\", with a table [device.NAME] for each device: "
        "write "
        "it, or deploy with --board linux",
        robot.graph.board);
  for (const auto& [device, board] : robot.graph.device_boards)
    if (elsewhere(board.value))
      return fmt::format("robot.device_boards.{}: \"{}\": on a robot's own computer there is none", device,
                         board.value);
  return {};
}

std::string refuse_board(const BoardFacts& board, const ElfTarget& target, std::uint64_t bytes, bool as_root) {
  if (!fits(target, board.machine))
    return fmt::format("the program is for {}, the board is {}: build it for the board and name it with --binary FILE",
                       to_text(target), board.machine);
  if (!board.tar) return "the board has no tar";
  if (as_root && !board.systemd) return "--unit: the board does not run systemd";
  const char* const how = board.root == BoardFacts::Root::password
                              ? "sudo asks for a password there: permit it without one, or log in as root"
                              : "log in as root, or have sudo there";
  if (as_root && !board.can_be_root())
    return fmt::format("--unit: permission denied: {} may not become root on the board; {}", board.user, how);
  if (!board.writes && board.root == BoardFacts::Root::is)
    return fmt::format(
        "{}: cannot be written even by root: is the file system mounted read-only? (mount -o remount,rw)",
        board.folder);
  if (!board.writes && !board.can_be_root())
    return fmt::format("{}: permission denied for {}: name another folder with --dir DIR; or {}", board.folder,
                       board.user, how);
  constexpr std::uint64_t kSpare = 8 << 20;
  if (board.free_bytes && *board.free_bytes < bytes + kSpare)
    return fmt::format("{}: the disk is full: {} are free, {} are needed", board.folder, mib(*board.free_bytes),
                       mib(bytes + kSpare));
  return {};
}

}  // namespace sinew::app
