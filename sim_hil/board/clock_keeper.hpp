#pragma once
#include <functional>
#include <memory>
#include <mutex>

#include "hal/clock_filter.hpp"
#include "hal/os.hpp"
#include "hal/stream.hpp"
#include "sim_hil/board/plant_clock.hpp"
#include "sim_hil/board/side_line.hpp"

namespace sinew::sim_hil {

/// One more connection to the same plant; may take a second at most.
using Connect = std::function<hal::Result<std::unique_ptr<hal::Stream>>()>;

struct ClockStats {
  bool followed = false;  // by exchanges on a side line
  Duration offset{0};     // our host's clock minus the plant's
  Duration bound{0};      // the newest, and the worst since follow(): of plant time, with what is still to slew
  Duration worst_bound{0};
  double drift = 0;
  std::uint32_t exchanges = 0, rejected = 0, restarts = 0;
};

/// Compares our host's clock with a remote plant's for the length of a connection: a burst of exchanges in begin(),
/// then five a second from a thread. They use their own side line, so that they do not disturb the samples' stream.
/// Without a side line (the plant has none) the offset of Start and Clock stays, and its bound grows.
/// Thread:  owner, but stats() any.
class ClockKeeper {
 public:
  ClockKeeper(hal::Os& os, const hal::ThreadOptions& thread, Connect connect, PlantClock& plant_clock)
      : os_(os), thread_options_(thread), connect_(std::move(connect)), plant_clock_(plant_clock) {}
  ~ClockKeeper() { stop(); }
  ClockKeeper(const ClockKeeper&) = delete;
  ClockKeeper& operator=(const ClockKeeper&) = delete;

  /// A new plant: forgets the last one, and compares clocks a few times. Takes up to two seconds.
  void begin();
  /// One more exchange, which the caller made.
  void add(Time asked, Time received, Time answered, Time arrived);
  /// Our host's clock minus the plant's, now. After begin() and add().
  Duration host_offset() const;
  /// From now on steers the plant clock: it has this `offset` at this host offset, and runs at `rate` of host time.
  void follow(Duration offset, Duration host_offset, double rate);
  /// Ends the exchanges; the statistics stay.
  void stop();
  ClockStats stats() const;

 private:
  bool open_line();
  bool exchange();
  void run();
  void steer();

  hal::Os& os_;
  hal::ThreadOptions thread_options_;
  Connect connect_;
  PlantClock& plant_clock_;
  mutable std::mutex mutex_;  // the filter, the line's pointer and the statistics
  hal::ClockFilter filter_;
  std::unique_ptr<SideLine> line_;
  bool refused_ = false;  // the plant takes no side line
  ClockStats stats_;
  Duration base_offset_{0}, base_host_offset_{0};
  double rate_ = 1;
  hal::WakeWord stop_{0};
  std::unique_ptr<hal::Thread> thread_;
};

}  // namespace sinew::sim_hil
