// deploy --fetch --replay: what the robots did, executed again here.
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <vector>

#include "apps/command/command.hpp"
#include "apps/deploy/deploy_command.hpp"
#include "hal/linux/process.hpp"

namespace sinew::app {

namespace fs = std::filesystem;

int replay_runs(const std::string& folder) {
  std::vector<fs::path> runs;
  std::error_code failed;
  for (fs::recursive_directory_iterator file(folder, failed), end; !failed && file != end; file.increment(failed))
    if (file->path().filename() == "run.mcap") runs.push_back(file->path());
  if (failed) return fail(folder + ": " + failed.message(), kFailed);
  if (runs.empty()) return fail(folder + ": there is no run.mcap to execute again", kFailed);
  std::ranges::sort(runs);
  std::size_t same = 0;
  for (const fs::path& run : runs) {
    std::printf("%s: ", run.c_str());
    std::fflush(stdout);
    const auto child = hal::ChildProcess::start({hal::program_path(), "replay", run.string()});
    if (!child) return fail("sinew replay did not start", kFailed);
    std::optional<int> code;
    while (!code) code = (*child)->wait(std::chrono::seconds(1));
    same += *code == kDone ? 1 : 0;
    if (*code > 128) std::printf("%s\n", hal::describe_exit(*code).c_str());
  }
  std::printf("%zu of %zu runs are identical\n", same, runs.size());
  return same == runs.size() ? kDone : kFailed;
}

}  // namespace sinew::app
