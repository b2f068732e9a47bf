#include "apps/run/run_command.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>

#include "apps/command/command.hpp"
#include "apps/robot/board_rules.hpp"
#include "apps/robot/doctor.hpp"
#include "apps/run/dataset_run.hpp"
#include "apps/run/device_run.hpp"
#include "apps/run/net_process.hpp"
#include "apps/run/run_setup.hpp"
#include "apps/run/sim_run.hpp"
#include "hal/linux/process.hpp"

namespace sinew::app {
namespace {

/// Leaves no file behind: the run may not begin, or end early. False: errno says why.
bool can_be_written(const std::string& path) {
  std::error_code ignored;  // a path that cannot be examined cannot be opened either
  const bool existed = std::filesystem::exists(path, ignored);
  std::FILE* file = std::fopen(path.c_str(), "a");
  if (!file || std::fclose(file) != 0) return false;
  return existed || std::remove(path.c_str()) == 0;
}

}  // namespace

int run_command(const RunOptions& options, const rt::ModuleTypes& types) {
  static_cast<void>(hal::stop_requested());  // from here on a signal only asks for the end
  hal::end_at_second_signal(
      "\nsinew: ended at once by a second signal; the end of the recording may be missing (`sinew bag recover`)\n");
  if (!options.virtual_time) hal::outlive_terminal();
  for (const std::string& file : {options.trace, options.plot})  // better now than after the flight
    if (!file.empty() && !can_be_written(file)) return fail(file + ": " + std::strerror(errno));
  auto prepared = prepare(options, types);
  if (!prepared) return 2;
  const std::string& board = prepared->graph->spec().board;
  const auto problems = check_boards(prepared->graph->spec(), {options.virtual_time, options.real_actuators});
  for (const auto& p : problems) std::fprintf(stderr, "%s\n", prepared->options.told(p, prepared->robot).c_str());
  if (!problems.empty()) return 2;
  const bool from_folder = board == "dataset" && !needs_plant(prepared->graph->spec());
  if (!options.plot.empty() && !from_folder)
    return fail(fmt::format(
        "--plot {}: only for a run on a recorded folder (board \"dataset\"); {}", options.plot,
        needs_plant(prepared->graph->spec()) ? "this run has a plant" : "this run has the board \"" + board + "\""));
  if (!options.virtual_time && !doctor_permits_start(*prepared->graph, prepared->robot, options.strict)) return 2;
  if (!take_name(*prepared, options)) return 2;
  const auto net = start_net(*prepared, options);
  if (needs_plant(prepared->graph->spec())) return run_on_sim(*prepared, options);
  return board == "dataset" ? run_on_dataset(*prepared, options) : run_on_devices(*prepared, options);
}

}  // namespace sinew::app
