#include "apps/completion.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "apps/command/command.hpp"

namespace sinew::app {
namespace {

// The command that the words before the unfinished one select, and the values that it still needs.
struct Position {
  const CLI::App* command;
  const CLI::Option* awaits_value = nullptr;  // the last word is an option that takes one
  std::size_t positionals = 0;                // already given
  std::string robot{};                        // value of --robot
};

const CLI::App* subcommand(const CLI::App& command, const std::string& name) {
  const auto found = command.get_subcommands([&](const CLI::App* sub) { return sub->get_name() == name; });
  return found.empty() ? nullptr : found.front();
}

Position walk(const CLI::App& app, const std::vector<std::string>& words) {
  Position at{&app};
  for (std::size_t i = 0; i + 1 < words.size(); ++i) {
    const std::string& word = words[i];
    if (at.awaits_value) {
      if (at.awaits_value->get_name() == "--robot") at.robot = word;
      at.awaits_value = nullptr;
    } else if (word.starts_with("-")) {
      const CLI::Option* option = at.command->get_option_no_throw(word);
      if (option && option->get_expected_max() > 0) at.awaits_value = option;
    } else if (const CLI::App* sub = subcommand(*at.command, word)) {
      at.command = sub;
    } else {
      ++at.positionals;
    }
  }
  return at;
}

std::vector<std::string> values_of(const CLI::Option& option, const Position& at, const NamesOf& names_of) {
  const std::string hint = option.get_type_name();
  if (hint == kRobotFileHint) return {":file .toml"};
  if (hint == kFileHint) return {":file"};
  if (hint == kFolderHint) return {":folder"};
  if (!hint.starts_with("{")) return names_of(hint, at.robot);
  return CLI::detail::split(hint.substr(1, hint.size() - 2), ',');
}

std::vector<std::string> candidates(const Position& at, const std::string& word, const NamesOf& names_of) {
  if (at.awaits_value) return values_of(*at.awaits_value, at, names_of);
  std::vector<std::string> all;
  std::size_t position = 0;
  for (const CLI::Option* option : at.command->get_options()) {
    if (word.starts_with("-")) {
      for (const auto& name : option->get_lnames()) all.push_back("--" + name);
    } else if (option->get_positional()) {
      const bool several = option->get_expected_max() > 1;  // such as the files of `bag merge`
      if (position == at.positionals || (several && position < at.positionals)) return values_of(*option, at, names_of);
      ++position;
    }
  }
  if (!word.starts_with("-"))
    for (const CLI::App* sub : at.command->get_subcommands({})) all.push_back(sub->get_name());
  return all;
}

}  // namespace

std::vector<std::string> completions(const CLI::App& app, const std::vector<std::string>& words,
                                     const NamesOf& names_of) {
  if (words.empty()) return {};
  std::vector<std::string> fitting;
  for (auto& candidate : candidates(walk(app, words), words.back(), names_of))
    if (candidate.starts_with(':') || candidate.starts_with(words.back())) fitting.push_back(std::move(candidate));
  return fitting;
}

std::string bash_completion(const std::string& program) {
  return fmt::format(R"(# Completion of {0} for bash: source <({0} completion bash)
_{0}() {{
  local line word=${{COMP_WORDS[COMP_CWORD]}}
  COMPREPLY=()
  while IFS= read -r line; do
    case $line in
      ":folder") mapfile -t -O "${{#COMPREPLY[@]}}" COMPREPLY < <(compgen -d -- "$word") ;;
      ":file") mapfile -t -O "${{#COMPREPLY[@]}}" COMPREPLY < <(compgen -f -- "$word") ;;
      ":file "*)
        mapfile -t -O "${{#COMPREPLY[@]}}" COMPREPLY < <(compgen -f -X "!*${{line#:file }}" -- "$word"; compgen -d -S / -- "$word")
        compopt -o nospace 2>/dev/null
        ;;
      *) COMPREPLY+=("$line") ;;
    esac
  done < <("${{1/#\~/$HOME}}" {1} "${{COMP_WORDS[@]:1:COMP_CWORD}}" 2>/dev/null)
}}
complete -F _{0} {0}
)",
                     program, kCompleteCommand);
}

}  // namespace sinew::app
