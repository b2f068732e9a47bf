#pragma once
// The devices of the sim board: queues that the board fills from the connection and the driver modules empty.
#include <atomic>
#include <functional>
#include <memory>
#include <string>

#include "hal/device.hpp"
#include "hal/os.hpp"
#include "hal/radio.hpp"
#include "hal/sample_ring.hpp"
#include "hal/wake_slot.hpp"
#include "hal/wide.hpp"
#include "sim_hil/board/plant_clock.hpp"
#include "sim_hil/protocol.hpp"

namespace sinew::sim_hil {

/// Counts of one device, for the validity report.
struct DeviceStats {
  std::string name;
  DeviceKind kind = DeviceKind::imu;
  std::uint32_t samples = 0;    // received (commands sent, for actuators)
  std::uint32_t lost = 0;       // missing by stamp or frame number, or overwritten before being read
  std::uint32_t late = 0;       // arrived long after `ready`, or in lockstep after a grant that promised them
  std::uint32_t overflow = 0;   // nobody read the device in time (refused commands, for actuators)
  Duration max_gap_stamp{0};    // between two samples, as measured
  Duration max_gap_arrival{0};  // as they arrived; free-running only
  std::uint32_t received_kib = 0;
};

/// What the devices of one board share.
struct SimShared {
  const hal::Clock* clock = nullptr;
  bool lockstep = true;
  Duration late_after{0};
  PlantClock plant_clock;          // zero in lockstep
  std::atomic<bool> ended{false};  // release after the reason has been written
  Time granted{-1};                // lockstep
};

/// A message's times: as the plant wrote them, and on the runtime's clock with its arrival.
struct Arrival {
  Time plant_stamp, plant_ready;
  Time stamp, ready, at;
};

/// Bookkeeping of one device that measures.
/// Thread:  take-side by the receiving thread, the counters may be read by any.
class SimDevice {
 public:
  SimDevice(const DeviceInfo& info, const SimShared& shared) : info_(info), shared_(shared) {}
  virtual ~SimDevice() = default;
  const DeviceInfo& info() const { return info_; }
  DeviceStats stats() const;
  /// A module asked for this device; devices without a reader are only counted. Before the start.
  virtual void want() { wanted_ = true; }
  bool wanted() const { return wanted_; }
  void notify() noexcept { wake_.ring(); }
  /// The plant was lost and a new connection made: order and gaps begin anew. `memory` holds the frames of this
  /// connection.
  virtual void relinked(const hal::SharedMemory* /*memory*/) { first_ = true; }

 protected:
  /// Checks the order of a sample and counts gaps and lateness. Makes its times go forward on the runtime's clock as
  /// they do on the plant's. Errors: bad_data when the plant breaks the order.
  hal::Status account(Arrival& a, std::size_t bytes) noexcept;
  void count_lost(std::uint32_t n) noexcept { add(lost_, n); }
  void count_overflow(std::uint32_t n) noexcept { add(overflow_, n); }
  std::uint32_t overflows() const noexcept { return overflow_.load(std::memory_order_relaxed); }
  bool ended() const noexcept { return shared_.ended.load(std::memory_order_acquire); }

  /// Drops what a device with a queue of `depth` would have dropped by now, oldest first; answers how many are left.
  template <class Item>
  std::size_t trim(hal::SampleRing<Item>& queue, std::size_t depth) noexcept {
    const Time now = shared_.lockstep ? shared_.clock->now() : hal::kNever;
    const std::size_t size = queue.size();
    std::size_t ready = 0;
    if (!shared_.lockstep) ready = size;
    while (ready < size && queue.at(ready).ready <= now) ++ready;
    for (; ready > depth; --ready) {
      queue.pop();
      count_overflow(1);
    }
    return ready;
  }
  template <class Item>
  Time earliest(const hal::SampleRing<Item>& queue) const noexcept {
    return queue.size() > 0 ? queue.at(0).ready : hal::kNever;
  }

  const DeviceInfo info_;
  const SimShared& shared_;
  void change_wake(hal::Wake* wake) noexcept { wake_.change(wake); }

