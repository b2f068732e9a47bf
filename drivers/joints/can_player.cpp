#include "drivers/joints/can_player.hpp"

#include <chrono>

#include "wire/candump.hpp"

namespace sinew::drivers {
namespace {

constexpr hal::Duration kTryAgain = std::chrono::milliseconds(1);

}  // namespace

hal::Result<CanPlayer> CanPlayer::open(std::string_view log, const Options& options, std::string& why) {
  if (!(options.speed >= 0) || options.speed > 1e6) {
    why = "speed: 0 to a million";
    return hal::Error{hal::Errc::bad_argument, "speed"};
  }
  CanPlayer player;
  std::int64_t first = 0, last = 0;
  for (std::size_t number = 1; !log.empty(); ++number) {
    const std::size_t end = log.find('\n');
    const std::string_view text = log.substr(0, end);
    log.remove_prefix(end == std::string_view::npos ? log.size() : end + 1);
    if (text.find_first_not_of(" \t\r") == std::string_view::npos) continue;
    wire::CandumpLine line;
    if (const char* wrong = wire::candump_parse(text, line)) {
      why = "line " + std::to_string(number) + ": " + wrong;
      return hal::Error{hal::Errc::bad_data, "candump log", static_cast<std::int64_t>(number)};
    }
    if (!options.interface.empty() && line.interface != options.interface) continue;
    if (line.frame.error()) {
      ++player.stats_.error_frames;
      continue;
    }
    if (player.frames_.empty()) first = last = line.frame.stamp.ns;
    // A log of several interfaces, or of a clock that was set: times do not go back.
    last = line.frame.stamp.ns > last ? line.frame.stamp.ns : last;
    const double since = static_cast<double>(last - first);
    line.frame.stamp.ns = options.speed > 0 ? static_cast<std::int64_t>(since / options.speed) : 0;
    player.frames_.push_back(line.frame);
  }
  if (player.frames_.empty()) {
    why = options.interface.empty() ? "no frame is in the log" : "no frame of " + options.interface + " is in the log";
    return hal::Error{hal::Errc::bad_argument, "candump log"};
  }
  return player;
}

hal::Time CanPlayer::step(hal::Time now, hal::CanBus& bus) noexcept {
  if (!begun_) {
    begun_ = true;
    start_ = now;
  }
  for (; next_ < frames_.size(); ++next_) {
    const hal::Time due{start_.ns + frames_[next_].stamp.ns};
    if (due > now) return due;
    const hal::Status sent = bus.send(frames_[next_], hal::kNever);
    if (!sent && (sent.error().code == hal::Errc::timeout || sent.error().code == hal::Errc::closed))
      return now + kTryAgain;
    sent ? ++stats_.sent : ++stats_.refused;
  }
  return hal::kNever;
}

}  // namespace sinew::drivers
