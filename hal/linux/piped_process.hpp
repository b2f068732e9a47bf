#pragma once
// Runs a program to its end, with its input and output. For apps; nothing here is for a step.
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "hal/result.hpp"

namespace sinew::hal {

struct PipedIo {
  /// The next piece of its standard input, valid until the next call; empty: the end. None: it has no input.
  std::function<std::string_view()> input{};
  /// Receives its output as it comes. None: its output goes where ours goes.
  std::function<void(std::string_view)> output{}, errors{};
};

/// Runs argv[0], looked for in PATH when it is no path, and waits for its end: its exit code, 128 + signal when it was
/// killed. Input that the program does not read is dropped; the program gets SIGTERM when we die.
/// Thread:  any one at a time: SIGPIPE is ignored in this process meanwhile.
/// Errors:  not_found, denied: there is no such program; io.
Result<int> run_piped(const std::vector<std::string>& argv, const PipedIo& io);

}  // namespace sinew::hal
