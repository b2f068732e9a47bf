#pragma once
#include <chrono>
#include <cstdint>
#include <string>

namespace sinew::app {

/// How far long work is, on standard error; nothing where that is no terminal.
/// Thread:  owner.
class Progress {
 public:
  /// `shown` false: says nothing, as where other output goes to the same terminal.
  explicit Progress(std::string what, bool shown = true);
  ~Progress();  // takes the line away again
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
