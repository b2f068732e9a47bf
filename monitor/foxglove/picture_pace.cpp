#include "monitor/foxglove/picture_pace.hpp"

#include <algorithm>
#include <iterator>

namespace sinew::foxglove {
namespace {

// Each is about 0.7 of the bytes of the one before. The first is what HTTP gives who asks for nothing else, so that
// both share their pictures.
constexpr PictureSize kSteps[] = {{80, 1},     {70, 1},    {60, 1},     {45, 1},     {60, 0.707},
                                  {45, 0.707}, {60, 0.5},  {45, 0.5},   {60, 0.354}, {45, 0.354},
                                  {60, 0.25},  {45, 0.25}, {50, 0.177}, {40, 0.125}};
constexpr int kLast = static_cast<int>(std::size(kSteps)) - 1;
constexpr int kFirst = 6;  // of a connection that is not known yet
constexpr std::size_t kRemembered = 6;
constexpr std::size_t kMostUnderWay = 3;
constexpr std::uint32_t kUnsent = 4096;  // bytes; more of them wait for the link, and a picture behind them too
constexpr std::chrono::milliseconds kInterval{33};  // between pictures of most cameras

}  // namespace

int PicturePace::steps() { return kLast + 1; }

PictureSize PicturePace::size() const { return kSteps[std::clamp(kFirst + step_, 0, kLast)]; }

void PicturePace::look(Clock::time_point now, const Link& link) {
  while (!under_way_.empty() && link.acknowledged >= under_way_.front().end) {
    const Duration took = now - under_way_.front().at;
    under_way_.pop_front();
    delivered(now, took - std::chrono::microseconds(link.shortest_round_trip_us));
  }
}

bool PicturePace::may_send(const Link& link) const {
  // As many as are on their way when each is sent as soon as the camera has it.
  const auto fits = 1 + std::chrono::microseconds(link.shortest_round_trip_us) / kInterval;
  return link.unsent <= kUnsent &&
         under_way_.size() < std::min<std::size_t>(kMostUnderWay, static_cast<std::size_t>(fits) + 1);
}

void PicturePace::sent(Clock::time_point now, const Link& link) {
  under_way_.push_back({link.acknowledged + link.outstanding, now});
}

void PicturePace::delivered(Clock::time_point now, Duration beyond) {
  slow_.push_back(beyond > kSlow);
  if (slow_.size() > kRemembered) slow_.pop_front();
  quick_ = beyond < kQuick ? quick_ + 1 : 0;
  const auto slow = static_cast<std::size_t>(std::count(slow_.begin(), slow_.end(), true));
  if (slow * 2 >= kRemembered && slow * 2 > slow_.size()) {
    // One size too many is soon seen; on a link much too thin for it two are.
    change(now, beyond > 3 * kSlow ? 3 : 1);
    // The larger size that was tried last is what was too much: the next try comes later.
    if (now - larger_at_ < std::chrono::seconds(3)) hold_ = std::min<Duration>(2 * hold_, kMostHold);
    was_slow_ = true;
    hold_until_ = now + hold_;
  } else if (quick_ >= (was_slow_ ? 8 : 3) && now >= hold_until_) {
    change(now, -1);
    larger_at_ = now;
    hold_until_ = now + (was_slow_ ? hold_ : Duration{});
  }
}

void PicturePace::change(Clock::time_point, int by) {
  step_ = std::clamp(step_ + by, -kFirst, kLast - kFirst);
  slow_.clear();
  quick_ = 0;
}

}  // namespace sinew::foxglove
