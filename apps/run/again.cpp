#include "apps/run/again.hpp"

#include <fmt/format.h>

#include "apps/sweep/case_text.hpp"

namespace sinew::app {

std::string sweep_line(const Prepared& prepared, const RunOptions& options) {
  const bool of_own = options.board.empty() && options.board_of.empty() && options.plant.empty() &&
                      prepared.robot.sim.plant == "auto" && prepared.graph->spec().board != "dataset";
  if (!options.virtual_time || !of_own) return {};
  std::vector<std::string> words{"sinew", "sweep", options.robot, "--seeds",
                                 std::to_string(prepared.graph->spec().seed)};
  if (!options.params.empty()) words.insert(words.end(), {"--params", options.params});
  for (const std::string& set : options.set) {
    if (set.find_first_of(",:", set.find('=')) != std::string::npos) return {};  // there it means several values
    words.insert(words.end(), {"--set", set});
  }
  // Alternatives of a sweep are separate runs; these strike in one.
  if (!options.faults.empty())
    words.insert(words.end(), {"--fault", fmt::format("{}", fmt::join(options.faults, "&"))});
  if (!options.camera.empty()) words.insert(words.end(), {"--camera", options.camera});
  if (options.duration_s > 0) words.insert(words.end(), {"--duration", fmt::format("{}", options.duration_s)});
  for (const std::string& argument : options.plant_args) words.push_back("--plant-arg=" + argument);
  return sweep::joined(words);
}

}  // namespace sinew::app
