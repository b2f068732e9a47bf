// deploy --fetch: recorded runs from a board.
#include <fmt/format.h>

#include <cstdio>

#include "apps/command/command.hpp"
#include "apps/deploy/board_link.hpp"
#include "apps/deploy/board_shell.hpp"
#include "apps/deploy/deploy_command.hpp"
#include "apps/deploy/deploy_failure.hpp"
#include "apps/deploy/fetch_runs.hpp"
#include "apps/robot_file/robot_file.hpp"

namespace sinew::app {
namespace {

/// Folders of runs and of faults, below the folder in which the robot runs.
std::vector<std::string> folders_of(const RobotFile& robot) {
  std::vector<std::string> folders;
  for (const std::string& folder : {robot.record.folder, robot.parent.save_to})
    if (!folder.empty() && folder.front() != '/') folders.push_back(folder);
  return folders;
}

int fetch_parts(BoardLink& link, const DeployOptions& o, const std::vector<std::string>& place, const FetchPlan& plan) {
  FetchSink sink(plan, *o.fetch);
  std::string request = request_text(plan);
  const auto answer = link.ask({.script = "get",
                                .arguments = place,
                                .input = [&, sent = false]() mutable -> std::string_view {
                                  return sent ? std::string_view() : (sent = true, std::string_view(request));
                                },
                                .output = [&](std::string_view bytes) { sink.take(bytes); }});
  if (!answer) return fail(link.problem(), kFailed);
  std::printf("%zu files fetched, %.1f MiB\n", sink.files_done(), static_cast<double>(sink.bytes_done()) / (1 << 20));
  if (answer->code != 0) return fail(explain_failure(answer->code, answer->errors, o.host, place[0]), kFailed);
  if (const std::string why = sink.failure(); !why.empty()) return fail(why, kFailed);
  return kDone;
}

}  // namespace

int fetch_command(const DeployOptions& o) {
  if (o.host.empty() || o.host.front() == '-') return fail("user@board: a host as ssh knows it");
  LoadedRobot loaded;
  if (!o.robot.empty()) {
    loaded = load_robot(o.robot);
    for (const auto& p : loaded.problems) std::fprintf(stderr, "%s\n", to_string(p, loaded.robot).c_str());
    if (!loaded.problems.empty()) return kNotBegun;
  }
  BoardLink link(o.ssh, o.host);
  const std::vector<std::string> place{o.folder, o.data};
  std::vector<std::string> arguments = place;
  for (auto& folder : folders_of(loaded.robot)) arguments.push_back(std::move(folder));
  const auto listed = link.ask({.script = "list", .arguments = arguments});
  if (!listed) return fail(link.problem());
  const std::string data = o.data.empty() ? o.folder + "/data" : o.data;
  if (listed->code != 0) return fail(explain_failure(listed->code, listed->errors, o.host, data));
  const MarkedText said(listed->out);
  const auto now = said.word_after("files");
  if (!now) return fail(o.host + ": the board's shell does not answer as a POSIX shell does");
  const BoardListing listing = parse_listing(*now, said.after("files " + *now).value_or(""));
  for (const auto& line : listing.problems) std::fprintf(stderr, "sinew: not a file of a run: %s\n", line.c_str());
  const FetchPlan plan = plan_fetch(listing, *o.fetch);
  for (const auto& run : plan.recording) std::printf("%s is being recorded: left for the next time\n", run.c_str());
  for (const auto& file : plan.different)
    std::fprintf(stderr, "sinew: %s is here with another size: left alone\n", file.c_str());
  std::printf("%zu files are here already, %zu to fetch, %.1f MiB\n", plan.here, plan.parts.size(),
              static_cast<double>(plan.bytes) / (1 << 20));
  std::fflush(stdout);
  const int code = plan.parts.empty() ? kDone : fetch_parts(link, o, place, plan);
  return code == kDone && !(plan.different.empty() && listing.problems.empty()) ? kFailed : code;
}

}  // namespace sinew::app
