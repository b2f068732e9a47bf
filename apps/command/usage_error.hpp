#pragma once
#include <string>

namespace CLI {
class App;
class ParseError;
}  // namespace CLI

namespace sinew::app {

/// What is wrong with a command line, in one sentence without the program's name. A command or option that does not
/// exist comes with the one that it resembles: "--viritual: no such option; sinew run --help lists them; did you mean
/// --virtual?".
/// Thread:  owner, after app.parse() has thrown `error`.
std::string usage_error(const CLI::App& app, const CLI::ParseError& error);

/// "flyy: no such command; sinew --help lists them; did you mean fly?", of the commands of `app`.
std::string no_such_command(const CLI::App& app, const std::string& name);

}  // namespace sinew::app
