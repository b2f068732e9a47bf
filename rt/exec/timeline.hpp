#pragma once
// The threads' latest events. Each thread writes its own at a few nanoseconds an event; any thread may read them at any
// time without disturbing the writers.
#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <vector>

#include "hal/clock.hpp"
#include "hal/wide.hpp"
#include "rt/graph.hpp"
#include "rt/zone.hpp"

namespace sinew::rt {

struct TimelineEvent {
  enum class Kind : std::uint8_t {
    release,        // `at` of the release, `length` until its cycle began
    cycle,          // from its first step's start, when it has completed
    step,           // of `module`, start to completion; in virtual time preemption included
    overrun,        // a release that met an unfinished cycle, and waits
    skip,           // a release that met an unfinished cycle, and was dropped
    preempted,      // virtual time: the cycle had no core; exact, written when it runs again
    off_processor,  // real time: ready without a processor for longer than GapWatch::kGap; about, written at its end
    zone,           // a named part of a step of `module`
  };
  Kind kind = Kind::release;
  std::uint32_t thread = 0;
  std::uint32_t module = kNone;
  Time at;
  Duration length{};
  const char* zone = nullptr;
};

/// The newest events of one thread. An event that the writer overwrites while it is read is dropped: each of its two
/// words carries the round in which it was written, so they are of one event or are seen not to be.
/// Thread:  one writer, any readers.   RT: yes, but for read().
class TimelineRing {
 public:
  using Kind = TimelineEvent::Kind;
  struct Entry {
    Kind kind;
    std::uint32_t index;  // step: position in the thread; zone: see zone()
    Time at;
    Duration length;
  };

  /// Instants before `start` count as `start`. Capacity: a power of two.
  TimelineRing(std::uint32_t capacity, Time start);
  void add(Kind kind, Time at, Duration length = {}, std::uint32_t index = 0) noexcept {
    const std::uint32_t n = next_.load(std::memory_order_relaxed);
    Slot& slot = slots_[n & mask_];
    const std::uint64_t round = n >> shift_ & kRounds;
    // Relaxed: a reader that sees one word of an event without the other drops it.
    slot.at.store(clamp(at - start_, kAtBits) << kRoundBits | round, std::memory_order_relaxed);
    slot.rest.store(clamp(length, kLengthBits) << 28 | std::uint64_t{index & 0xFFF} << 16 |
                        std::uint64_t{static_cast<std::uint8_t>(kind)} << 12 | round,
                    std::memory_order_relaxed);
    next_.store(n + 1, std::memory_order_release);  // partner: read()
  }
  /// The number by which entries name this zone of this module; a literal. The last number when there are too many.
  std::uint32_t zone(const char* name, std::uint32_t module) noexcept;
  struct ZoneName {
    const char* name;
    std::uint32_t module;
  };
  ZoneName zone_name(std::uint32_t index) const noexcept;

  /// Appends what is there, oldest first.
  void read(std::vector<Entry>& out) const;

 private:
  // A word has 12 bits for the round. The rest of one word holds 52 bits of nanoseconds (52 days) from the start; the
  // rest of the other holds 36 bits of length (68 s), 12 of index and 4 of kind.
  static constexpr unsigned kRoundBits = 12, kAtBits = 52, kLengthBits = 36;
  static constexpr std::uint64_t kRounds = (1u << kRoundBits) - 1;
  static constexpr std::uint32_t kZones = 64;
  static std::uint64_t clamp(Duration d, unsigned bits) noexcept {
    const std::int64_t most = (std::int64_t{1} << bits) - 1, ns = d.count();
    return static_cast<std::uint64_t>(ns < 0 ? 0 : ns > most ? most : ns);
  }

  struct Slot {
    hal::Wide<std::uint64_t> at, rest;
  };
  struct Zone {
    std::atomic<const char*> name{nullptr};
    std::atomic<std::uint32_t> module{0};
  };
  std::vector<Slot> slots_;
  const std::uint32_t mask_, shift_;
  const Time start_;
  std::atomic<std::uint32_t> next_;
  std::array<Zone, kZones> zones_;
  std::atomic<std::uint32_t> zone_count_{0};
};

/// All threads of a run. Each keeps at least a second of events at the period of the robot file (topic and device
/// threads: 1000 cycles); zones shorten that.
/// Thread:  owner for construction; ring(): its thread; snapshot(): any.
class Timeline {
 public:
  Timeline(const Graph& graph, Time start);
  TimelineRing& ring(std::uint32_t thread) { return *rings_[thread]; }
  /// What was written in the last `last` before the newest event, in the order of its beginning; outer before inner.
  std::vector<TimelineEvent> snapshot(Duration last = std::chrono::seconds(1)) const;
  std::size_t bytes() const { return bytes_; }

 private:
  const Graph& graph_;
  std::vector<std::unique_ptr<TimelineRing>> rings_;
  std::size_t bytes_ = 0;
};

/// Zones of one module, in the ring of its thread.
class RingZones final : public ZoneLog {
 public:
  RingZones(TimelineRing& ring, const hal::Clock& clock, std::uint32_t module) noexcept
      : ring_(ring), clock_(clock), module_(module) {}
  Time now() noexcept override;
  void note(const char* name, Time start) noexcept override;

 private:
  TimelineRing& ring_;
  const hal::Clock& clock_;
  std::uint32_t module_;
};

}  // namespace sinew::rt
