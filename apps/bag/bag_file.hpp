#pragma once
// Recorded files, for the commands that read and write them.
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "apps/command/progress.hpp"
#include "record/reader.hpp"
#include "record/writer.hpp"

namespace sinew::app {

/// Null after printing why. Reading the file counts as progress; `passes`: how often the command reads all of it.
std::unique_ptr<hal::InputFile> open_input(const std::string& path, Progress& progress, unsigned passes = 1);
std::unique_ptr<record::Reader> open_recording(const std::string& path, Progress& progress, unsigned passes = 1);

/// The paths without those that lead to a file once more, as runs/*/run.mcap does with runs/latest.
std::vector<std::string> each_file_once(const std::vector<std::string>& paths);

/// A new file, as hal::create_file(); null after printing why.
std::unique_ptr<hal::OutputFile> create_output(const std::string& path);

/// An error of a file in words: "FILE: No space left on device".
std::string file_error(const std::string& path, const hal::Error& error);

/// Prints the problems of a file on standard error; of many problems only the first ones.
void say_problems(const std::string& path, const std::vector<record::FileProblem>& problems);

/// Which messages a command uses.
struct Selection {
  std::vector<std::string> topics{};
  std::optional<double> from_s{}, until_s{};  // after the first message of the file
};
/// Why these seconds of a recording cannot be meant, or empty: they end before they begin, or lie beyond its end.
std::string window_problem(record::Reader& reader, std::optional<double> from_s, std::optional<double> until_s);

/// Nothing after printing why: a topic or a time that the file does not have.
std::optional<record::Query> query_of(record::Reader& reader, const Selection& selection);

/// Calls f(message) for all of them in the order of log time, until f returns false or Ctrl-C. False, after printing
/// the problems: some could not be read.
bool each_message(record::Reader& reader, const record::Query& query,
                  const std::function<bool(const record::Message&)>& f);

std::uint64_t end_time(const record::Reader& reader);

/// How often messages of a channel came between its first and its last one; 0 with fewer than two.
double channel_rate_hz(record::Reader& reader, const record::Channel& channel);

}  // namespace sinew::app
