// deploy: a robot's program, file and unit to its board; its recorded runs back.
#include "apps/deploy/deploy_command.hpp"

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <cstdio>
#include <filesystem>
#include <fstream>

#include "apps/command/choice_check.hpp"
#include "apps/deploy/board_link.hpp"
#include "apps/deploy/commands.hpp"
#include "apps/deploy/deploy_failure.hpp"
#include "apps/deploy/deploy_plan.hpp"
#include "apps/deploy/tar_source.hpp"
#include "apps/deploy/unit_text.hpp"
#include "apps/robot/robot_check.hpp"
#include "hal/linux/process.hpp"

namespace sinew::app {
namespace {

constexpr const char* kUnits = "/etc/systemd/system";

void print_indented(std::string_view text) {
  each_line(text, [](std::string_view line) { std::printf("  %.*s\n", static_cast<int>(line.size()), line.data()); });
}

std::optional<ElfTarget> target_of(const std::string& program) {
  std::ifstream in(program, std::ios::binary);
  unsigned char head[20] = {};
  in.read(reinterpret_cast<char*>(head), sizeof head);
  return in ? elf_target(head) : std::nullopt;
}

/// Prints the problems of the robot file; true if there are none. With --binary only the board can check the modules.
bool passes(LoadedRobot& loaded, const DeployOptions& o, const rt::ModuleTypes& types) {
  if (loaded.problems.empty() && o.binary.empty())
    loaded.problems = rt::Graph(loaded.robot.graph, types).check(check_options(loaded.robot));
  for (const auto& p : loaded.problems) std::fprintf(stderr, "%s\n", to_string(p, loaded.robot).c_str());
  return loaded.problems.empty();
}

class Deployment {
 public:
  Deployment(const DeployOptions& o, const RobotFile& robot) : o_(o), robot_(robot), link_(o.ssh, o.host) {}

  /// Asks for the board's facts; the exit code when that fails.
  std::optional<int> look() {
    const auto answer = link_.ask({.script = "probe", .arguments = {o_.folder}});
    if (!answer) return fail(link_.problem());
    if (answer->code != 0) return fail(explain_failure(answer->code, answer->errors, o_.host, o_.folder));
    const auto board = parse_board(MarkedText(answer->out));
    if (!board) return fail(o_.host + ": the board's shell does not answer as a POSIX shell does");
    board_ = *board;
    as_root_ = o_.unit || !board_.writes;
    std::printf("board: %s, %s as %s%s\n", board_.machine.c_str(), board_.folder.c_str(), board_.user.c_str(),
                as_root_ && board_.root == BoardFacts::Root::sudo ? " by sudo" : "");
    return std::nullopt;
  }

  std::optional<int> copy(const DeployFiles& files, const ElfTarget& target) {
    std::uint64_t bytes = 0;
    std::string names;
    for (const auto& file : files.files) {
      std::error_code error;
      const auto size = std::filesystem::file_size(file.from, error);
      if (error) return fail(file.from + ": " + error.message());
      bytes += size;
      names += (names.empty() ? "" : ", ") + file.name;
    }
    if (const std::string why = refuse_board(board_, target, bytes, o_.unit); !why.empty())
      return fail(o_.host + ": " + why);
    for (const auto& note : files.notes) std::printf("note: %s\n", note.c_str());
    std::printf("copying %.1f MiB: %s\n", static_cast<double>(bytes) / (1 << 20), names.c_str());
    std::fflush(stdout);
    TarSource tar(files.files);
    const auto answer =
        link_.ask({.script = "copy",
                   .arguments = {board_.folder, files.robot, files.calibration, about(files.robot), o_.board},
                   .root = as_root_,
                   .input = [&] { return tar.next(); }});
    if (!answer) return fail(link_.problem(), kFailed);
    if (!tar.failure().empty()) return fail(tar.failure(), kFailed);
    return say_copied(*answer);
  }

