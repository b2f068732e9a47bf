#include "apps/robot/board_rules.hpp"

#include <algorithm>
#include <array>

#include "hal/did_you_mean.hpp"

namespace sinew::app {
namespace {

constexpr std::array<BoardKind, 4> kBoards{
    {{"sim", false, true}, {"linux", true, true}, {"dataset", false, false}, {"none", false, false}}};

class BoardCheck {
 public:
  BoardCheck(const rt::GraphSpec& robot, const BoardUse& use, std::span<const BoardKind> boards)
      : robot_(robot), use_(use), boards_(boards) {}

  std::vector<rt::Problem> all() {
    known("robot.board", robot_.board, robot_.board_line);
    for (const auto& [device, board] : robot_.device_boards) known(key(device), board.value, board.line);
    if (!problems_.empty()) return std::move(problems_);
    no_real_device_in_virtual_time();
    actuators_on_boards_that_have_some();
    real_actuators_with_permission();
    the_plant_is_the_board();
    no_real_device_beside_a_record();
    return std::move(problems_);
  }

 private:
  static std::string key(const std::string& device) { return "robot.device_boards." + device; }
  const BoardKind* kind(std::string_view name) const {
    const auto it = std::find_if(boards_.begin(), boards_.end(), [&](const auto& b) { return b.name == name; });
    return it == boards_.end() ? nullptr : &*it;
  }
  bool is_actuator(const std::string& device) const {
    return std::any_of(robot_.actuators.begin(), robot_.actuators.end(),
                       [&](const auto& a) { return a.name == device; });
  }
  void problem(int line, std::string key, const std::string& value, std::string allowed) {
    problems_.push_back({line, std::move(key), '"' + value + '"', std::move(allowed)});
  }

  void known(std::string key, const std::string& board, int line) {
    if (kind(board)) return;
    std::vector<std::string> names;
    for (const BoardKind& b : boards_) names.emplace_back(b.name);
    problem(line, std::move(key), board, hal::quoted(names) + hal::did_you_mean(board, names));
  }
  void no_real_device_in_virtual_time() {
    if (!use_.virtual_time) return;
    constexpr auto kAllowed = "a simulated or recorded board: in virtual time no real device waits for a grant";
    if (kind(robot_.board)->real) problem(robot_.board_line, "robot.board", robot_.board, kAllowed);
    for (const auto& [device, board] : robot_.device_boards)
      if (kind(board.value)->real) problem(board.line, key(device), board.value, kAllowed);
  }
  void actuators_on_boards_that_have_some() {
    for (const auto& [device, board] : robot_.device_boards)
      if (is_actuator(device) && !kind(board.value)->actuators)
        problem(board.line, key(device), board.value, "a board with actuators, as [actuator." + device + "] needs one");
  }
  void real_actuators_with_permission() {
    if (use_.real_actuators) return;
    std::string simulated;  // boards whose sensors do not show what real actuators do
    if (!kind(robot_.board)->real) simulated = "all other devices: " + robot_.board;
    for (const auto& [device, board] : robot_.device_boards)
      if (!is_actuator(device) && !kind(board.value)->real)
        simulated += (simulated.empty() ? "" : ", ") + device + ": " + board.value;
    if (simulated.empty()) return;
    for (const auto& a : robot_.actuators)
      if (kind(board_of(robot_, a.name))->real)
        problem(a.line, "actuator." + a.name, board_of(robot_, a.name),
                "real actuators with simulated sensors (" + simulated + ") only with --real-actuators");
  }
  void the_plant_is_the_board() {
    for (const auto& [device, board] : robot_.device_boards)
      if (board.value == "sim" && robot_.board != "sim" && !kind(robot_.board)->real)
        problem(board.line, key(device), board.value,
                "robot.board = \"sim\" with other boards per device: one plant, one source of time");
  }

  void no_real_device_beside_a_record() {
    if (kind(robot_.board)->real || robot_.board == "sim") return;
    for (const auto& [device, board] : robot_.device_boards)
      if (kind(board.value)->real)
        problem(board.line, key(device), board.value,
                "a real robot.board with the others named per device: a run ends with its own board");
  }

  const rt::GraphSpec& robot_;
  const BoardUse& use_;
  std::span<const BoardKind> boards_;
  std::vector<rt::Problem> problems_;
};

}  // namespace

const std::string& board_of(const rt::GraphSpec& robot, const std::string& device) {
  const auto it = robot.device_boards.find(device);
  return it == robot.device_boards.end() ? robot.board : it->second.value;
}

bool needs_plant(const rt::GraphSpec& robot) {
  return robot.board == "sim" || std::any_of(robot.device_boards.begin(), robot.device_boards.end(),
                                             [](const auto& device) { return device.second.value == "sim"; });
}

std::span<const BoardKind> known_boards() { return kBoards; }

std::vector<rt::Problem> check_boards(const rt::GraphSpec& robot, const BoardUse& use,
                                      std::span<const BoardKind> boards) {
  return BoardCheck(robot, use, boards).all();
}

std::string unfelt_fault(const rt::GraphSpec& robot, const std::string& fault) {
  const std::string device = fault.substr(0, fault.find(':'));
  const std::string& board = board_of(robot, device);
  const auto uses_radio = [](const rt::ModuleSpec& m) {
    return m.type == "team::Link" || m.type == "drivers::RadioSource";
  };
  if (device == "radio" && std::none_of(robot.modules.begin(), robot.modules.end(), uses_radio))
    return "--fault: '" + fault + "' strikes a radio, and this robot has none: its file has no [team]";
  if (device == "link" || board == "sim") return "";
  return "--fault: '" + fault + "' strikes the simulator's " + device + ", and this run has it from the board " + board;
}

}  // namespace sinew::app
