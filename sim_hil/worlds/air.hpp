#pragma once
// The simulated air between the radios of the robots of one world.
#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "hal/clock.hpp"
#include "math/random.hpp"
#include "msg/geometry.hpp"
#include "msg/radio.hpp"
#include "sim_hil/worlds/world.hpp"

namespace sinew::plant {

/// What the air does to datagrams. Each has an option of a world with several robots: kSharedWorldOptions.
struct AirOptions {
  double loss = 0;                          // share of its datagrams that one listener does not get
  hal::Duration delay{2'000'000};           // from the end of the sending to the arrival
  hal::Duration jitter{0};                  // at most so much is added, uniformly: datagrams may overtake each other
  double bits_per_s = 6e6;                  // shared by all: while one sends, the others wait
  double range_m = 1000;                    // beyond it nothing arrives
  hal::Time split_from{0}, split_until{0};  // the first half of the robots and the others do not hear each other
};

inline constexpr std::array<WorldOption, 9> kSharedWorldOptions{{
    {"air_loss", "air-loss", "", 0, 1, 0.0, "", "share of a robot's datagrams that a mate's radio does not get"},
    {"air_delay_ms", "air-delay", "ms", 1, 10000, 2.0, "", "from the end of a datagram's sending to its arrival"},
    {"air_jitter_ms", "air-jitter", "ms", 0, 10000, 0.0, "",
     "at most so much is added to the delay, uniformly; datagrams may overtake each other"},
    {"air_kbps", "air-kbps", "kbit/s", 1, 1e6, 6000.0, "", "shared by all robots: while one sends, the others wait"},
    {"air_range_m", "air-range", "m", 0, 1e6, 1000.0, "", "mates that are further away hear nothing"},
    {"air_split_at_s", "air-split-at", "s", 0, 1e6, 0.0, "",
     "from here on, for air_split_s, the first half of the robots and the others do not hear each other"},
    {"air_split_s", "air-split", "s", 0, 1e6, 0.0, "", "how long that lasts; 0: it does not happen"},
    {"clock_offset_s", "clock-offset", "s", 0, 1e6, std::nullopt, "by the seed with several robots, up to 60; else 0",
     "virtual time: what the robot's clock shows when the world begins", false, true},
    {"clock_drift_ppm", "clock-drift", "ppm", -1000, 1000, std::nullopt,
     "by the seed with several robots, up to 50 either way; else 0",
     "virtual time: how much faster than the world's time the robot's clock runs", false, true},
}};

/// The options of a world with room for several robots.
template <std::size_t kOwn>
constexpr auto with_shared_world_options(const std::array<WorldOption, kOwn>& own) {
  std::array<WorldOption, kOwn + kSharedWorldOptions.size()> all;
  std::copy(kSharedWorldOptions.begin(), kSharedWorldOptions.end(), std::copy(own.begin(), own.end(), all.begin()));
  return all;
}

/// The air that these values of kSharedWorldOptions describe.
AirOptions air_options(const WorldInfo& world, const WorldValues& values);

/// One medium with a station for each robot. Each datagram occupies it for its bytes and kOverheadBytes at the medium's
/// rate, one after the other in the order of their sending; one that would have to wait longer than kMostWait is lost,
/// and so is one that a listener has no room for. What one pair of stations loses and how it is delayed is drawn from
/// the seed, the pair, and the number of the datagram at its sender: the traffic of others does not change it.
/// Thread:  owner.
class Air {
 public:
  static constexpr std::size_t kOverheadBytes = 62;                           // of Ethernet's frame, IPv4 and UDP
  static constexpr hal::Duration kMostWait = std::chrono::milliseconds(200);  // for the medium
  static constexpr std::size_t kMostStations = 1024;
  static constexpr std::size_t kMostUnderWay = 512;  // to one listener

  struct Counts {
    std::uint64_t sent = 0, heard = 0;  // datagrams; heard: that arrived, or will
    std::uint64_t tx_lost = 0;          // found the medium busy for too long
    std::uint64_t rx_lost = 0;          // lost on the way here, by chance
    std::uint64_t out_of_reach = 0;     // sent by a mate out of range, or behind the split
    std::uint64_t rx_full = 0;          // too many under way to here
  };

  Air(const AirOptions& options, std::size_t stations, std::uint64_t seed);

  std::size_t stations() const { return stations_.size(); }
  void move(std::size_t station, const msg::Vec3& p_world_m) { stations_[station].p_world_m = p_world_m; }
  /// One datagram, sent at `at`. Calls are in the order of (time, station, order of sending): then the result does not
  /// depend on which robot's runtime was the fastest. It arrives at `now` + 1 ns at the earliest.
  void send(std::size_t station, hal::Time at, std::span<const std::uint8_t> bytes, hal::Time now);
  /// The next datagram that arrives at `station` by `until`; its stamp is when. Valid until the next call. Null: none.
  const msg::Datagram* receive(std::size_t station, hal::Time until);
  const Counts& counts(std::size_t station) const { return stations_[station].counts; }

 private:
  /// A datagram in the air, once for all its listeners.
  struct Spoken {
    std::uint32_t sender = 0, size = 0;
    std::uint32_t listeners = 0;  // that it is still under way to; 0: the place is free
    std::array<std::uint8_t, msg::kMaxDatagramBytes> data;
  };
  struct UnderWay {
    hal::Time at;
    std::uint64_t order = 0;   // of sending: decides between equal times
    std::uint32_t spoken = 0;  // its place
  };
  struct Station {
    msg::Vec3 p_world_m;
    std::uint64_t number = 0;           // of its next datagram
    std::vector<UnderWay> under_way{};  // a heap, the earliest first
    msg::Datagram arrived{};
    Counts counts{};
  };
  bool reaches(std::size_t from, std::size_t to, hal::Time at) const;
  std::uint32_t free_place();

  AirOptions options_;
  std::uint64_t seed_;
  std::vector<Station> stations_;
  std::vector<Spoken> spoken_;
  std::vector<std::uint32_t> free_;  // places of spoken_
  hal::Time free_at_{0};             // the medium
  std::uint64_t order_ = 0;
};

}  // namespace sinew::plant
