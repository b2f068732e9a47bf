#include "apps/run/run_metadata.hpp"

#include <fmt/format.h>

#include <utility>

#include "apps/robot/board_rules.hpp"
#include "apps/robot_file/world_options.hpp"
#include "apps/run/run_setup.hpp"

namespace sinew::app {
namespace {

record::Texts numbered(const std::vector<std::string>& all) {
  record::Texts texts;
  for (std::size_t i = 0; i < all.size(); ++i) texts.emplace(record::number_key(i), all[i]);
  return texts;
}

/// What changed the robot or its world.
std::vector<std::string> options_texts(const RunOptions& options) {
  std::vector<std::string> all;
  const auto add = [&all](const char* option, const std::string& value) {
    if (!value.empty()) all.push_back(fmt::format("{} {}", option, value));
  };
  add("--board", options.board);
  for (const std::string& choice : options.board_of) add("--board-of", choice);
  add("--data", options.data);
  if (options.from_s > 0) add("--from", fmt::format("{}", options.from_s));
  if (options.seed) add("--seed", std::to_string(*options.seed));
  if (options.duration_s > 0) add("--duration", fmt::format("{}", options.duration_s));
  add("--params", options.params);
  for (const std::string& setting : options.set) add("--set", setting);
  add("--plant", options.plant);
  for (const std::string& argument : options.plant_args) add("--plant-arg", argument);
  for (const std::string& fault : options.faults) add("--fault", fault);
  add("--camera", options.camera);
  return all;
}

record::Texts world_texts(const Prepared& prepared, const RunOptions& options) {
  const SimTable& sim = prepared.robot.sim;
  record::Texts texts{{"plant", sim.plant}, {"seed", std::to_string(world_seed(prepared.robot))}};
  if (sim.plant != "auto") return texts;  // its world and its options are its own
  texts["world"] = sim.world;
  texts["camera"] = fmt::format("{}x{}", sim.camera_width, sim.camera_height);
  for (const auto& [key, value] : world_choices(sim, options.plant_args)) texts[key] = value;
  return texts;
}

}  // namespace

std::vector<record::Metadata> run_metadata(const Prepared& prepared, const RunOptions& options) {
  std::vector<record::Metadata> all;
  const auto add = [&all](std::string_view name, record::Texts texts) {
    if (!texts.empty()) all.push_back({std::string(name), std::move(texts)});
  };
  add(kOptionsName, numbered(options_texts(options)));
  if (needs_plant(prepared.graph->spec())) add(kWorldName, world_texts(prepared, options));
  add(kPlantArgumentsName, numbered(options.plant_args));
  add(kFaultsName, numbered(options.faults));
  record::Texts policies;
  for (const PolicyTable& p : prepared.robot.policies)
    policies[p.options.name] = policy::hash_of(*p.file) + " " + p.file->path;
  add(kPoliciesName, std::move(policies));
  return all;
}

record::RunEnd end_of_run(const RunResult& result, const std::string& report, std::uint64_t at) {
  record::RunEnd end;
  end.result["end"] = result.end;
  if (!result.outcome.empty()) end.result["outcome"] = result.outcome;
  if (!result.why.empty()) end.result["why"] = result.why;
  if (result.exit_code) end.result["exit_code"] = std::to_string(*result.exit_code);
  if (!result.timing.empty()) end.result["timing"] = result.timing;
  if (result.ended_s) end.result["ended_s"] = fmt::format("{:.3f}", *result.ended_s);
  if (!report.empty()) end.attachments.push_back({at, at, std::string(kReportFile), "application/json", report});
  return end;
}

}  // namespace sinew::app