  std::optional<int> finish(const DeployFiles& files) {
    const std::string unit = o_.unit ? unit_name(robot_) : "";
    std::string text = o_.unit ? unit_text(robot_, unit_options(files)) : "";
    const auto answer = link_.ask(
        {.script = "finish",
         .arguments = {board_.folder, files.robot, data(), unit, kUnits, o_.user, o_.start ? "yes" : "no", o_.board},
         .root = as_root_,
         .input = [&, sent = false]() mutable -> std::string_view {
           return sent ? std::string_view() : (sent = true, std::string_view(text));
         }});
    if (!answer) return fail(link_.problem(), kFailed);
    const MarkedText said(answer->out);
    if (const auto doctor = said.after("doctor")) std::printf("doctor:\n"), print_indented(*doctor);
    if (const auto user = said.word_after("user-made")) std::printf("user %s made\n", user->c_str());
    if (const auto enabled = said.word_after("enabled"))
      std::printf("%s is enabled: it starts with the board\n", enabled->c_str());
    if (const auto status = said.after("status")) print_indented(*status);
    if (answer->code != 0) return fail(explain_failure(answer->code, answer->errors, o_.host, board_.folder), kFailed);
    if (said.word_after("started")) std::printf("%s runs\n", unit.c_str());
    if (!o_.unit)
      std::printf("to run it there: mkdir -p %s && cd %s && %s/app/bin/sinew run %s/app/%s%s\n", data().c_str(),
                  data().c_str(), board_.folder.c_str(), board_.folder.c_str(), files.robot.c_str(),
                  board_argument(o_.board).c_str());
    return std::nullopt;
  }

  int rollback() {
    const bool root = !board_.writes;
    if (root && !board_.can_be_root())
      return fail(fmt::format("{}: permission denied for {}", board_.folder, board_.user));
    const auto answer = link_.ask({.script = "rollback", .arguments = {board_.folder}, .root = root});
    if (!answer) return fail(link_.problem(), kFailed);
    if (answer->code != 0) return fail(explain_failure(answer->code, answer->errors, o_.host, board_.folder), kFailed);
    const MarkedText said(answer->out);
    const std::string version = said.word_after("deployed").value_or("?");
    std::printf("%s is in force again: %s", version.c_str(), said.after("deployed " + version).value_or("\n").c_str());
    std::printf("a running robot keeps the version that it was started from\n");
    return kDone;
  }

  UnitOptions unit_options(const DeployFiles& files) const {
    return {board_.folder, files.robot, data(), o_.user, board_.cpus, board_.groups, o_.board};
  }

 private:
  std::string data() const { return o_.data.empty() ? board_.folder + "/data" : o_.data; }
  static std::string about(const std::string& robot) { return fmt::format("sinew {}, {}", version(), robot); }

  std::optional<int> say_copied(const BoardLink::Answer& answer) {
    const MarkedText said(answer.out);
    const std::string loader = said.after("libraries").value_or("");
    if (answer.code == static_cast<int>(BoardStep::start)) {
      std::string missing;
      for (const auto& library : missing_libraries(loader)) missing += "\n  " + library;
      if (!missing.empty()) return fail("the board lacks these libraries:" + missing, kFailed);
      if (const std::string old = too_old_library(loader); !old.empty())
        return fail("the program was built for a newer system than the board's: " + old, kFailed);
    }
    if (const auto check = said.after("check")) std::printf("check:\n"), print_indented(*check);
    if (answer.code != 0) return fail(explain_failure(answer.code, answer.errors, o_.host, board_.folder), kFailed);
    if (said.after("calibration kept")) std::printf("the board's own calibration stays\n");
    const auto version = said.word_after("deployed");
    if (!version) return fail(o_.host + ": the board did not say that it is done", kFailed);
    std::printf("%s/app is %s now; --rollback goes back\n", board_.folder.c_str(), version->c_str());
    return std::nullopt;
  }

