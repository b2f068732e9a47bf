#include "sim_hil/worlds/air.hpp"

#include <algorithm>

namespace sinew::plant {
namespace {

hal::Duration seconds(double s) { return hal::Duration{static_cast<std::int64_t>(s * 1e9)}; }

/// std::push_heap's order puts the greatest first.
constexpr auto kLater = [](const auto& a, const auto& b) { return a.at != b.at ? a.at > b.at : a.order > b.order; };

}  // namespace

AirOptions air_options(const WorldInfo& world, const WorldValues& values) {
  AirOptions air;
  if (!world.find_option(kSharedWorldOptions[0].key)) return air;
  const auto value = [&](const char* key) { return world.value(values, key).value(); };
  air.loss = value("air_loss");
  air.delay = seconds(1e-3 * value("air_delay_ms"));
  air.jitter = seconds(1e-3 * value("air_jitter_ms"));
  air.bits_per_s = 1e3 * value("air_kbps");
  air.range_m = value("air_range_m");
  air.split_from = hal::Time{0} + seconds(value("air_split_at_s"));
  air.split_until = air.split_from + seconds(value("air_split_s"));
  return air;
}

Air::Air(const AirOptions& options, std::size_t stations, std::uint64_t seed)
    : options_(options), seed_(seed), stations_(stations) {
  if (stations > 1)
    for (Station& station : stations_) station.under_way.reserve(kMostUnderWay);
}

bool Air::reaches(std::size_t from, std::size_t to, hal::Time at) const {
  const std::size_t half = stations_.size() / 2;
  if (at >= options_.split_from && at < options_.split_until && (from < half) != (to < half)) return false;
  const msg::Vec3 &a = stations_[from].p_world_m, &b = stations_[to].p_world_m;
  const double x = a.x - b.x, y = a.y - b.y, z = a.z - b.z;
  return x * x + y * y + z * z <= options_.range_m * options_.range_m;
}

std::uint32_t Air::free_place() {
  if (free_.empty()) {
    free_.push_back(static_cast<std::uint32_t>(spoken_.size()));
    spoken_.emplace_back();
  }
  const std::uint32_t place = free_.back();
  free_.pop_back();
  return place;
}

void Air::send(std::size_t station, hal::Time at, std::span<const std::uint8_t> bytes, hal::Time now) {
  if (bytes.empty() || bytes.size() > msg::kMaxDatagramBytes) return;
  Station& from = stations_[station];
  const std::uint64_t number = from.number++;
  const hal::Time begin = std::max(at, free_at_);
  if (begin - at > kMostWait) {
    ++from.counts.tx_lost;
    return;
  }
  ++from.counts.sent;
  const std::uint32_t place = free_place();
  Spoken& spoken = spoken_[place];
  spoken.sender = static_cast<std::uint32_t>(station + 1);
  spoken.size = static_cast<std::uint32_t>(bytes.size());
  std::ranges::copy(bytes, spoken.data.begin());
  free_at_ = begin + seconds(8.0 * static_cast<double>(bytes.size() + kOverheadBytes) / options_.bits_per_s);
  for (std::size_t to = 0; to < stations_.size(); ++to) {
    if (to == station) continue;
    Station& listener = stations_[to];
    const auto pair = 0x61697200u + static_cast<std::uint32_t>(station * kMostStations + to);
    math::Random random(seed_, pair, number);
    const bool lost = random.uniform() < options_.loss;
    const hal::Duration jitter = seconds(1e-9 * static_cast<double>(options_.jitter.count()) * random.uniform());
    if (!reaches(station, to, at)) {
      ++listener.counts.out_of_reach;
    } else if (lost) {
      ++listener.counts.rx_lost;
    } else if (listener.under_way.size() == kMostUnderWay) {
      ++listener.counts.rx_full;
    } else {
      ++listener.counts.heard;
      ++spoken.listeners;
      const hal::Time arrival = std::max(free_at_ + options_.delay + jitter, now + hal::Duration{1});
      listener.under_way.push_back({arrival, order_++, place});
      std::ranges::push_heap(listener.under_way, kLater);
    }
  }
  if (spoken.listeners == 0) free_.push_back(place);
}

const msg::Datagram* Air::receive(std::size_t station, hal::Time until) {
  Station& here = stations_[station];
  if (here.under_way.empty() || here.under_way.front().at > until) return nullptr;
  std::ranges::pop_heap(here.under_way, kLater);
  const UnderWay arrives = here.under_way.back();
  here.under_way.pop_back();
  Spoken& spoken = spoken_[arrives.spoken];
  msg::Datagram& d = here.arrived;
  d.stamp = arrives.at;
  d.sender = spoken.sender;
  if (spoken.size < d.size) std::fill(d.data.begin() + spoken.size, d.data.begin() + d.size, std::uint8_t{0});
  d.size = spoken.size;
  std::copy_n(spoken.data.begin(), spoken.size, d.data.begin());
  if (--spoken.listeners == 0) free_.push_back(arrives.spoken);
  return &d;
}

}  // namespace sinew::plant
