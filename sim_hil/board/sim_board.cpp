#include "sim_hil/board/sim_board.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "sim_hil/board/sim_sending.hpp"

namespace sinew::sim_hil {

using hal::Errc;
using hal::Error;
using hal::Result;
using hal::Status;

namespace {

constexpr std::size_t kLockstepQueue = 4096;  // samples of one device within one grant
constexpr std::size_t kRadioQueue = 256;      // datagrams likewise
Time clamp_time(Time t) { return {std::clamp<std::int64_t>(t.ns, 0, kMaxTimeNs)}; }

}  // namespace

/// One actuator group: its commands go out with the next grant, or at once when the plant runs freely.
class SimBoard::Group final : public hal::Actuators {
 public:
  Group(SimBoard& board, std::uint16_t id) : board_(board), id_(id) {}

  Status write(const msg::ActuatorCommand& command, Duration lease) noexcept override {
    return count(send(command, lease));
  }
  Status stop() noexcept override { return count(board_.send({Type::stop, id_})); }

  void count(DeviceStats& into) const {
    into.samples = sent_.load(std::memory_order_relaxed);
    into.overflow = refused_.load(std::memory_order_relaxed);
  }

 private:
  Status send(const msg::ActuatorCommand& command, Duration lease) noexcept {
    if (command.count != board_.welcome_.devices[id_].channels)
      return Error{Errc::bad_argument, "command does not have one setpoint per channel", command.count};
    for (std::uint32_t i = 0; i < command.count; ++i)
      if (!std::isfinite(command.value[i])) return Error{Errc::bad_argument, "setpoint is not finite", i};
    if (lease.count() <= 0) return Error{Errc::bad_argument, "lease is not positive", lease.count()};
    const Command timed{lease, command};
    return board_.send({Type::command, id_, &timed});
  }
  Status count(Status sent) noexcept {
    (sent ? sent_ : refused_).fetch_add(1, std::memory_order_relaxed);
    return sent;
  }

