#include "apps/command/progress.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>

#include "hal/linux/process.hpp"

namespace sinew::app {
namespace {

using namespace std::chrono_literals;
constexpr auto kLong = 300ms;  // work that is shorter needs no words
constexpr auto kAgain = 100ms;

}  // namespace

std::string progress_text(const std::string& what, std::uint64_t done, std::uint64_t total) {
  constexpr std::size_t kWidth = 30;
  const double part = total == 0 ? 0 : std::min(1.0, static_cast<double>(done) / static_cast<double>(total));
  const auto filled = static_cast<std::size_t>(part * kWidth);
  return fmt::format("{} [{}{}] {:3.0f} %", what, std::string(filled, '#'), std::string(kWidth - filled, ' '),
                     100 * part);
}

Progress::Progress(std::string what, bool shown)
    : what_(std::move(what)),
      shown_(shown && hal::error_output_is_terminal()),
      next_(std::chrono::steady_clock::now() + kLong) {}

Progress::~Progress() {
  if (drawn_) std::fputs("\r\033[K", stderr);
}

void Progress::add(std::uint64_t done) {
  done_ += done;
  if (!shown_) return;
  const auto now = std::chrono::steady_clock::now();
  if (now < next_) return;
  next_ = now + kAgain;
  drawn_ = true;
  std::fputs(("\r" + progress_text(what_, done_, total_)).c_str(), stderr);
  std::fflush(stderr);
}

}  // namespace sinew::app
