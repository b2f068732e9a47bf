#include "apps/robot_file/param_overlay.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <iterator>

#include "apps/toml/toml_reader.hpp"
#include "hal/did_you_mean.hpp"
#include "rt/parameters.hpp"

namespace sinew::app {
namespace {

void read_module(const std::string& module, TomlReader& r, ParamOverlay& overlay) {
  for (const auto& [key, node] : r.raw()) {
    r.take(key.str());
    OverlayParam p{module, std::string(key.str()), {}, line_of(node)};
    if (read_param_value(node, p.value))
      overlay.params.push_back(std::move(p));
    else
      r.problem(node, key.str(), "a boolean, a number or a string");
  }
}

}  // namespace

std::string toml_value(const rt::ParamValue& value) {
  if (const auto* text = std::get_if<std::string>(&value)) {
    std::string quoted = "\"";
    for (const char c : *text) {
      if (c == '"' || c == '\\') quoted += '\\';
      if (static_cast<unsigned char>(c) < 0x20)
        quoted += fmt::format("\\u{:04X}", static_cast<unsigned>(c));
      else
        quoted += c;
    }
    return quoted + "\"";
  }
  std::string text = rt::to_string(value);
  // A real number must not look like an integer: TOML distinguishes 2.0 and 2.
  if (std::holds_alternative<double>(value) && text.find_first_of(".enN") == std::string::npos) text += ".0";
  return text;
}

ParamOverlay parse_overlay(std::string_view text, const std::string& path) {
  ParamOverlay overlay;
  const auto parsed = parse_toml(text, path, overlay.problems);
  if (!parsed) return overlay;
  for (const auto& [module, node] : *parsed) {
    if (const toml::table* table = node.as_table()) {
      TomlReader reader(*table, std::string(module.str()), overlay.problems);
      read_module(std::string(module.str()), reader, overlay);
    } else {
      overlay.problems.push_back(
          {line_of(node), std::string(module.str()), value_text(node), "[MODULE] with its parameters"});
    }
  }
  std::stable_sort(overlay.params.begin(), overlay.params.end(),
                   [](const auto& a, const auto& b) { return a.line < b.line; });  // toml++ sorts tables by name
  return overlay;
}

ParamOverlay load_overlay(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) return {{}, {{0, "file", path, "a file of parameters that can be read"}}};
  const std::string text((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  return parse_overlay(text, path);
}

std::vector<rt::Problem> apply_overlay(const ParamOverlay& overlay, const rt::ModuleTypes& types, rt::GraphSpec& graph,
                                       int line) {
  std::vector<rt::Problem> problems = overlay.problems;
  for (const auto& p : overlay.params) {
    const std::string key = p.module + "." + p.param, value = rt::to_string(p.value);
    const auto module =
        std::find_if(graph.modules.begin(), graph.modules.end(), [&](const auto& m) { return m.name == p.module; });
    if (module == graph.modules.end()) {
      std::vector<std::string> names;
      for (const auto& m : graph.modules) names.push_back(m.name);
      problems.push_back(
          {p.line, key, value, "no module " + p.module + " in the robot file" + hal::did_you_mean(p.module, names)});
      continue;
    }
    const auto made = types.make(module->type);
    if (!made) continue;  // the robot file's own problem
    rt::Declaration declaration;
    made->declare(declaration);
    const auto* declared = rt::find_param(declaration, p.param);
    if (!declared) {
      std::vector<std::string> names;
      for (const auto& d : declaration.params) names.push_back(d.name);
      problems.push_back(
          {p.line, key, value, "no such parameter of " + module->type + hal::did_you_mean(p.param, names)});
    } else if (!rt::accepts(*declared, p.value)) {
      problems.push_back({p.line, key, value, rt::allowed_values(*declared)});
    } else {
      module->params[p.param] = {p.value, line};
    }
  }
  return problems;
}

std::string overlay_text(std::string_view robot, const std::vector<OverlayParam>& params) {
  std::string out =
      fmt::format("# Parameters of robot {} that differ from its robot file: sinew run ROBOT --params THIS\n", robot);
  std::string module;
  for (const auto& p : params) {
    if (p.module != module) out += fmt::format("\n[{}]\n", p.module);
    module = p.module;
    out += fmt::format("{} = {}\n", p.param, toml_value(p.value));
  }
  return out;
}

}  // namespace sinew::app
