#include "monitor/foxglove/picture_pace.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <deque>
#include <vector>

namespace sinew::foxglove::picture_pace_test {
namespace {

using namespace std::chrono_literals;
using Time = PicturePace::Clock::time_point;

/// A link of a rate and a round trip, and a camera whose pictures have so many bytes at full size.
struct Path {
  double bytes_per_s = 250'000;
  std::chrono::milliseconds round_trip = 50ms;
  double full_bytes = 60'000;
  Time now{}, free{};
  std::uint64_t given = 0, acknowledged = 0;
  std::deque<std::pair<Time, std::uint64_t>> acks{};
  PicturePace pace{};
  std::vector<double> ages_ms{};  // of pictures at arrival

  Link link() {
    while (!acks.empty() && acks.front().first <= now) acknowledged = acks.front().second, acks.pop_front();
    return {acknowledged, static_cast<std::uint32_t>(given - acknowledged), 0, 0,
            static_cast<std::uint32_t>(round_trip / 1us)};
  }
  double bytes_now() const {
    const PictureSize s = pace.size();
    return full_bytes * s.scale * s.scale * (0.15 + 0.85 * s.quality / 85.0) + 300;
  }
  void run(std::chrono::seconds time) {
    const Time end = now + time;
    for (; now < end; now += 10ms) {
      pace.look(now, link());
      if (!pace.may_send(link())) continue;
      const double bytes = bytes_now();
      free = std::max(free, now) +
             std::chrono::duration_cast<PicturePace::Duration>(std::chrono::duration<double>(bytes / bytes_per_s));
      given += static_cast<std::uint64_t>(bytes);
      acks.emplace_back(free + round_trip, given);
      ages_ms.push_back(std::chrono::duration<double, std::milli>(free + round_trip / 2 - now).count());
      pace.sent(now, {acknowledged, static_cast<std::uint32_t>(given - acknowledged), 0, 0, 0});
    }
  }
  double share_below(double ms) const {
    const auto n = std::count_if(ages_ms.begin(), ages_ms.end(), [ms](double age) { return age < ms; });
    return static_cast<double>(n) / static_cast<double>(ages_ms.size());
  }
};

TEST(PicturePaceTest, OnAFastLinkPicturesBecomeWhole) {
  Path path{.bytes_per_s = 100e6, .round_trip = 1ms};
  path.run(10s);
  EXPECT_EQ(path.pace.size(), PictureSize{});
}

TEST(PicturePaceTest, OnAThinLinkTheyBecomeSmallAndArriveYoung) {
  Path path{.bytes_per_s = 250'000};
  path.run(5s);
  path.ages_ms.clear();
  path.run(60s);
  EXPECT_GT(path.share_below(200), 0.95);
  EXPECT_GT(path.ages_ms.size(), 400u) << "about ten a second";
}

TEST(PicturePaceTest, OnAVeryThinLinkTheyStillArrive) {
  Path path{.bytes_per_s = 20'000, .round_trip = 200ms};
  path.run(10s);
  path.ages_ms.clear();
  path.run(60s);
  EXPECT_GT(path.share_below(400), 0.9);
}

TEST(PicturePaceTest, ALinkThatGetsBetterGetsLargerPictures) {
  Path path{.bytes_per_s = 100'000};
  path.run(10s);
  const int before = path.pace.step();
  path.bytes_per_s = 10e6;
  path.run(60s);
  EXPECT_LT(path.pace.step(), before);
}

TEST(PicturePaceTest, OneLostPacketChangesNothing) {
  Path path{.bytes_per_s = 10e6, .round_trip = 20ms};
  path.run(20s);
  const int before = path.pace.step();
  path.free = path.now + 400ms;  // one picture waits that long
  path.run(2s);
  EXPECT_LE(path.pace.step(), before + 1);
}

TEST(PicturePaceTest, NoMoreAreUnderWayThanTheRoundTripNeeds) {
  PicturePace pace;
  Link link{};
  link.shortest_round_trip_us = 1000;
  EXPECT_TRUE(pace.may_send(link));
  for (int i = 0; i < 2; ++i) link.outstanding += 1000, pace.sent({}, link);
  EXPECT_FALSE(pace.may_send(link));
  link.acknowledged = 1000, link.outstanding = 1000;
  pace.look(Time{} + 5ms, link);
  EXPECT_TRUE(pace.may_send(link));
  link.unsent = 5000;
  EXPECT_FALSE(pace.may_send(link)) << "behind what waits for the link it would get old";
}

}  // namespace
}  // namespace sinew::foxglove::picture_pace_test
