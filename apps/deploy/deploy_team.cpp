// deploy TEAM.toml: the same for each robot of a team.
#include <fmt/format.h>

#include <cstdio>
#include <filesystem>

#include "apps/command/command.hpp"
#include "apps/deploy/deploy_command.hpp"
#include "apps/deploy/team_file.hpp"

namespace sinew::app {
namespace {

const char* end_of(int code) { return code == kDone ? "done" : code == kFailed ? "failed" : "not begun"; }

}  // namespace

bool is_team_file(const std::string& host) { return host.ends_with(".toml"); }

int deploy_team(const DeployOptions& o, const rt::ModuleTypes& types) {
  if (!o.robot.empty()) return fail(o.host + " names the robot files: one more is not taken");
  const TeamFile team = load_team_file(o.host);
  for (const auto& p : team.problems) std::fprintf(stderr, "%s\n", rt::to_string(p, o.host).c_str());
  if (!team.problems.empty()) return kNotBegun;
  std::string table;
  bool begun = false, done = true;
  for (const TeamBoard& board : team.boards) {
    std::printf("== %s on %s\n", board.name.c_str(), board.host.c_str());
    std::fflush(stdout);
    DeployOptions own = o;
    own.host = board.host;
    if (!o.rollback) own.robot = board.file;
    if (!board.binary.empty()) own.binary = board.binary;
    if (o.fetch) {
      own.fetch = (std::filesystem::path(*o.fetch) / board.name).string();
      std::error_code failed;
      std::filesystem::create_directories(*own.fetch, failed);
      if (failed) return fail(fmt::format("{}: {}", *own.fetch, failed.message()), begun ? kFailed : kNotBegun);
    }
    int code = o.fetch ? fetch_command(own) : deploy_command(own, types);
    if (code == kDone && o.fetch && o.replay) code = replay_runs(*own.fetch);
    table += fmt::format("{:16} {:24} {}\n", board.name, board.host, end_of(code));
    begun = begun || code != kNotBegun;
    done = done && code == kDone;
  }
  std::printf("\n%s", table.c_str());
  return done ? kDone : begun ? kFailed : kNotBegun;
}

}  // namespace sinew::app