 private:
  static void add(std::atomic<std::uint32_t>& counter, std::uint32_t n) noexcept {
    counter.fetch_add(n, std::memory_order_relaxed);
  }
  bool wanted_ = false;
  hal::WakeSlot wake_;
  bool first_ = true;
  Arrival last_{};
  std::size_t spare_bytes_ = 0;  // below one KiB
  std::atomic<std::uint32_t> samples_{0}, lost_{0}, late_{0}, overflow_{0}, kib_{0}, gap_stamp_us_{0},
      gap_arrival_us_{0};
};

/// Imu, Range, Baro or Battery; and what a radio hears.
template <class M, class Interface = hal::Sensor<M>>
class SimSensor : public Interface, public SimDevice {
 public:
  SimSensor(const DeviceInfo& info, const SimShared& shared, std::size_t capacity, std::size_t depth)
      : SimDevice(info, shared), queue_(capacity), depth_(depth) {}

  hal::Status take(const Sample<M>& sample, Arrival arrival, std::size_t bytes) noexcept {
    if (auto ok = account(arrival, bytes); !ok || !wanted()) return ok;
    Waiting waiting{arrival.ready, sample.value};
    waiting.value.stamp = arrival.stamp;
    if (!queue_.push(waiting)) count_overflow(1);
    return {};
  }

  hal::Result<bool> read(M& out) noexcept override {
    if (trim(queue_, depth_) == 0) {
      if (ended() && queue_.size() == 0) return hal::Error{hal::Errc::closed, "the plant ended the run"};
      return false;
    }
    out = queue_.at(0).value;
    queue_.pop();
    return true;
  }
  Time ready_at() const noexcept override { return earliest(queue_); }
  void set_wake(hal::Wake* wake) noexcept override { change_wake(wake); }

 private:
  struct Waiting {
    Time ready;
    M value;
  };
  hal::SampleRing<Waiting> queue_;
  std::size_t depth_;
};

/// The robot's station in the plant's air. What is not read in time is lost, the oldest first, and said so by the next
/// datagram.
class SimRadio final : public SimSensor<msg::Datagram, hal::Radio> {
 public:
  /// Puts a datagram on the line, with its commit.
  using Send = std::function<hal::Status(const Transmission&)>;
  SimRadio(const DeviceInfo& info, const SimShared& shared, std::size_t capacity, std::size_t depth, Send send)
      : SimSensor(info, shared, capacity, depth), send_(std::move(send)) {}

  hal::Result<bool> read(msg::Datagram& out) noexcept override;
  hal::Status send(std::span<const std::uint8_t> bytes) noexcept override;
  hal::RadioStats stats() const noexcept override;

 private:
  Send send_;
  Transmission outgoing_;        // the sender's
  std::uint32_t told_lost_ = 0;  // the reader's
  hal::Tally sent_, sent_bytes_, tx_lost_, received_, received_bytes_;
};

/// Frames wait in the plant's shared memory, or in a pool of this object when they came in the stream.
class SimCamera final : public hal::Camera, public SimDevice {
 public:
  SimCamera(const DeviceInfo& info, const SimShared& shared, const hal::SharedMemory* memory, std::size_t depth);

  void want() override;
  void relinked(const hal::SharedMemory* memory) override;

  /// Room for the pixels of a frame that comes in the stream; empty: no reader, or no room (counted).
  std::span<std::uint8_t> room() noexcept;
  /// `stored`: the pixels are in the slot that `info` names, or have been put into room().
  hal::Status take(const FrameInfo& info, Arrival arrival, std::size_t bytes, bool stored) noexcept;
  /// Checks a frame against the Welcome. Errors: bad_data.
  hal::Status check(const FrameInfo& info) const noexcept;

  hal::Result<bool> read(msg::Image& out) noexcept override;
  Time ready_at() const noexcept override { return earliest(queue_); }
  void set_wake(hal::Wake* wake) noexcept override { change_wake(wake); }

 private:
  struct Waiting {
    Time ready, stamp;
    FrameInfo info;
    std::size_t pool_index = 0;
    const hal::SharedMemory* memory = nullptr;  // where its slot is; null: in the pool
  };
  bool copy(const Waiting& frame, std::uint8_t* to) const noexcept;

  const hal::SharedMemory* memory_;  // receiver's: the plant's; null: frames come in the stream
  hal::SampleRing<Waiting> queue_;
  std::size_t depth_;
  std::vector<std::uint8_t> pool_;  // queue capacity x frame
  bool first_ = true;
  std::uint32_t last_number_ = 0;
};

}  // namespace sinew::sim_hil
