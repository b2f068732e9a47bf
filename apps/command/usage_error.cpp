#include "apps/command/usage_error.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "hal/did_you_mean.hpp"

namespace sinew::app {
namespace {

/// "sinew bag cut"
std::string path_of(const CLI::App& command) {
  const CLI::App* parent = command.get_parent();
  return (parent ? path_of(*parent) + " " : std::string()) + command.get_name();
}

/// The first word that no command took, and the command that was asked to take it.
struct Unknown {
  const CLI::App* command = nullptr;
  std::string word{};
};

Unknown unknown_word(const CLI::App& app) {
  for (const CLI::App* parsed : app.get_subcommands())
    if (Unknown deeper = unknown_word(*parsed); deeper.command) return deeper;
  for (const std::string& word : app.remaining()) {
    if (word == "--") continue;
    if (app.get_prefix_command() && !word.starts_with('-')) break;  // from here on they are another program's
    return {&app, word};
  }
  return {};
}

const CLI::App& asked_for(const CLI::App& app) {
  const auto parsed = app.get_subcommands();
  return parsed.empty() ? app : asked_for(*parsed.front());
}

std::string no_such_option(const CLI::App& command, const std::string& word) {
  std::vector<std::string> names;
  for (const CLI::Option* option : command.get_options()) {
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
    for (const std::string& name : option->get_snames()) names.push_back("-" + name);
  }
  const std::string name = word.substr(0, word.find('='));
  return fmt::format("{}: no such option; {} --help lists them{}", name, path_of(command),
                     hal::did_you_mean(name, names));
}

}  // namespace

std::string no_such_command(const CLI::App& app, const std::string& name) {
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands({})) names.push_back(command->get_name());
  return fmt::format("{}: no such command; {} --help lists them{}", name, path_of(app), hal::did_you_mean(name, names));
}

std::string usage_error(const CLI::App& app, const CLI::ParseError& error) {
  const Unknown unknown = unknown_word(app);
  if (!unknown.command) {
    const bool missing = dynamic_cast<const CLI::RequiredError*>(&error) != nullptr;
    return missing ? fmt::format("{}; {} --help says more", error.what(), path_of(asked_for(app))) : error.what();
  }
  if (unknown.word.starts_with('-')) return no_such_option(*unknown.command, unknown.word);
  if (!unknown.command->get_subcommands({}).empty()) return no_such_command(*unknown.command, unknown.word);
  if (unknown.word.ends_with(".mcap"))
    return fmt::format("{}: {} takes one recording; name one, such as runs/latest/run.mcap", unknown.word,
                       path_of(*unknown.command));
  return fmt::format("{}: one argument too many; {} --help lists what it takes", unknown.word,
                     path_of(*unknown.command));
}

}  // namespace sinew::app
