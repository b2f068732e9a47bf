#include "apps/robot_file/extends.hpp"

#include "apps/robot_file/ini_files.hpp"
#include "apps/toml/toml_guard.hpp"

namespace sinew::app {
namespace {

bool names_other_files(const toml::table& robot) {
  return robot.contains("extends") || robot["body"]["extends"] || robot["motions"]["extends"] || names_ini_file(robot);
}

}  // namespace

ResolvedRobot resolve_robot(std::string_view text, const std::string& path) {
  ResolvedRobot resolved;
  resolved.text = text;
  if (line_beyond_ascii(text) != 0) return resolved;  // the parser of the text reports it
  const toml::parse_result parsed = toml::parse(text, path);
  if (!parsed || !names_other_files(parsed.table())) return resolved;
  TomlResolver resolver;
  const auto all = resolver.merged(resolved.text, path);
  std::vector<IniProblem> ini_problems;
  const bool whole = all && resolver.merge_below(*all, "body") && resolver.merge_below(*all, "motions");
  if (whole) {
    read_ini_files(*all, resolver.elsewhere(), ini_problems);
    resolver.write(*all, "# " + path + " with all that it extends", path);
    resolved.extended = true;
    resolved.text = std::move(resolver.result().text);
  }
  resolved.problems = std::move(resolver.result().problems);
  resolved.places = std::move(resolver.result().places);
  for (IniProblem& p : ini_problems) {
    resolved.places.push_back(p.at);
    p.problem.line = static_cast<int>(resolved.places.size());
    resolved.ini_problems.push_back(std::move(p.problem));
  }
  return resolved;
}

}  // namespace sinew::app
