#include "apps/robot_file/world_options.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

#include "apps/robot_file/param_value.hpp"
#include "apps/toml/toml_reader.hpp"
#include "hal/did_you_mean.hpp"
#include "robots/robot_kind.hpp"

namespace sinew::app {
namespace {

constexpr std::string_view kSim = "sim.", kSeed = "seed";

std::vector<std::string> keys_of(const plant::WorldInfo& world) {
  std::vector<std::string> keys;
  for (const plant::WorldOption& o : world.options) keys.emplace_back(o.key);
  return keys;
}

std::string joined(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& w : words) text += (text.empty() ? "" : " ") + w;
  return text;
}

/// The world that has this option, other than `world`; null: none has.
const plant::WorldInfo* other_world_with(std::string_view key, std::string_view world) {
  for (const robots::RobotKind& robot : robots::all_robots())
    if (robot.world.name != world && robot.world.find_option(key)) return &robot.world;
  return nullptr;
}

std::string of_another_world(const plant::WorldInfo& other, const plant::WorldInfo& own) {
  const std::string keys = joined(keys_of(own));
  return fmt::format("an option of the world {}; the world {} has {}", other.name, own.name,
                     keys.empty() ? "none" : keys);
}

std::string set_option(SimTable& sim, const plant::WorldInfo& world, const std::string& key, const std::string& value) {
  const plant::WorldOption* option = world.find_option(key);
  if (!option) {
    if (const plant::WorldInfo* other = other_world_with(key, world.name)) return of_another_world(*other, world);
    auto keys = keys_of(world);
    keys.emplace_back(kSeed);
    return fmt::format("--set takes of [sim] what its world offers, and the seed: {}{}", joined(keys),
                       hal::did_you_mean(key, keys));
  }
  const rt::ParamValue given = param_value(value);
  const auto* whole = std::get_if<std::int64_t>(&given);
  const auto* real = std::get_if<double>(&given);
  const double number = whole ? static_cast<double>(*whole) : real ? *real : 0.0;
  if (!(whole || real) || !option->allows(number)) return option->allowed();
  sim.options[key] = number;
  return {};
}

std::string set_seed(SimTable& sim, const std::string& value) {
  std::int64_t seed = -1;
  const auto end = value.data() + value.size();
  const auto read = std::from_chars(value.data(), end, seed);
  if (read.ec != std::errc() || read.ptr != end || seed < 0) return fmt::format("an integer from 0 to {}", INT64_MAX);
  sim.seed = static_cast<std::uint64_t>(seed);
  return {};
}

/// The value that an argument of the plant gives to an option, "--gust=3" or "--gust 3"; the last one counts.
std::optional<std::string> argument_of(const std::vector<std::string>& arguments, const std::string& option) {
  std::optional<std::string> value;
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    if (arguments[i].starts_with(option + "=")) value = arguments[i].substr(option.size() + 1);
    if (arguments[i] == option && i + 1 < arguments.size()) value = arguments[i + 1];
  }
  return value;
}

}  // namespace

void read_world_options(TomlReader& r, SimTable& sim) {
  std::int64_t seed = 0;
  if (r.read(kSeed, seed, 0, INT64_MAX)) sim.seed = static_cast<std::uint64_t>(seed);
  const plant::WorldInfo* world = robots::find_world(sim.world);
  if (!world) {  // a problem already: its options are not known
    for (const robots::RobotKind& robot : robots::all_robots())
      for (const plant::WorldOption& o : robot.world.options)
        if (r.has(o.key)) static_cast<void>(r.take(o.key));
    return;
  }
  for (const plant::WorldOption& o : world->options) {
    const toml::node* node = r.take(o.key);
    if (!node) continue;
    const auto number = node->is_number() ? node->value<double>() : std::nullopt;
    if (number && o.allows(*number))
      sim.options[o.key] = *number;
    else
      r.problem(*node, o.key, o.allowed());
  }
  for (const auto& [key, node] : r.raw()) {
    const plant::WorldInfo* other = world->find_option(key.str()) ? nullptr : other_world_with(key.str(), world->name);
    if (!other) continue;
    static_cast<void>(r.take(key.str()));
    r.problem(node, key.str(), of_another_world(*other, *world));
  }
}

std::optional<std::string> apply_sim_setting(SimTable& sim, const std::string& setting) {
  const auto equals = setting.find('=');
  if (!setting.starts_with(kSim) || equals == std::string::npos || equals < kSim.size()) return std::nullopt;
  const std::string key = setting.substr(kSim.size(), equals - kSim.size()), value = setting.substr(equals + 1);
  const auto refuse = [&](const std::string& why) { return fmt::format("--set {}: {}", setting, why); };
  const plant::WorldInfo* world = robots::find_world(sim.world);
  if (!world) return refuse("sinew knows no world " + sim.world);
  if (key != kSeed && sim.plant != "auto")
    return refuse("only a plant that this run starts itself (plant \"auto\") takes it; another has options of its own");
  const std::string why = key == kSeed ? set_seed(sim, value) : set_option(sim, *world, key, value);
  return why.empty() ? why : refuse(why);
}

std::uint64_t world_seed(const RobotFile& robot) { return robot.sim.seed.value_or(robot.graph.seed); }

std::vector<std::string> world_arguments(const SimTable& sim) {
  std::vector<std::string> arguments;
  const plant::WorldInfo* world = robots::find_world(sim.world);
  if (!world) return arguments;
  for (const plant::WorldOption& o : world->options)
    if (const auto it = sim.options.find(o.key); it != sim.options.end()) {
      // In one word: a value below 0 alone would look like an option.
      arguments.push_back(fmt::format("--{}={}", o.option, it->second));
    }
  if (!sim.body_file.empty()) arguments.push_back("--body=" + sim.body_file);
  return arguments;
}

std::map<std::string, std::string> world_choices(const SimTable& sim, const std::vector<std::string>& arguments) {
  std::map<std::string, std::string> choices;
  if (const auto seed = argument_of(arguments, "--seed")) choices["seed"] = *seed;
  const plant::WorldInfo* const world = robots::find_world(sim.world);
  if (!world) return choices;
  for (const plant::WorldOption& o : world->options) {
    const auto given = sim.options.find(o.key);
    std::string value = o.value ? fmt::format("{}", *o.value) : o.otherwise;
    if (given != sim.options.end()) value = fmt::format("{}", given->second);
    if (const auto argued = argument_of(arguments, fmt::format("--{}", o.option))) value = *argued;
    choices[o.key] = value;
  }
  return choices;
}

std::vector<std::string> world_settings(const std::string& world) {
  std::vector<std::string> settings;
  const plant::WorldInfo* known = robots::find_world(world);
  for (const robots::RobotKind& robot : robots::all_robots()) {
    if (known && &robot.world != known) continue;
    for (const std::string& key : keys_of(robot.world))
      if (const std::string text = std::string(kSim) + key + "=";
          std::find(settings.begin(), settings.end(), text) == settings.end())
        settings.push_back(text);
  }
  settings.push_back(std::string(kSim) + std::string(kSeed) + "=");
  return settings;
}

}  // namespace sinew::app
