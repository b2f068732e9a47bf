#pragma once
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "hal/file.hpp"
#include "record/problem.hpp"
#include "record/run/verdict.hpp"

namespace sinew::record {

/// The file that the parts of a flight ring go to.
struct DumpFile {
  std::string path{};  // for reports
  std::function<hal::Result<std::unique_ptr<hal::OutputFile>>()> open{};
  /// Opens the file as written so far, for reading.
  std::function<hal::Result<std::unique_ptr<hal::InputFile>>()> written{};
};

struct Dumped {
  std::uint64_t messages = 0, bytes = 0;
  std::vector<ModuleVerdict> verdict{};
  std::vector<FileProblem> problems{};  // parts that could not be read
};

/// Makes one recording of the parts of a ring, oldest first. The beginning is that of the first part, content that a
/// later part repeats is written once, and the verdict is that of the whole. The last part may be unfinished: its
/// writer may be dead. `reason` ("deadline miss") goes into the metadata "sinew.dump".
/// Thread:  owner, an ordinary one; takes its time and memory of a few chunks.
/// Errors:  not_found when the parts are empty (then there is no file); those of the file.
hal::Status dump_ring(std::span<const std::span<const std::byte>> parts, const DumpFile& to, const std::string& reason,
                      std::uint64_t free_floor_bytes, Dumped& result);

}  // namespace sinew::record
