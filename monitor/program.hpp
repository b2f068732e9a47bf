#pragma once
#include <atomic>
#include <chrono>
#include <functional>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "hal/linux/process.hpp"

namespace sinew::monitor {

/// What a program left behind.
struct ProgramEnd {
  std::optional<int> exit_code{};  // nothing: it was ended by us, or did not start
  std::string output{}, errors{};
  std::string why{};  // not empty: it did not start, took too long, said too much, or was ended
};

struct ProgramLimits {
  std::chrono::milliseconds patience{10'000};
  std::size_t most_bytes = 4 << 20;  // of what it prints
};

/// Runs argv[0] (a path) to its end, or ends it at a limit or when `stop` becomes true (within kStopLook).
/// Thread:  any that may wait, never the server's.
ProgramEnd run_program(const std::vector<std::string>& argv, const ProgramLimits& limits, const std::atomic<bool>& stop,
                       const std::function<void(int pid)>& started = {});
inline constexpr std::chrono::milliseconds kStopLook{100};

/// The same on a thread of its own.
/// Thread:  the owner's.
class Program {
 public:
  /// `on_end` is called once, by the program's thread.
  Program(std::vector<std::string> argv, ProgramLimits limits, std::function<void(ProgramEnd)> on_end);
  /// Ends the program, and waits for that unless on_end() was called.
  ~Program();
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  /// Asks the program to end; on_end() follows.
  void end() { stop_.store(true); }
  /// 0: it has not started.
  int pid() const { return pid_.load(); }

 private:
  std::atomic<bool> stop_{false};
  std::atomic<int> pid_{0};
  std::thread thread_;
};

/// Why it left nothing that is of use: by us, by the last line of its errors, or by its exit code.
std::string reason(const ProgramEnd& end);

}  // namespace sinew::monitor