  const DeployOptions& o_;
  const RobotFile& robot_;
  BoardLink link_;
  BoardFacts board_;
  bool as_root_ = false;
};

/// What is wrong with the options; empty: nothing.
std::string refuse_options(const DeployOptions& o) {
  if (o.host.empty() || o.host.front() == '-') return "user@board: a host as ssh knows it";
  if (o.robot.empty() && !o.rollback) return "deploy: a robot file is required";
  if (o.start && !o.unit) return "--start: only with --unit";
  if (o.folder.empty()) return "--dir: a folder on the board";
  return {};
}

}  // namespace

int deploy_command(const DeployOptions& o, const rt::ModuleTypes& types) {
  if (const std::string why = refuse_options(o); !why.empty()) return fail(why);
  LoadedRobot loaded;
  if (o.rollback) {
    Deployment there(o, loaded.robot);
    if (const auto code = there.look()) return *code;
    return there.rollback();
  }
  loaded = load_robot(o.robot);
  if (!o.board.empty()) loaded.robot.graph.board = o.board;
  if (!passes(loaded, o, types)) return kNotBegun;
  if (const std::string why = refuse_simulated(loaded.robot); !why.empty()) return fail(o.robot + ": " + why);
  const std::string program = o.binary.empty() ? hal::program_path() : o.binary;
  const DeployFiles files = files_of(loaded.robot, program);
  UnitOptions unit{o.folder, files.robot, o.data.empty() ? o.folder + "/data" : o.data, o.user};
  unit.board = o.board;
  if (o.unit || o.print_unit)
    if (const std::string why = refuse_unit(unit); !why.empty()) return fail("--unit: " + why);
  if (o.print_unit) {
    unit.groups = {"video", "dialout"};  // that every Debian has
    {
      std::fputs(unit_text(loaded.robot, unit).c_str(), stdout);
      return kDone;
    }
  }
  const auto target = target_of(program);
  if (!target) return fail(program + ": is no program that can be read (ELF)");
  Deployment there(o, loaded.robot);
  if (const auto code = there.look()) return *code;
  if (const auto code = there.copy(files, *target)) return *code;
  return there.finish(files).value_or(kDone);
}

void add_deploy_command(CLI::App& app, CommandContext& context) {
  const auto o = std::make_shared<DeployOptions>();
  const auto into = std::make_shared<std::string>();
  CLI::App& deploy = *app.add_subcommand("deploy", "bring a robot to its board over ssh, or its recorded runs back");
  deploy.add_option("host", o->host, "user@board, as ssh knows it; or TEAM.toml: all robots of a team")
      ->required()
      ->type_name("HOST");
  deploy.add_option("robot", o->robot, "robot file; not for a team, --fetch and --rollback")->type_name(kRobotFileHint);
  deploy.add_option("--dir", o->folder, "folder on the board")->capture_default_str()->type_name("DIR_THERE");
  deploy.add_option("--data", o->data, "folder on the board for recorded runs (default: data in the folder of --dir)")
      ->type_name("DIR_THERE");
  deploy.add_option("--binary", o->binary, "program for the board, such as a cross-built one; default: this one")
      ->type_name(kFileHint);
  deploy.add_option("--ssh", o->ssh, "how to reach it: \"ssh -p 2222\"")->capture_default_str()->type_name("COMMAND");
  deploy.add_option("--board", o->board, "it runs there with this board instead of the file's")
      ->type_name("{linux,none}")
      ->check(one_of({"linux", "none"}));
  CLI::Option* unit = deploy.add_flag("--unit", o->unit, "install and enable the robot's systemd unit");
  deploy.add_flag("--start", o->start, "start it, where the doctor finds no problem")->needs(unit);
  deploy.add_option("--user", o->user, "user under which the unit runs")->capture_default_str();
  CLI::Option* print = deploy.add_flag("--print-unit", o->print_unit, "print the unit; the board is not asked");
  CLI::Option* rollback = deploy.add_flag("--rollback", o->rollback, "go back to the previous version");
  CLI::Option* fetch = deploy.add_option("--fetch", *into, "bring recorded runs back, into this folder (default: .)")
                           ->expected(0, 1)
                           ->type_name(kFolderHint);
  deploy.add_flag("--replay", o->replay, "then execute every run of that folder again, and compare")->needs(fetch);
  fetch->excludes(unit)->excludes(print)->excludes(rollback);
  rollback->excludes(unit)->excludes(print);
  deploy.callback([&context, o, into, fetch] {
    if (fetch->count() > 0) o->fetch = into->empty() ? "." : *into;
    context.action = [&types = context.types, o] {
      if (is_team_file(o->host)) return deploy_team(*o, types);
      if (!o->fetch) return deploy_command(*o, types);
      const int code = fetch_command(*o);
      return code == kDone && o->replay ? replay_runs(*o->fetch) : code;
    };
  });
}

}  // namespace sinew::app
