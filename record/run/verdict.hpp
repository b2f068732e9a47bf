#pragma once
// Can the steps of a module be executed again from a file, and if not, why? The recorder answers at its end, and
// run_review.hpp answers from the file.
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "msg/time.hpp"

namespace sinew::record {

/// Losses of a topic's messages or of a thread's steps.
struct Losses {
  std::uint64_t count = 0;
  msg::Time first;  // about: the last time before the loss
  void add(std::uint64_t n, msg::Time at) {
    if (count == 0) first = at;
    count += n;
  }
};

/// Says whether the steps of a module can be executed again from the file.
struct ModuleVerdict {
  std::string module;
  std::vector<std::string> reasons{};  // why not; none: replayable
  std::optional<msg::Time> from{};     // behind the saved state of this time; nothing: from the beginning
};
/// For a file that begins midway: replayable from the first saved state after which every input is in the file.
void begins_at(ModuleVerdict& verdict, std::optional<msg::Time> state);

/// Metadata of files that begin in the middle of a run. At the beginning: time and orders. At the end, by module: the
/// time of the saved state where its replay can begin.
inline constexpr std::string_view kBeginName = "sinew.begin", kFromName = "sinew.from";

/// The part of a topic that a file keeps.
struct TopicKept {
  std::string name;
  bool wanted = true;      // recorded at all
  double rate_hz = 0;      // at most; 0: all
  bool held_only = false;  // only the messages that a recorded step held
  Losses lost, without_pixels;
};

/// True if a message at this time is one of those kept at a rate; `next` stores the earliest time of the next one.
bool due(msg::Time& next, double rate_hz, msg::Time at);

/// `source`: the module takes messages from outside; `steps`: losses of its thread's steps.
std::vector<std::string> reasons(bool source, const Losses& steps, std::span<const TopicKept* const> inputs);

/// In the metadata "sinew.run" of a file that has not the steps of all threads: those whose it has, by spaces.
inline constexpr std::string_view kThreadsKey = "recorded_threads";
/// Why modules of a thread whose steps are not recorded cannot be executed again.
std::string not_recorded(std::string_view thread);

std::string to_text(const ModuleVerdict& verdict);            // "replayable", "replayable from 1.500 s on", reasons
std::string to_text(const Losses& losses, const char* what);  // "3 messages from 1.500 s on"
std::string seconds_text(msg::Time t);                        // "1.500 s"

}  // namespace sinew::record
