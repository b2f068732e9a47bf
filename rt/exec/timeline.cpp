#include "rt/exec/timeline.hpp"

#include <algorithm>
#include <bit>

#include "rt/trap.hpp"

namespace sinew::rt {

TimelineRing::TimelineRing(std::uint32_t capacity, Time start)
    : slots_(capacity),
      mask_(capacity - 1),
      shift_(static_cast<std::uint32_t>(std::countr_zero(capacity))),
      start_(start),
      next_(capacity) {}  // round 0 is that of slots never written

std::uint32_t TimelineRing::zone(const char* name, std::uint32_t module) noexcept {
  const std::uint32_t count = zone_count_.load(std::memory_order_relaxed);
  for (std::uint32_t i = 0; i < count; ++i)
    if (zones_[i].name.load(std::memory_order_relaxed) == name &&
        zones_[i].module.load(std::memory_order_relaxed) == module)
      return i;
  if (count == kZones) return kZones - 1;
  zones_[count].module.store(module, std::memory_order_relaxed);
  zones_[count].name.store(count + 1 == kZones ? "other" : name, std::memory_order_relaxed);
  zone_count_.store(count + 1, std::memory_order_release);  // partner: zone_name()
  return count;
}

TimelineRing::ZoneName TimelineRing::zone_name(std::uint32_t index) const noexcept {
  if (index >= zone_count_.load(std::memory_order_acquire)) return {"?", kNone};
  return {zones_[index].name.load(std::memory_order_relaxed), zones_[index].module.load(std::memory_order_relaxed)};
}

void TimelineRing::read(std::vector<Entry>& out) const {
  const std::uint32_t end = next_.load(std::memory_order_acquire);
  for (std::uint32_t n = end - mask_ - 1; n != end; ++n) {
    const Slot& slot = slots_[n & mask_];
    const std::uint64_t at = slot.at.load(std::memory_order_relaxed), rest = slot.rest.load(std::memory_order_relaxed);
    const std::uint64_t round = n >> shift_ & kRounds;
    if ((at & kRounds) != round || (rest & kRounds) != round) continue;  // overwritten meanwhile, or never written
    if (at == 0 && rest == 0) continue;
    out.push_back({static_cast<Kind>(rest >> 12 & 0xF), static_cast<std::uint32_t>(rest >> 16 & 0xFFF),
                   start_ + Duration{static_cast<std::int64_t>(at >> kRoundBits)},
                   Duration{static_cast<std::int64_t>(rest >> 28)}});
  }
}

Timeline::Timeline(const Graph& graph, Time start) : graph_(graph) {
  for (const GraphThread& t : graph.threads()) {
    const bool periodic = t.spec.trigger == ThreadSpec::Trigger::period && t.spec.period > Duration{0};
    const std::int64_t cycles = periodic ? std::chrono::seconds(1) / t.spec.period : 1000;
    const std::int64_t events = cycles * static_cast<std::int64_t>(t.modules.size() + 3);
    const auto capacity = std::bit_ceil(static_cast<std::uint32_t>(std::clamp<std::int64_t>(events, 512, 65536)));
    rings_.push_back(std::make_unique<TimelineRing>(capacity, start));
    bytes_ += capacity * 2 * sizeof(hal::Wide<std::uint64_t>);
  }
}

std::vector<TimelineEvent> Timeline::snapshot(Duration last) const {
  using Kind = TimelineEvent::Kind;
  std::vector<TimelineEvent> events;
  std::vector<TimelineRing::Entry> entries;
  Time newest{INT64_MIN};
  for (std::uint32_t t = 0; t < rings_.size(); ++t) {
    entries.clear();
    rings_[t]->read(entries);
    for (const TimelineRing::Entry& e : entries) {
      TimelineEvent event{e.kind, t, kNone, e.at, e.length, nullptr};
      if (e.kind == Kind::step && e.index < graph_.threads()[t].modules.size())
        event.module = graph_.threads()[t].modules[e.index];
      if (e.kind == Kind::zone) {
        const auto zone = rings_[t]->zone_name(e.index);
        event.zone = zone.name;
        event.module = zone.module;
      }
      newest = std::max(newest, e.at + e.length);
      events.push_back(event);
    }
  }
  std::erase_if(events, [&](const TimelineEvent& e) { return newest - (e.at + e.length) > last; });
  std::stable_sort(events.begin(), events.end(), [](const auto& a, const auto& b) {
    if (a.at != b.at) return a.at < b.at;
    return a.length != b.length ? a.length > b.length : a.kind < b.kind;
  });
  return events;
}

// The clock is the executor's; the step itself never sees the time.
Time RingZones::now() noexcept {
  const trap::Scope outside(nullptr);
  return clock_.now();
}

void RingZones::note(const char* name, Time start) noexcept {
  ring_.add(TimelineEvent::Kind::zone, start, now() - start, ring_.zone(name, module_));
}

}  // namespace sinew::rt