  std::atomic<std::uint32_t> sent_{0}, refused_{0};
  SimBoard& board_;
  std::uint16_t id_;
};

SimBoard::SimBoard(std::unique_ptr<hal::Stream> stream, const SimBoardOptions& options) : options_(options) {
  line_.stream = std::move(stream);
  shared_.clock = options_.clock;
  shared_.lockstep = options_.mode == Mode::lockstep;
  shared_.late_after = options_.late_after;
  line_.wait_for(options_.patience, &options_.silence);
}

SimBoard::~SimBoard() { bye("runtime closed the connection"); }

// ---- opening

Result<std::unique_ptr<SimBoard>> SimBoard::open(std::unique_ptr<hal::Stream> stream, const SimBoardOptions& options,
                                                 std::string& why) {
  if (!options.clock || (options.mode == Mode::free_running && !options.os)) {
    why = "the sim board needs a clock, and a free-running one an operating system";
    return Error{Errc::bad_argument, "sim board: no clock"};
  }
  std::unique_ptr<SimBoard> board(new SimBoard(std::move(stream), options));
  if (auto ok = board->shake_hands(why); !ok) return ok.error();
  return board;
}

Status SimBoard::shake_hands(std::string& why) {
  if (auto ok = line_.shake_hands(hello(), why); !ok) {
    said_bye_ = true;
    return ok;
  }
  welcome_ = line_.welcome;
  make_devices();
  return {};
}

Hello SimBoard::hello() const {
  return {kVersion, options_.mode, options_.rate, options_.seed, options_.accepts_shared_memory, options_.robot};
}

void SimBoard::make_devices() {
  const std::size_t depth = std::max<std::size_t>(options_.sensor_depth, 1);
  const std::size_t capacity = shared_.lockstep ? std::max(kLockstepQueue, depth) : 4 * depth;
  for (const DeviceInfo& info : welcome_.devices) {
    const auto id = static_cast<std::uint16_t>(devices_.size());
    std::unique_ptr<SimDevice>& device = devices_.emplace_back();
    std::unique_ptr<Group>& group = groups_.emplace_back();
    switch (info.kind) {
      case DeviceKind::imu:
        device = std::make_unique<SimSensor<msg::ImuSample>>(info, shared_, capacity, depth);
        break;
      case DeviceKind::range:
        device = std::make_unique<SimSensor<msg::RangeSample>>(info, shared_, capacity, depth);
        break;
      case DeviceKind::baro:
        device = std::make_unique<SimSensor<msg::BaroSample>>(info, shared_, capacity, depth);
        break;
      case DeviceKind::battery:
        device = std::make_unique<SimSensor<msg::BatterySample>>(info, shared_, capacity, depth);
        break;
      case DeviceKind::soles:
        device = std::make_unique<SimSensor<msg::SolePressure>>(info, shared_, capacity, depth);
        break;
      case DeviceKind::referee:
        device = std::make_unique<SimSensor<msg::RefereeState>>(info, shared_, capacity, depth);
        break;
      case DeviceKind::joints:
        device = std::make_unique<SimSensor<msg::JointState>>(info, shared_, capacity, depth);
        break;
      case DeviceKind::camera:
        device = std::make_unique<SimCamera>(info, shared_, line_.memory.get(),
                                             std::max<std::size_t>(options_.camera_depth, 1));
        break;
      case DeviceKind::radio:
        device =
            std::make_unique<SimRadio>(info, shared_, kRadioQueue, depth, [this, id](const Transmission& datagram) {
              return send({Type::transmit, id, nullptr, &datagram});
            });
        break;
      case DeviceKind::actuators:
        group = std::make_unique<Group>(*this, id);
        break;
    }
  }
}

// ---- devices by name

static std::optional<DeviceKind> kind_of(hal::SensorKind kind) {
  switch (kind) {
    case hal::SensorKind::imu:
      return DeviceKind::imu;
    case hal::SensorKind::range:
      return DeviceKind::range;
    case hal::SensorKind::baro:
      return DeviceKind::baro;
    case hal::SensorKind::battery:
      return DeviceKind::battery;
    case hal::SensorKind::joints:
      return DeviceKind::joints;
    case hal::SensorKind::soles:
      return DeviceKind::soles;
    case hal::SensorKind::referee:
      return DeviceKind::referee;
    default:
      return std::nullopt;
  }
}

template <class Wanted>
Result<Wanted*> SimBoard::find(std::string_view name, DeviceKind kind) {
  std::string known;
  for (std::size_t i = 0; i < welcome_.devices.size(); ++i) {
    const DeviceInfo& info = welcome_.devices[i];
    if (info.name == name && info.kind == kind) {
      if constexpr (std::is_same_v<Wanted, hal::Actuators>) {
        return static_cast<Wanted*>(groups_[i].get());
      } else {
        devices_[i]->want();
        return dynamic_cast<Wanted*>(devices_[i].get());
      }
    }
    known += std::string(known.empty() ? "" : ", ") + std::string(to_string(info.kind)) + " '" + info.name + "'";
  }
  problem_ = "plant '" + welcome_.plant + "' has no " + std::string(to_string(kind)) + " '" + std::string(name) +
             "'; it has: " + (known.empty() ? "nothing" : known);
  return Error{Errc::not_found, "plant has no device of this name and kind"};
}

Result<hal::Device*> SimBoard::open_sensor(hal::SensorKind kind, std::string_view name) {
  const auto wire_kind = kind_of(kind);
  if (!wire_kind) {
    problem_ = "simulated plants have no " + std::string(hal::to_string(kind)) + " '" + std::string(name) + "'";
    return Error{Errc::not_supported, "a kind of sensor that plants do not have"};
  }
  return find<hal::Device>(name, *wire_kind);
}
Result<hal::Camera*> SimBoard::camera(std::string_view name) { return find<hal::Camera>(name, DeviceKind::camera); }
Result<hal::Radio*> SimBoard::radio(std::string_view name) {
  if (shared_.lockstep || options_.send_lock) return find<hal::Radio>(name, DeviceKind::radio);
  problem_ = "this machine has no mutex that inherits priority, which a simulated radio needs in real time";
  return Error{Errc::not_supported, "a radio of the plant"};
}
Result<hal::Actuators*> SimBoard::actuators(std::string_view name) {
  return find<hal::Actuators>(name, DeviceKind::actuators);
}

// ---- running

Result<Time> SimBoard::begin() {
  auto first = next_grant(Time{});
  begun_ = first.has_value();
  return first;
}

Result<Time> SimBoard::next_grant(Time done_to) {
  if (ended()) return end_error_;
  if (!shared_.lockstep) return Error{Errc::not_supported, "a free-running plant grants nothing"};
  if (std::exchange(begun_, false)) return shared_.granted;
  if (!started_) {
    if (auto ok = start(); !ok) return ok.error();
  } else {
    if (done_to != shared_.granted) return Error{Errc::bad_argument, "done is not the last grant", done_to.ns};
    if (line_.out.room() < kHeaderBytes)
      if (auto ok = line_.flush(); !ok) return end(ok.error()).error();
    static_cast<void>(line_.out.add(Type::done, 0, done_to));
    if (auto ok = line_.flush(); !ok) return end(ok.error()).error();
  }
  for (;;) {
    Message message;
    if (auto ok = line_.receive(message); !ok) return end(ok.error()).error();
    if (message.header.type != Type::grant) {
      if (auto ok = take(message, Time{}); !ok) return end(ok.error()).error();
      continue;
    }
    const Time until = message.header.time;
    if (until < shared_.granted) return end({Errc::bad_data, "grants go back in time", until.ns}).error();
    shared_.granted = until;
    grants_.fetch_add(1, std::memory_order_relaxed);
    return until;
  }
}

SimDevice* SimBoard::device_of(std::uint16_t id, DeviceKind kind) {
  return id < devices_.size() && welcome_.devices[id].kind == kind ? devices_[id].get() : nullptr;
}

Arrival SimBoard::arrival_of(const Header& h, Time ready, Time at) {
  const Time stamp = shared_.plant_clock.map(h.time);
  return {h.time, ready, stamp, stamp + (ready - h.time), at};
}

template <class M>
Status SimBoard::take_sample(const Message& message, Time at, DeviceKind kind) {
  SimDevice* device = device_of(message.header.device, kind);
  if (!device) return Error{Errc::bad_data, "sample of a device that the Welcome does not list", message.header.device};
  Sample<M> sample;
  if (auto ok = decode(message.header, message.payload, sample); !ok) return ok;
  if constexpr (std::is_same_v<M, msg::JointState>) {
    if (sample.value.count != device->info().channels)
      return Error{Errc::bad_data, "joints are not as many as the Welcome announced", sample.value.count};
    for (Time& measured : sample.value.measured)
      if (measured.ns != 0) measured = shared_.plant_clock.map(measured);
  }
  using Reader = std::conditional_t<std::is_same_v<M, msg::Datagram>, SimRadio, SimSensor<M>>;
  auto* sensor = static_cast<Reader*>(device);
  auto ok = sensor->take(sample, arrival_of(message.header, sample.ready, at), message.header.size);
  if (ok && !shared_.lockstep) sensor->notify();
  return ok;
}

Status SimBoard::take_frame(const Message& message, Time at) {
  SimDevice* device = device_of(message.header.device, DeviceKind::camera);
  if (!device) return Error{Errc::bad_data, "frame of a camera that the Welcome does not list", message.header.device};
  auto* camera = static_cast<SimCamera*>(device);
  FrameInfo info;
  if (auto ok = decode(message.header, message.payload, info); !ok) return ok;
  if (auto ok = camera->check(info); !ok) return ok;
  bool stored = true;
  if (message.bulk_bytes > 0) {
    auto read = read_pixels(camera->room());
    if (!read) return read.error();
    stored = *read;
    if (!shared_.lockstep) at = shared_.clock->now();  // all of it has only arrived now
  }
  auto ok = camera->take(info, arrival_of(message.header, info.ready, at), message.header.size, stored);
  if (ok && !shared_.lockstep) camera->notify();
  return ok;
}

/// False: no room for them; next() then discards them as they come.
Result<bool> SimBoard::read_pixels(std::span<std::uint8_t> into) {
  if (into.size() != line_.in.bulk_left()) return false;
  into = into.subspan(line_.in.take_bulk(into));
  while (!into.empty()) {
    auto n = line_.read(std::as_writable_bytes(into));
    if (!n) return n.error();
    line_.in.bulk_filled(*n);
    into = into.subspan(*n);
  }
  return true;
}

Status SimBoard::take(const Message& message, Time at) {
  switch (message.header.type) {
    case Type::imu:
      return take_sample<msg::ImuSample>(message, at, DeviceKind::imu);
    case Type::range:
      return take_sample<msg::RangeSample>(message, at, DeviceKind::range);
    case Type::baro:
      return take_sample<msg::BaroSample>(message, at, DeviceKind::baro);
    case Type::battery:
      return take_sample<msg::BatterySample>(message, at, DeviceKind::battery);
    case Type::soles:
      return take_sample<msg::SolePressure>(message, at, DeviceKind::soles);
    case Type::referee:
      return take_sample<msg::RefereeState>(message, at, DeviceKind::referee);
    case Type::joints:
      return take_sample<msg::JointState>(message, at, DeviceKind::joints);
    case Type::datagram:
      return take_sample<msg::Datagram>(message, at, DeviceKind::radio);
    case Type::frame:
      return take_frame(message, at);
    case Type::truth: {
      Truth truth;
      if (auto ok = decode(message.header, message.payload, truth); !ok) return ok;
      if (options_.on_truth) options_.on_truth(shared_.plant_clock.map(message.header.time), truth);
      return {};
    }
    case Type::report:
      if (options_.on_report) options_.on_report(decode_text(message.payload));
      return {};
    case Type::bye:
      end_reason_ = decode_text(message.payload);
      bye_came_ = true;
      return end({Errc::closed, "the plant ended the run"});
    default:
      return Error{Errc::bad_data, "message does not belong here", std::int64_t(message.header.type)};
  }
}

// ---- the line

bool SimBoard::add(const Outgoing& out, Time commit) {
  if (out.command) return line_.out.add(out.type, out.device, commit, *out.command);
  if (out.datagram) return line_.out.add(out.type, out.device, commit, *out.datagram);
  return line_.out.add(out.type, out.device, commit);
}

Status SimBoard::send(Outgoing out) {
  if (ended()) return end_error_;
  if (!started_) {
    if (out.type == Type::stop) return {};  // nothing runs before the start
    return Error{Errc::bad_argument, "command before the start"};
  }
  const Sending sending(*this);
  if (!sending) return Error{Errc::closed, "the plant is away"};
  const Duration offset = shared_.plant_clock.offset();
  Time commit = clamp_time(shared_.clock->now() - offset);
  if (commit < last_commit_) commit = last_commit_;  // the plant clock was moved back
  last_commit_ = commit;
  if (!out.datagram) commands_.fetch_add(1, std::memory_order_relaxed);
  if (!out.command) return send_now(out, commit);
  Command on_plant_time = *out.command;
  on_plant_time.setpoints.stamp = clamp_time(out.command->setpoints.stamp - offset);
  out.command = &on_plant_time;
  return send_now(out, commit);
}

Status SimBoard::send_now(const Outgoing& out, Time commit) {
  if (shared_.lockstep) {
    if (add(out, commit)) return {};
    if (auto ok = line_.flush(); !ok) return end(ok.error());
    static_cast<void>(add(out, commit));
    return {};
  }
  // Dropping a command is better than a command that waits in a queue: the plant's lease runs out, as on a jammed bus.
  auto n = line_.stream->write_now(line_.out.pending());
  if (n) line_.out.sent(*n);
  if (n && line_.out.pending().empty()) {
    static_cast<void>(add(out, commit));
    n = line_.stream->write_now(line_.out.pending());
    if (n) line_.out.sent(*n);
    if (n) return {};
  }
  if (!out.datagram) commands_dropped_.fetch_add(1, std::memory_order_relaxed);
  if (!n) return n.error();
  return Error{Errc::busy, "the plant takes no commands"};
}

/// The first failure is the reason of the end; all later calls return it.
Status SimBoard::end(const Error& error) {
  if (ended()) return end_error_;
  end_error_ = error;
  if (ended_at_.ns == 0) ended_at_ = shared_.clock->now();
  if (end_reason_.empty()) end_reason_ = describe_failure(error, "connection to plant '" + welcome_.plant + "' ended");
  shared_.ended.store(true, std::memory_order_release);  // pairs with ended(): the reason was written before
  return error;
}

SimStats SimBoard::stats() const {
  SimStats s;
  for (std::size_t i = 0; i < devices_.size(); ++i) {
    if (devices_[i]) {
      s.devices.push_back(devices_[i]->stats());
      continue;
    }
    DeviceStats group;
    group.name = welcome_.devices[i].name;
    group.kind = welcome_.devices[i].kind;
    groups_[i]->count(group);
    s.devices.push_back(group);
  }
  s.grants = grants_.load(std::memory_order_relaxed);
  s.commands = commands_.load(std::memory_order_relaxed);
  s.commands_dropped = commands_dropped_.load(std::memory_order_relaxed);
  s.clock_offset = shared_.plant_clock.offset();
  s.remote = keeper_.has_value();
  if (keeper_) s.clock = keeper_->stats();
  const std::lock_guard lock(link_mutex_);
  s.outages = outages_;
  return s;
}

}  // namespace sinew::sim_hil
