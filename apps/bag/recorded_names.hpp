#pragma once
#include <string>
#include <string_view>
#include <vector>

namespace sinew::app {

/// Names of one kind (a hint of apps/command/command.hpp) in a recorded file: topics, modules, fields of `topic` or,
/// where it is empty, of all ("TOPIC.FIELD"). Empty when the file cannot be read.
std::vector<std::string> recorded_names(std::string_view hint, const std::string& file, const std::string& topic);

}  // namespace sinew::app
