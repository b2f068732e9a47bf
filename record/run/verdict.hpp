#pragma once
// Whether the steps of a module can be executed again from a file, and why not: as the recorder knows it when it ends,
// and as run_review.hpp finds it in the file.
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "msg/time.hpp"

namespace sinew::record {

/// What is not in the file, of a topic or of a thread's steps.
struct Losses {
  std::uint64_t count = 0;
  msg::Time first;  // about: of what came before it
  void add(std::uint64_t n, msg::Time at) {
    if (count == 0) first = at;
    count += n;
  }
};

/// Whether the steps of a module can be executed again from the file.
struct ModuleVerdict {
  std::string module;
  std::vector<std::string> reasons{};  // why not; none: replayable
  std::optional<msg::Time> from{};     // behind the saved state of this time; nothing: from the beginning
};
/// Of a file that begins midway: from the first saved state behind which every input is in the file.
void begins_at(ModuleVerdict& verdict, std::optional<msg::Time> state);

/// Metadata of files that begin in the middle of a run: time and orders of the beginning; at the end, by module, the
/// time of the saved state where it can be replayed from.
inline constexpr std::string_view kBeginName = "sinew.begin", kFromName = "sinew.from";

/// What a file has of a topic.
struct TopicKept {
  std::string name;
  bool wanted = true;  // recorded at all
  double rate_hz = 0;  // at most; 0: all
  Losses lost, without_pixels;
};

/// Whether a message at this time is one of those that are kept at a rate; `next` is the memory of it.
bool due(msg::Time& next, double rate_hz, msg::Time at);

/// `source`: it takes what comes from outside; `steps`: what is lost of its thread's.
std::vector<std::string> reasons(bool source, const Losses& steps, std::span<const TopicKept* const> inputs);

std::string to_text(const ModuleVerdict& verdict);            // "replayable", "replayable from 1.500 s on", reasons
std::string to_text(const Losses& losses, const char* what);  // "3 messages from 1.500 s on"
std::string seconds_text(msg::Time t);                        // "1.500 s"

}  // namespace sinew::record
