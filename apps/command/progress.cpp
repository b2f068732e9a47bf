#include "apps/command/progress.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <utility>

#include "hal/linux/process.hpp"
#include "hal/platform.hpp"

namespace sinew::app {
namespace {

using namespace std::chrono_literals;
constexpr auto kLong = 300ms;  // work that is shorter needs no words
constexpr auto kAgain = 100ms;
constexpr auto kAgainInALog = 10s;

double seconds_of(hal::Duration d) { return std::chrono::duration<double>(d).count(); }

/// "3.1/s"
std::string rate_text(double per_s) {
  if (per_s >= 10) return fmt::format("{:.0f}/s", per_s);
  if (per_s >= 0.1) return fmt::format("{:.1f}/s", per_s);
  if (per_s * 60 >= 0.1) return fmt::format("{:.1f}/min", per_s * 60);
  return fmt::format("{:.1f}/h", per_s * 3600);
}

/// "2 min"
std::string time_text(double s) {
  if (s < 100) return fmt::format("{:.0f} s", s);
  if (s < 100 * 60) return fmt::format("{:.0f} min", s / 60);
  if (s < 36 * 3600) return fmt::format("{:.1f} h", s / 3600);
  return fmt::format("{:.1f} d", s / 86400);
}

/// Rate and time left, `between` before each; empty while nothing is known of them.
std::string pace_text(const ProgressState& state, hal::Duration elapsed, const char* between) {
  const double s = seconds_of(elapsed);
  if (s <= 0 || state.done <= state.done_before) return {};
  const double per_s = static_cast<double>(state.done - state.done_before) / s;
  const std::uint64_t left = state.total > state.done ? state.total - state.done : 0;
  return fmt::format("{}{}{}{} left", between, rate_text(per_s), between, time_text(static_cast<double>(left) / per_s));
}

void put_error(const std::string& text) {
  if (text.empty()) return;
  std::fputs(text.c_str(), stderr);
  std::fflush(stderr);
}

}  // namespace

std::string progress_text(const ProgressState& state, hal::Duration elapsed) {
  constexpr std::size_t kWidth = 30;
  const double part =
      state.total == 0 ? 0 : std::min(1.0, static_cast<double>(state.done) / static_cast<double>(state.total));
  const auto filled = static_cast<std::size_t>(part * kWidth);
  const std::string pace = state.of == ProgressOf::cases ? pace_text(state, elapsed, "  ") : std::string();
  return fmt::format("{} [{}{}] {:3.0f} %{}", state.what, std::string(filled, '#'), std::string(kWidth - filled, ' '),
                     100 * part, pace);
}

std::string progress_line(const ProgressState& state, hal::Duration elapsed) {
  return fmt::format("{}: {} of {} cases{}", state.what, state.done, state.total, pace_text(state, elapsed, ", "));
}

ProgressPrinter::ProgressPrinter(std::string what, ProgressOf of, bool terminal, hal::Time begin)
    : state_{.what = std::move(what), .of = of},
      terminal_(terminal),
      begin_(begin),
      next_(begin + (terminal ? hal::Duration(kLong) : hal::Duration(kAgainInALog))) {}

std::string ProgressPrinter::add(std::uint64_t done, hal::Time now) {
  state_.done += done;
  if (now < next_ || (!terminal_ && state_.of != ProgressOf::cases)) return {};
  next_ = now + (terminal_ ? hal::Duration(kAgain) : hal::Duration(kAgainInALog));
  if (!terminal_) return progress_line(state_, now - begin_) + "\n";
  drawn_ = true;
  return "\r" + progress_text(state_, now - begin_) + "\033[K";  // the line before may have been longer
}

std::string ProgressPrinter::erase() { return std::exchange(drawn_, false) ? "\r\033[K" : ""; }

Progress::Progress(std::string what, bool shown, ProgressOf of)
    : shown_(shown), printer_(std::move(what), of, hal::error_output_is_terminal(), hal::system_os().now()) {}

Progress::~Progress() { erase(); }

void Progress::add(std::uint64_t done) {
  if (shown_) put_error(printer_.add(done, hal::system_os().now()));
}

void Progress::erase() { put_error(printer_.erase()); }

}  // namespace sinew::app
