#include "apps/replay/recorded_robot.hpp"

#include <algorithm>
#include <charconv>

#include "apps/robot/without_camera.hpp"
#include "apps/robot_file/param_value.hpp"
#include "apps/robot_file/robot_file.hpp"
#include "apps/run/ground_truth_source.hpp"
#include "apps/run/run_metadata.hpp"
#include "rt/graph_check.hpp"

namespace sinew::app {
namespace {

/// Steps are executed again with the network that acted, not with what its file holds now.
bool take_networks(record::Reader& reader, const std::string& file, const RobotFile& robot, std::string& why) {
  if (robot.policies.empty()) return true;
  const auto told = record::read_metadata(reader, std::string(kPoliciesName));
  for (const PolicyTable& p : robot.policies) {
    const std::string name = policy::attachment_name(p.options.name);
    auto bytes = record::read_attachment(reader, name);
    const auto about = told.find(p.options.name);
    if (!bytes || about == told.end()) {
      why = file + ": the network of module " + p.options.name + " is missing (attachment " + name + ")";
      return false;
    }
    p.file->bytes = std::move(*bytes);
    p.file->problem.clear();
    const std::string hash = policy::hash_of(*p.file);
    if (about->second.starts_with(hash + " ")) continue;
    why = file + ": attachment " + name + " is not the network that acted: its hash is " + hash + ", recorded was " +
          about->second;
    return false;
  }
  return true;
}

}  // namespace

std::optional<rt::GraphSpec> written_spec(record::Reader& reader, const std::string& file, std::string& why) {
  const auto text = record::read_attachment(reader, "robot.toml");
  if (!text) {
    why = "the file holds no run of Sinew";
    return std::nullopt;
  }
  LoadedRobot loaded = parse_robot(*text, file + ": robot.toml");
  for (const auto& p : loaded.problems) why += to_string(p, loaded.robot) + "\n";
  if (!loaded.problems.empty() || !take_networks(reader, file, loaded.robot, why)) return std::nullopt;
  return std::move(loaded.robot.graph);
}

std::optional<rt::GraphSpec> recorded_spec(record::Reader& reader, const std::string& file, std::string& why) {
  const auto run = record::read_metadata(reader, "sinew.run");
  auto written = written_spec(reader, file, why);
  if (!written) return std::nullopt;
  if (!run.contains("seed")) {
    why = "the file holds no run of Sinew";
    return std::nullopt;
  }
  rt::GraphSpec& spec = *written;
  const std::string& seed = run.at("seed");
  std::from_chars(seed.data(), seed.data() + seed.size(), spec.seed);

  const auto modules = record::read_metadata(reader, "sinew.modules");
  const auto ran = [&](const std::string& name) {
    return std::any_of(modules.begin(), modules.end(), [&](const auto& m) { return m.second == name; });
  };
  if (ran(std::string(rt::kGroundTruth))) add_ground_truth(spec);  // the run added it, not the robot file
  if (std::any_of(spec.modules.begin(), spec.modules.end(),
                  [&](const auto& m) { return m.type == "drivers::CameraSource" && !ran(m.name); }))
    leave_out_camera(spec);
  for (const auto& param : record::read_metadata(reader, "sinew.params")) {
    const std::string &name = param.first, &value = param.second;
    const bool is_text = value.size() >= 2 && value.front() == '"';
    const auto module = std::find_if(spec.modules.begin(), spec.modules.end(),
                                     [&](const auto& m) { return m.name == name.substr(0, name.find('.')); });
    if (module == spec.modules.end()) continue;  // the guardian has none
    module->params[name.substr(name.find('.') + 1)] = {
        is_text ? rt::ParamValue(value.substr(1, value.size() - 2)) : param_value(value), 0};
  }
  return written;
}

std::unique_ptr<rt::Graph> configured_graph(const rt::GraphSpec& spec, const rt::ModuleTypes& types, hal::Board& board,
                                            const std::string& file, std::string& why) {
  auto graph = std::make_unique<rt::Graph>(spec, types);
  for (const auto& p : graph->check()) why += (why.empty() ? "" : "\n") + rt::to_string(p, file + ": robot.toml");
  if (!why.empty()) return nullptr;
  if (graph->configure(board)) return graph;
  why = file + ": its modules cannot be configured";
  for (const auto& p : graph->configure_problems()) why += "\n" + rt::to_string(p, file + ": robot.toml");
  return nullptr;
}

}  // namespace sinew::app
