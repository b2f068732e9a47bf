#pragma once
// A program that is run to its end while we feed it and listen to it. For apps; nothing here is for a step.
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "hal/result.hpp"

namespace sinew::hal {

struct PipedIo {
  /// The next piece of its standard input, valid until the next call; empty: that was all. None: it has no input.
  std::function<std::string_view()> input{};
  /// What it writes, as it comes. None: it goes where ours goes.
  std::function<void(std::string_view)> output{}, errors{};
};

/// Runs argv[0], looked for in PATH when it is no path, and waits for its end: its exit code, 128 + signal when it was
/// killed. Input that it does not want to read is dropped; it gets SIGTERM when we die.
/// Thread:  any one at a time: SIGPIPE is ignored in this process meanwhile.
/// Errors:  not_found, denied: there is no such program; io.
Result<int> run_piped(const std::vector<std::string>& argv, const PipedIo& io);

}  // namespace sinew::hal
