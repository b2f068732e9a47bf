#include "sim_hil/board/sim_devices.hpp"

#include <algorithm>

namespace sinew::sim_hil {
namespace {

using hal::Errc;
using hal::Error;
using hal::Result;
using hal::Status;

constexpr std::size_t kFrameQueue = 8;

std::uint32_t to_us(Duration d) {
  return static_cast<std::uint32_t>(std::clamp<std::int64_t>(d.count() / 1000, 0, 0xFFFFFFFF));
}

void raise(std::atomic<std::uint32_t>& to, std::uint32_t value) {
  if (value > to.load(std::memory_order_relaxed)) to.store(value, std::memory_order_relaxed);
}

/// The first word of a slot, which another process writes. False: the slot holds another frame.
bool holds(const hal::SharedMemory& memory, std::size_t slot, std::uint32_t generation) {
  std::uint32_t word = 0;
  return memory.copy(slot, std::as_writable_bytes(std::span(&word, 1))) && word == generation;
}

}  // namespace

Status SimDevice::account(Arrival& a, std::size_t bytes) noexcept {
  add(samples_, 1);
  spare_bytes_ += bytes;
  add(kib_, static_cast<std::uint32_t>(spare_bytes_ / 1024));
  spare_bytes_ %= 1024;
  const bool late = shared_.lockstep ? a.ready <= shared_.granted : a.at - a.ready > shared_.late_after;
  if (late) add(late_, 1);
  a.stamp = std::max(a.stamp, last_.stamp);  // a clock that is corrected, or a plant that came back
  a.ready = std::max(a.ready, last_.ready);
  if (!first_) {
    if (a.plant_stamp < last_.plant_stamp || a.plant_ready < last_.plant_ready)
      return Error{Errc::bad_data, "samples of a device go back in time", a.plant_stamp.ns};
    const Duration gap = a.plant_stamp - last_.plant_stamp;
    raise(gap_stamp_us_, to_us(gap));
    if (!shared_.lockstep) raise(gap_arrival_us_, to_us(a.at - last_.at));
    const std::int64_t period = info_.period.count();
    if (period > 0 && info_.kind != DeviceKind::camera && gap.count() > period + period / 2)
      count_lost(static_cast<std::uint32_t>(std::min<std::int64_t>((gap.count() + period / 2) / period - 1, 0xFFFF)));
  }
  first_ = false;
  last_ = a;
  return {};
}

DeviceStats SimDevice::stats() const {
  const auto get = [](const std::atomic<std::uint32_t>& c) { return c.load(std::memory_order_relaxed); };
  DeviceStats s;
  s.name = info_.name, s.kind = info_.kind;
  s.samples = get(samples_), s.lost = get(lost_), s.late = get(late_), s.overflow = get(overflow_);
  s.max_gap_stamp = std::chrono::microseconds(get(gap_stamp_us_));
  s.max_gap_arrival = std::chrono::microseconds(get(gap_arrival_us_));
  s.received_kib = get(kib_);
  return s;
}

Result<bool> SimRadio::read(msg::Datagram& out) noexcept {
  auto got = SimSensor::read(out);
  if (!got || !*got) return got;
  out.lost = overflows() - told_lost_;
  told_lost_ += out.lost;
  received_.add();
  received_bytes_.add(out.size);
  return got;
}

Status SimRadio::send(std::span<const std::uint8_t> bytes) noexcept {
  if (bytes.empty() || bytes.size() > outgoing_.data.size())
    return Error{Errc::bad_argument, "a datagram has 1 to 1200 bytes", std::int64_t(bytes.size())};
  outgoing_.size = static_cast<std::uint32_t>(bytes.size());
  std::ranges::copy(bytes, outgoing_.data.begin());
  const Status sent = send_(outgoing_);
  if (sent) sent_bytes_.add(outgoing_.size);
  (sent ? sent_ : tx_lost_).add();
  return sent;
}

hal::RadioStats SimRadio::stats() const noexcept {
  hal::RadioStats s;
  s.received = received_.value(), s.received_bytes = received_bytes_.value();
  s.sent = sent_.value(), s.sent_bytes = sent_bytes_.value();
  s.rx_lost = overflows(), s.tx_lost = tx_lost_.value();
  return s;
}

SimCamera::SimCamera(const DeviceInfo& info, const SimShared& shared, const hal::SharedMemory* memory,
                     std::size_t depth)
    : SimDevice(info, shared), memory_(info.slots > 0 ? memory : nullptr), queue_(kFrameQueue), depth_(depth) {
  if (!memory_) return;
  // The plant keeps the newest slots - 2 frames whole; frames under way use some of these.
  const std::int64_t period = info.period.count();
  const std::int64_t under_way = period > 0 ? (info.latency.count() + period - 1) / period : 0;
  const std::int64_t whole = std::int64_t{info.slots} - 2 - under_way;
  depth_ = static_cast<std::size_t>(std::clamp<std::int64_t>(whole, 1, static_cast<std::int64_t>(depth)));
}

void SimCamera::want() {
  SimDevice::want();
  if (!memory_) pool_.resize(queue_.capacity() * info_.frame_bytes());
}

std::span<std::uint8_t> SimCamera::room() noexcept {
  if (!wanted() || pool_.empty() || queue_.full()) return {};
  return {pool_.data() + queue_.next_index() * info_.frame_bytes(), info_.frame_bytes()};
}

Status SimCamera::check(const FrameInfo& info) const noexcept {
  if (info.width != info_.width || info.height != info_.height || info.format != info_.format)
    return Error{Errc::bad_data, "frame is not what the Welcome announced", info.width};
  if (info.slot == kInStream ? memory_ != nullptr : !memory_ || info.slot >= info_.slots)
    return Error{Errc::bad_data, "frame is in a slot that does not exist", info.slot};
  return {};
}

void SimCamera::relinked(const hal::SharedMemory* memory) {
  SimDevice::relinked(memory);
  first_ = true;
  if (memory_) memory_ = memory;
}

Status SimCamera::take(const FrameInfo& info, Arrival arrival, std::size_t bytes, bool stored) noexcept {
  if (auto ok = account(arrival, bytes); !ok) return ok;
  const std::uint32_t step = info.number - last_number_;
  if (!first_ && step > 1 && step < 0x80000000) count_lost(step - 1);
  first_ = false;
  last_number_ = info.number;
  if (!wanted()) return {};
  if (!stored || !queue_.push({arrival.ready, arrival.stamp, info, queue_.next_index(), memory_})) count_overflow(1);
  return {};
}

bool SimCamera::copy(const Waiting& frame, std::uint8_t* to) const noexcept {
  const std::size_t bytes = info_.frame_bytes();
  if (!frame.memory) {
    std::memcpy(to, pool_.data() + frame.pool_index * bytes, bytes);
    return true;
  }
  const std::uint64_t place = info_.slots_offset + std::uint64_t{frame.info.slot} * info_.slot_bytes;
  const auto slot = static_cast<std::size_t>(place);
  if (slot != place) return false;  // beyond what this machine could map
  const std::span pixels(reinterpret_cast<std::byte*>(to), bytes);
  if (!holds(*frame.memory, slot, frame.info.generation)) return false;
  if (!frame.memory->copy(slot + kSlotHeaderBytes, pixels)) return false;
    // Only a fence keeps the pixels' loads before the second look: the writer is another process, which we cannot hold
    // back. ThreadSanitizer knows no fences and sees no other process either.
#ifndef __SANITIZE_THREAD__
  std::atomic_thread_fence(std::memory_order_acquire);
#endif
  return holds(*frame.memory, slot, frame.info.generation);
}

Result<bool> SimCamera::read(msg::Image& out) noexcept {
  if (trim(queue_, depth_) == 0) {
    if (ended() && queue_.size() == 0) return Error{Errc::closed, "the plant ended the run"};
    return false;
  }
  const Waiting& frame = queue_.at(0);
  const bool fits = out.format_as(frame.info.format, frame.info.width, frame.info.height);
  const bool whole = fits && copy(frame, out.pixels());
  out.stamp = frame.stamp;
  out.exposure_ns = frame.info.exposure_ns;
  out.frame_number = frame.info.number;
  queue_.pop();
  if (!fits) return Error{Errc::bad_argument, "frame is larger than the image message", info_.frame_bytes()};
  if (!whole) {
    count_lost(1);
    return Error{Errc::bad_data, "frame was overwritten before it was read"};
  }
  return true;
}

}  // namespace sinew::sim_hil
