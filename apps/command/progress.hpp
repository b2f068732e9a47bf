#pragma once
#include <chrono>
#include <cstdint>
#include <string>

namespace sinew::app {

/// Shows the progress of long work on standard error; nothing if that is no terminal.
/// Thread:  owner.
class Progress {
 public:
  /// `shown` false: prints nothing, for example when other output goes to the same terminal.
  explicit Progress(std::string what, bool shown = true);
  ~Progress();  // erases the line
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  void expect(std::uint64_t more) { total_ += more; }
  void add(std::uint64_t done);

 private:
  const std::string what_;
  const bool shown_;
  bool drawn_ = false;
  std::uint64_t done_ = 0, total_ = 0;
  std::chrono::steady_clock::time_point next_;  // to draw
};

/// "check [#####     ]  52 %"
std::string progress_text(const std::string& what, std::uint64_t done, std::uint64_t total);

}  // namespace sinew::app
