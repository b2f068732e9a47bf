#pragma once
#include <cstddef>
#include <span>
#include <string>
#include <string_view>

namespace sinew::app {

/// Saves a runtime's memory of topics into a new folder under `folder`, named by robot and time (UTC): fault.json has
/// the fault, messages.jsonl every message still there in the order of its commits, topics.bin the memory itself.
/// Returns the folder; empty, with `why`, when nothing could be written. Messages that cannot be read are left out,
/// since the memory comes from a process that died.
std::string save_last_seconds(const std::string& folder, std::string_view robot, std::string_view fault,
                              std::span<const std::byte> memory, std::string& why);

}  // namespace sinew::app
