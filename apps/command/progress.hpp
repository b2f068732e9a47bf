#pragma once
#include <cstdint>
#include <string>

#include "hal/clock.hpp"

namespace sinew::app {

/// What is counted: parts (bytes, say) of one file, or cases, which may take days and whose rate is worth knowing.
enum class ProgressOf : std::uint8_t { parts, cases };

struct ProgressState {
  std::string what{};
  ProgressOf of = ProgressOf::parts;
  std::uint64_t total = 0, done = 0;
  std::uint64_t done_before = 0;  // of those done: by an earlier program, which says nothing about the rate
};

/// "check [#####     ]  52 %", and for cases "sweep [#####     ]  52 %  3.1/s  2 min left".
std::string progress_text(const ProgressState& state, hal::Duration elapsed);
/// "sweep: 520 of 1000 cases, 3.1/s, 2 min left"
std::string progress_line(const ProgressState& state, hal::Duration elapsed);

/// When there is what to print of long work. On a terminal one line, drawn again and again; work of less than 0.3 s
/// needs none. Elsewhere, and only of cases, a line each 10 s.
/// Thread:  owner.
class ProgressPrinter {
 public:
  ProgressPrinter(std::string what, ProgressOf of, bool terminal, hal::Time begin);
  void expect(std::uint64_t more) { state_.total += more; }
  void add_before(std::uint64_t done) { state_.done += done, state_.done_before += done; }
  /// What is to be printed now; empty: nothing.
  std::string add(std::uint64_t done, hal::Time now);
  /// What erases a line that stands on the terminal.
  std::string erase();

 private:
  ProgressState state_;
  const bool terminal_;
  bool drawn_ = false;
  const hal::Time begin_;
  hal::Time next_;  // to print
};

/// The same on standard error.
/// Thread:  owner.
class Progress {
 public:
  /// `shown` false: prints nothing, for example when other output goes to the same terminal.
  explicit Progress(std::string what, bool shown = true, ProgressOf of = ProgressOf::parts);
  ~Progress();  // erases the line
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  void expect(std::uint64_t more) { printer_.expect(more); }
  /// Of what is expected: was done by an earlier program.
  void add_before(std::uint64_t done) { printer_.add_before(done); }
  void add(std::uint64_t done);
  /// Before other output, which may go to the same terminal; the next add() may draw the line again.
  void erase();

 private:
  const bool shown_;
  ProgressPrinter printer_;
};

}  // namespace sinew::app
