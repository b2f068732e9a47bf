#include "sim_hil/server/plant_link.hpp"

#include <algorithm>
#include <atomic>

namespace sinew::sim_hil {
namespace {

using hal::Errc;
using hal::Error;
using hal::Result;
using hal::Status;

constexpr std::size_t kOutBytes = 2 * kMaxSmallBytes;
constexpr Duration kLastWords = std::chrono::seconds(2);  // free-running: how long Bye may wait for a slow peer

std::size_t round_up(std::size_t bytes, std::size_t to) { return (bytes + to - 1) / to * to; }
std::size_t slot_bytes(const DeviceInfo& camera) {
  return round_up(kSlotHeaderBytes + camera.frame_bytes(), kSlotHeaderBytes);
}

std::atomic_ref<std::uint32_t> generation_of(std::byte* slot) {
  // A slot begins on a cache line.
  return std::atomic_ref<std::uint32_t>(*static_cast<std::uint32_t*>(static_cast<void*>(slot)));
}

}  // namespace

std::size_t PlantLink::frame_memory_bytes(const PlantDescription& plant) {
  std::size_t bytes = 0;
  for (const DeviceInfo& d : plant.devices)
    if (d.kind == DeviceKind::camera) bytes += kFrameSlots * slot_bytes(d);
  return bytes;
}

PlantLink::PlantLink(Caller caller, PlantDescription plant)
    : stream_(std::move(caller.stream)),
      plant_(std::move(plant)),
      hello_(std::move(caller.hello)),
      in_(std::move(caller.in)),
      out_(kOutBytes),
      groups_(plant_.devices.size()),
      cameras_(plant_.devices.size()) {
  if (std::ranges::find(plant_.devices, DeviceKind::radio, &DeviceInfo::kind) != plant_.devices.end())
    sent_.resize(kMostSent);
}

Result<std::unique_ptr<PlantLink>> PlantLink::accept(std::unique_ptr<hal::Stream> stream, PlantDescription plant,
                                                     hal::SharedMemory* frames, std::string& why) {
  Caller caller;
  caller.stream = std::move(stream);
  if (auto ok = hear_hello(caller, plant.name, why); !ok) return ok.error();
  return accept(std::move(caller), std::move(plant), frames, why);
}

Result<std::unique_ptr<PlantLink>> PlantLink::accept(Caller caller, PlantDescription plant, hal::SharedMemory* frames,
                                                     std::string& why) {
  if (caller.hello.mode == Mode::side_line) {
    why = "this plant waits for a runtime and takes no side line";
    turn_away(*caller.stream, why);
    return Error{Errc::not_supported, "sim link: side line"};
  }
  std::unique_ptr<PlantLink> link(new PlantLink(std::move(caller), std::move(plant)));
  const std::size_t needed = frame_memory_bytes(link->plant_);
  if (frames && needed > 0 && frames->size() >= needed && link->hello_.accepts_shared_memory && link->stream_->local())
    link->frames_ = frames;
  if (auto ok = link->send_welcome(); !ok) {
    why = link->reason_;
    return ok.error();
  }
  return link;
}

Status PlantLink::send_welcome() {
  std::uint64_t offset = 0;
  for (std::size_t i = 0; i < plant_.devices.size(); ++i) {
    DeviceInfo& d = plant_.devices[i];
    d.slots = 0, d.slots_offset = 0, d.slot_bytes = 0;
    if (d.kind != DeviceKind::camera) continue;
    if (frames_) {
      d.slots = kFrameSlots, d.slots_offset = offset, d.slot_bytes = static_cast<std::uint32_t>(slot_bytes(d));
      offset += std::uint64_t{d.slots} * d.slot_bytes;
    } else {
      cameras_[i].staging.resize(std::size_t{kStagingSlots} * d.frame_bytes());
    }
  }
  Welcome welcome;
  welcome.step = plant_.step;
  welcome.seed = plant_.seed.value_or(hello_.seed);
  welcome.shared_bytes = frames_ ? frames_->size() : 0;
  welcome.plant = plant_.name;
  welcome.devices = plant_.devices;
  static_cast<void>(out_.add(Type::welcome, 0, Time{}, welcome));  // the buffer is empty and larger than any Welcome
  if (!frames_) return flush();
  auto sent = stream_->write_with_memory(out_.pending(), *frames_);
  stats_.bytes_out += out_.pending().size();
  out_.clear();
  return sent ? Status{} : fail(sent.error());
}

Status PlantLink::fail(Error error) {
  if (!state_) return state_;
  if (reason_.empty()) reason_ = describe_failure(error, "connection to the runtime failed");
  state_ = error;
  if (error.code == Errc::bad_data) bye(reason_);  // the peer learns why before the line goes dead
  return state_;
}

Status PlantLink::flush() {
  if (!state_) return state_;
  const Bytes pending = out_.pending();
  if (running_) return push(pending, {});
  if (pending.empty()) return {};
  auto sent = stream_->write(pending);
  stats_.bytes_out += pending.size();
  out_.clear();
  return sent ? Status{} : fail_write(sent.error());
}

/// Free-running: `head` are the bytes in out_. RT: no allocation, room was made in start_clock().
Status PlantLink::push(Bytes head, Bytes tail) {
  Status ok = alone_ ? Status{} : push_backlog();
  stats_.bytes_out += head.size() + tail.size();
  for (Bytes part : {head, tail}) {
    if (!ok || alone_ || part.empty()) continue;
    std::size_t sent = 0;
    if (backlog_.empty()) {
      auto n = stream_->write_now(part);
      if (n)
        sent = *n;
      else
        ok = n.error();
    }
    if (ok && backlog_.size() + part.size() > backlog_.capacity()) {  // makes room: drops bytes that were sent
      backlog_.erase(backlog_.begin(), backlog_.begin() + static_cast<std::ptrdiff_t>(backlog_sent_));
      backlog_sent_ = 0;
    }
    if (ok) backlog_.insert(backlog_.end(), part.begin() + static_cast<std::ptrdiff_t>(sent), part.end());
  }
  out_.clear();
  return ok ? ok : fail_write(ok.error());
}

Status PlantLink::push_backlog() {
  if (backlog_.empty()) return {};
  auto n = stream_->write_now(Bytes(backlog_).subspan(backlog_sent_));
  if (!n) return n.error();
  backlog_sent_ += *n;
  if (backlog_sent_ == backlog_.size()) backlog_.clear(), backlog_sent_ = 0;
  return {};
}

void PlantLink::go_alone() {
  alone_ = true;
  state_ = {};
  out_.clear();
  backlog_.clear();
  backlog_sent_ = 0;
}

/// The runtime hung up while we wrote. Its Bye may have come before, with the reason.
Status PlantLink::fail_write(Error error) {
  for (Message message; state_;) {
    auto next = in_.next(message);
    if (!next) break;
    if (*next) {
      if (message.header.type == Type::bye) return take(message);
      continue;
    }
    auto n = stream_->read_now(in_.space());
    if (!n || *n == 0) break;
    in_.filled(*n);
  }
  return fail(error);
}

/// The next message, waiting for it.
Status PlantLink::receive(Message& out) {
  for (;;) {
    auto next = in_.next(out);
    if (!next) return fail(next.error());
    if (*next) return {};
    auto n = stream_->read(in_.space());
    if (!n) return fail(n.error());
    in_.filled(*n);
    stats_.bytes_in += *n;
  }
}

Status PlantLink::wait_start() {
  if (!state_) return state_;
  Message message;
  if (auto ok = receive(message); !ok) return ok;
  if (message.header.type == Type::bye) return take(message);
  if (message.header.type != Type::start) return fail({Errc::bad_data, "message before Start"});
  return {};
}

Status PlantLink::start_clock(Time now, Time host_now) {
  if (!state_) return state_;
  if (!out_.add(Type::clock, 0, now, ClockInfo{host_now.ns, hello_.rate})) return Error{Errc::bad_argument, "no room"};
  std::size_t largest_frame = 0;
  for (const DeviceInfo& d : plant_.devices) largest_frame = std::max<std::size_t>(largest_frame, d.frame_bytes());
  backlog_.reserve(kMaxSmallBytes + kOutBytes + kHeaderBytes + kFrameBytes + (frames_ ? 0 : largest_frame));
  stream_->set_patience(kLastWords);
  running_ = true;
  return flush();
}

template <class Payload>
Status PlantLink::add(Type type, std::uint16_t device, Time time, const Payload& payload, std::size_t bulk) {
  if (!state_ || alone_) return state_;
  if (crowded() && bulk == 0) {  // a frame was checked in send_frame() already
    ++stats_.samples_dropped;
    return {};
  }
  time = clock_.to_robot(time);
  if (out_.add(type, device, time, payload, bulk)) return {};
  if (auto ok = flush(); !ok) return ok;
  static_cast<void>(out_.add(type, device, time, payload, bulk));  // an empty buffer holds any message
  return {};
}

Status PlantLink::expect_kind(std::uint16_t device, DeviceKind kind) const {
  if (device >= plant_.devices.size() || plant_.devices[device].kind != kind)
    return Error{Errc::bad_argument, "plant has no such device of this kind", device};
  return {};
}

Status PlantLink::send(std::uint16_t device, const msg::ImuSample& sample, Time ready) {
  if (auto ok = expect_kind(device, DeviceKind::imu); !ok) return ok;
  return add(Type::imu, device, sample.stamp, Sample<msg::ImuSample>{clock_.to_robot(ready), sample});
}
Status PlantLink::send(std::uint16_t device, const msg::RangeSample& sample, Time ready) {
  if (auto ok = expect_kind(device, DeviceKind::range); !ok) return ok;
  return add(Type::range, device, sample.stamp, Sample<msg::RangeSample>{clock_.to_robot(ready), sample});
}
Status PlantLink::send(std::uint16_t device, const msg::BaroSample& sample, Time ready) {
  if (auto ok = expect_kind(device, DeviceKind::baro); !ok) return ok;
  return add(Type::baro, device, sample.stamp, Sample<msg::BaroSample>{clock_.to_robot(ready), sample});
}
Status PlantLink::send(std::uint16_t device, const msg::BatterySample& sample, Time ready) {
  if (auto ok = expect_kind(device, DeviceKind::battery); !ok) return ok;
  return add(Type::battery, device, sample.stamp, Sample<msg::BatterySample>{clock_.to_robot(ready), sample});
}
Status PlantLink::send(std::uint16_t device, const msg::SolePressure& sample, Time ready) {
  if (auto ok = expect_kind(device, DeviceKind::soles); !ok) return ok;
  return add(Type::soles, device, sample.stamp, Sample<msg::SolePressure>{clock_.to_robot(ready), sample});
}

Status PlantLink::send(std::uint16_t device, const msg::RefereeState& sample, Time ready) {
  if (auto ok = expect_kind(device, DeviceKind::referee); !ok) return ok;
  return add(Type::referee, device, sample.stamp, Sample<msg::RefereeState>{clock_.to_robot(ready), sample});
}
Status PlantLink::send(std::uint16_t device, const msg::JointState& state, Time ready) {
  if (auto ok = expect_kind(device, DeviceKind::joints); !ok) return ok;
  if (state.count != plant_.devices[device].channels)
    return Error{Errc::bad_argument, "joint state does not have one entry per channel", state.count};
  Sample<msg::JointState> sample{clock_.to_robot(ready), state};
  for (Time& measured : sample.value.measured)
    if (measured.ns != 0) measured = clock_.to_robot(measured);
  return add(Type::joints, device, state.stamp, sample);
}
Status PlantLink::send(std::uint16_t device, const msg::Datagram& datagram, Time ready) {
  if (auto ok = expect_kind(device, DeviceKind::radio); !ok) return ok;
  return add(Type::datagram, device, datagram.stamp, Sample<msg::Datagram>{clock_.to_robot(ready), datagram});
}
Status PlantLink::send_truth(Time now, const Truth& truth) { return add(Type::truth, 0, now, truth); }

Status PlantLink::send_report(Time now, std::string_view json) {
  if (auto ok = flush(); !ok || alone_ || crowded()) return ok;
  static_cast<void>(out_.add_text(Type::report, clock_.to_robot(now), json));
  return flush();
}

FrameSlot PlantLink::begin_frame(std::uint16_t camera) {
  if (!expect_kind(camera, DeviceKind::camera)) return {};
  CameraState& state = cameras_[camera];
  const DeviceInfo& d = plant_.devices[camera];
  FrameSlot slot;
  slot.index = state.next;
  state.next = (state.next + 1) % (frames_ ? kFrameSlots : kStagingSlots);
  if (frames_) {
    std::byte* at = frames_->data() + d.slots_offset + std::size_t{slot.index} * d.slot_bytes;
    // exchange, not store: its acquire half keeps the pixels below from being written before the slot is marked
    generation_of(at).exchange(0, std::memory_order_acq_rel);
    slot.pixels = {reinterpret_cast<std::uint8_t*>(at + kSlotHeaderBytes), d.frame_bytes()};
  } else {
    slot.pixels = {state.staging.data() + std::size_t{slot.index} * d.frame_bytes(), d.frame_bytes()};
  }
  return slot;
}

Status PlantLink::send_frame(std::uint16_t camera, const FrameSlot& slot, const FrameMeta& meta) {
  if (auto ok = expect_kind(camera, DeviceKind::camera); !ok) return ok;
  CameraState& state = cameras_[camera];
  const DeviceInfo& d = plant_.devices[camera];
  FrameInfo info;
  info.ready = clock_.to_robot(meta.ready), info.exposure_ns = meta.exposure_ns, info.number = meta.number;
  info.width = d.width, info.height = d.height, info.format = d.format;
  if (frames_) {
    if (slot.index >= kFrameSlots) return Error{Errc::bad_argument, "no such frame slot", slot.index};
    if (++state.generation == 0) ++state.generation;
    info.slot = slot.index, info.generation = state.generation;
    std::byte* at = frames_->data() + d.slots_offset + std::size_t{slot.index} * d.slot_bytes;
    generation_of(at).store(info.generation, std::memory_order_release);  // pairs with the board's acquire load
    return add(Type::frame, camera, meta.stamp, info);
  }
  if (slot.pixels.size() != d.frame_bytes()) return Error{Errc::bad_argument, "not a slot of this camera"};
  if (running_) {  // pixels only go out when nothing waits: the samples after them wait long enough
    if (auto ok = flush(); !ok) return ok;
    if (alone_) return {};
    if (!backlog_.empty()) {
      ++stats_.frames_dropped;
      return {};
    }
  }
  if (auto ok = add(Type::frame, camera, meta.stamp, info, d.frame_bytes()); !ok) return ok;
  const Bytes pixels = std::as_bytes(std::span<const std::uint8_t>(slot.pixels));
  if (running_) return push(out_.pending(), pixels);
  auto sent = stream_->write(out_.pending(), pixels);
  stats_.bytes_out += out_.pending().size() + slot.pixels.size();
  out_.clear();
  return sent ? Status{} : fail_write(sent.error());
}

Status PlantLink::grant(Time until) {
  if (auto ok = begin_grant(until); !ok) return ok;
  return wait_done();
}

Status PlantLink::begin_grant(Time until) {
  if (!state_) return state_;
  if (out_.room() < kHeaderBytes)
    if (auto ok = flush(); !ok) return ok;
  until = clock_.to_robot(until);
  static_cast<void>(out_.add(Type::grant, 0, until));
  if (auto ok = flush(); !ok) return ok;
  granted_ = until;
  ++stats_.grants;
  answered_ = false;
  return {};
}

Status PlantLink::wait_done() {
  if (!state_) return state_;
  while (!answered_) {
    Message message;
    if (auto ok = receive(message); !ok) return ok;
    if (auto ok = take(message); !ok) return ok;
  }
  return {};
}

Status PlantLink::exchange() {
  if (auto ok = flush(); !ok || alone_) return ok;
  for (;;) {
    Message message;
    auto next = in_.next(message);
    if (!next) return fail(next.error());
    if (*next) {
      if (auto ok = take(message); !ok) return ok;
      continue;
    }
    auto n = stream_->read_now(in_.space());
    if (!n) return fail(n.error());
    if (*n == 0) return {};
    in_.filled(*n);
    stats_.bytes_in += *n;
  }
}

Status PlantLink::take(const Message& message) {
  const Header& h = message.header;
  switch (h.type) {
    case Type::done:
      if (hello_.mode != Mode::lockstep || h.time != granted_)
        return fail({Errc::bad_data, "Done does not answer the last Grant", h.time.ns});
      answered_ = true;
      return {};
    case Type::command: {
      Timed timed{clock_.to_plant(h.time), {}, false};
      if (auto ok = decode(h, message.payload, timed.command); !ok) return fail(ok.error());
      timed.command.setpoints.stamp = clock_.to_plant(timed.command.setpoints.stamp);
      if (!expect_kind(h.device, DeviceKind::actuators) ||
          timed.command.setpoints.count != plant_.devices[h.device].channels)
        return fail({Errc::bad_data, "command does not fit the actuator group", h.device});
      ++stats_.commands;
      return take_timed(h.device, timed);
    }
    case Type::transmit:
      return take_transmission(message);
    case Type::stop:
      ++stats_.stops;
      for (std::uint16_t i = 0; i < static_cast<std::uint16_t>(groups_.size()); ++i)
        if (expect_kind(i, DeviceKind::actuators) && (h.device == kAllGroups || h.device == i))
          if (auto ok = take_timed(i, {clock_.to_plant(h.time), {}, true}); !ok) return ok;
      return {};
    case Type::bye:
      bye_came_ = true;
      reason_ = decode_text(message.payload);
      return fail({Errc::closed, "runtime ended the run"});
    default:
      return fail({Errc::bad_data, "message does not belong here", std::int64_t(h.type)});
  }
}

Status PlantLink::take_transmission(const Message& message) {
  const Header& h = message.header;
  if (!expect_kind(h.device, DeviceKind::radio)) return fail({Errc::bad_data, "no such radio", h.device});
  const Time commit = clock_.to_plant(h.time);
  if (commit < last_sent_) return fail({Errc::bad_data, "commit times go backwards", h.time.ns});
  last_sent_ = commit;
  if (sent_count_ == sent_.size()) {
    ++stats_.datagrams_dropped;
    return {};
  }
  Sent& sent = sent_[sent_count_];
  if (auto ok = decode(h, message.payload, sent.datagram); !ok) return fail(ok.error());
  sent.device = h.device;
  sent.commit = commit;
  ++sent_count_;
  return {};
}

Status PlantLink::take_timed(std::uint16_t device, const Timed& timed) {
  Group& group = groups_[device];
  if (timed.commit < group.last_commit) return fail({Errc::bad_data, "commit times go backwards", timed.commit.ns});
  group.last_commit = timed.commit;
  if (group.count == kPendingCommands) {  // the oldest makes room; a plant that steps often never sees this
    group.first = (group.first + 1) % kPendingCommands;
    --group.count;
    ++stats_.commands_overwritten;
  }
  group.pending[(group.first + group.count++) % kPendingCommands] = timed;
  return {};
}

Setpoints PlantLink::setpoints_at(std::uint16_t device, Time t) {
  Setpoints out;
  if (stopped_for_good_ || !expect_kind(device, DeviceKind::actuators)) return out;
  Group& group = groups_[device];
  while (group.count > 0 && group.pending[group.first].commit <= t) {
    group.active = group.pending[group.first];
    group.first = (group.first + 1) % kPendingCommands;
    --group.count;
    group.any = true;
  }
  const msg::ActuatorCommand& c = group.active.command.setpoints;
  const bool wanted = group.any && !group.active.stop && c.armed == 1;
  const bool leased = wanted && t.ns - group.active.commit.ns < group.active.command.lease.count();
  if (group.running && wanted && !leased) ++stats_.lease_expiries;
  group.running = leased;
  out.valid = leased;
  out.lease_over = wanted && !leased;
  out.count = c.count;
  if (group.any) out.commit = group.active.commit, out.stamp = c.stamp, out.lease = group.active.command.lease;
  if (leased) out.value = c.value;
  return out;
}

void PlantLink::bye(std::string_view reason) {
  if (said_bye_) return;
  said_bye_ = true;
  if (alone_) return;
  if (out_.room() < kMaxSmallBytes) static_cast<void>(flush());
  static_cast<void>(out_.add_text(Type::bye, Time{}, reason));
  // The peer may be gone already; then nobody needs the reason.
  static_cast<void>(stream_->write(Bytes(backlog_).subspan(backlog_sent_), out_.pending()));
  out_.clear();
  backlog_.clear();
  backlog_sent_ = 0;
}

}  // namespace sinew::sim_hil
