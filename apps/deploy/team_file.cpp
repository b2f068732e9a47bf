#include "apps/deploy/team_file.hpp"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "apps/toml/toml_reader.hpp"

namespace sinew::app {
namespace {

/// The name of a folder, and nothing that leads elsewhere.
bool is_plain(const std::string& name) {
  const auto fits = [](unsigned char c) { return std::isalnum(c) || c == '_' || c == '-'; };
  return !name.empty() && std::ranges::all_of(name, fits);
}

}  // namespace

TeamFile load_team_file(const std::string& path) {
  TeamFile team;
  std::ifstream in(path, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  if (!in) {
    team.problems.push_back({0, "", path, "a file that can be read"});
    return team;
  }
  const auto table = parse_toml(text.str(), path, team.problems);
  if (!table) return team;
  const std::filesystem::path beside = std::filesystem::path(path).parent_path();
  TomlReader root(*table, "", team.problems);
  root.tables_by_name("robot", [&](const std::string& name, TomlReader& r) {
    TeamBoard board;
    board.name = name;
    r.require("host", board.host, "user@board, as ssh knows it; it is required");
    r.require("file", board.file, "the path of a robot file; it is required");
    r.read("binary", board.binary);
    r.finish();
    if (!is_plain(name)) team.problems.push_back({r.line(), r.path(), name, "a name of letters, digits, '_' and '-'"});
    if (board.host.starts_with('-'))
      team.problems.push_back({r.line(), r.full("host"), board.host, "user@board, as ssh knows it"});
    if (std::ranges::find(team.boards, board.host, &TeamBoard::host) != team.boards.end() && !board.host.empty())
      team.problems.push_back({r.line(), r.full("host"), board.host, "another board for each robot"});
    if (!board.file.empty()) board.file = (beside / board.file).string();
    if (!board.binary.empty()) board.binary = (beside / board.binary).string();
    team.boards.push_back(std::move(board));
  });
  root.finish();
  if (team.boards.empty() && team.problems.empty())
    team.problems.push_back({0, "robot", "", "a table [robot.NAME] for each robot, with host and file"});
  std::ranges::sort(team.boards, {}, &TeamBoard::name);
  return team;
}

}  // namespace sinew::app
