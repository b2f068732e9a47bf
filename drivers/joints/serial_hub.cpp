#include "drivers/joints/serial_hub.hpp"

#include <algorithm>

#include "drivers/key_number.hpp"

namespace sinew::drivers {
namespace {

using namespace std::chrono_literals;
using wire::DxlBuilder;
using wire::DxlInstruction;
using wire::DxlPacket;
using wire::DxlVersion;

constexpr Duration kReopen = 500ms;
constexpr Duration kFirstDelay = 600us;  // a servo that is not set up yet waits 500 us before it answers
constexpr Duration kThink = 100us;       // of a servo, beside its return delay
constexpr Duration kQuiet = 20ms;        // longer than the 16 ms for which an adapter (FTDI) may keep bytes
constexpr Duration kOwed = 100ms;        // after so long nobody answers any more
constexpr int kOftenLate = 3;

}  // namespace

SerialHub::SerialHub(hal::Os& os, std::unique_ptr<hal::Serial> line, Opener reopen, const SerialHubConfig& config)
    : os_(os),
      line_(std::move(line)),
      open_(std::move(reopen)),
      config_(config),
      period_(static_cast<std::int64_t>(1e9 / config.rate.tick_hz)) {}

SerialHub::~SerialHub() { stop(); }

JointServo& SerialHub::add(std::unique_ptr<SerialServo> servo, ServoOwner& owner, std::size_t index) {
  servos_.push_back({std::move(servo), &owner, index});
  if (std::find(owners_.begin(), owners_.end(), &owner) == owners_.end()) owners_.push_back(&owner);
  return *servos_.back().servo;
}

hal::Status SerialHub::configure(std::string& why) {
  std::vector<const SerialServo*> servos;
  for (const Entry& e : servos_) servos.push_back(e.servo.get());
  if (const auto clashes = find_serial_clashes(servos); !clashes.empty()) {
    const SerialClash& c = clashes.front();
    why = "servo '" + servos[c.second]->config().name + "': " + c.key + ": " + c.why;
  } else if (const SerialPlan plan = plan_serial(servos, config_.rate); !plan.fits()) {
    why = "tick_hz: " + to_string(plan);
  }
  if (!why.empty() || servos_.empty()) return hal::Error{hal::Errc::bad_argument, "serial hub"};
  reader_ = std::make_unique<wire::DxlReader>(version());
  groups_.clear(), goals_.clear(), torques_.clear();
  const auto same = [](const wire::ServoRegister& a, const wire::ServoRegister& b) {
    return a.address == b.address && a.size == b.size;
  };
  for (std::size_t i = 0; i < servos_.size(); ++i) {
    const SerialServo& s = *servos_[i].servo;
    const wire::ServoRegister cycle = s.model().cycle(), goal = s.goal_register();
    const CycleRead how = cycle_read(s.model(), config_.rate.fast_read);
    auto group = std::find_if(groups_.begin(), groups_.end(),
                              [&](const Group& g) { return g.how == how && same(g.reg, cycle); });
    if (group == groups_.end()) group = groups_.insert(groups_.end(), Group{how, cycle, {}});
    group->members.push_back(i);
    const auto once = [&](std::vector<wire::ServoRegister>& all, const wire::ServoRegister& reg) {
      if (std::none_of(all.begin(), all.end(), [&](const auto& r) { return same(r, reg); })) all.push_back(reg);
    };
    once(goals_, goal);
    once(torques_, s.model().torque_enable);
  }
  waiting_.members.reserve(servos_.size());
  return {};
}

// ---- its thread ----

hal::Status SerialHub::start() {
  ending_.store(false, std::memory_order_relaxed);  // the thread is made after it
  auto thread = os_.start_thread(config_.thread, [this] { run(); });
  if (!thread) return thread.error();
  thread_ = std::move(*thread);
  return {};
}

void SerialHub::stop() {
  if (!thread_) return;
  ending_.store(true, std::memory_order_release);  // pairs with run()'s
  ring();
  thread_.reset();  // joins
}

void SerialHub::run() {
  while (!ending_.load(std::memory_order_acquire)) {
    const std::uint32_t seen = word_.load(std::memory_order_seq_cst);
    recover(os_.now());
    const Time next = step(os_.now());
    if (has_line() &&
        waiting_.what != Waiting::For::nobody) {      // setpoints of meanwhile are taken when the answers are in
      static_cast<void>(line_->wait_readable(next));  // an error is found by the read that follows
      continue;
    }
    // As in CanHub::run(): at least one of the two sees the other's change.
    sleeping_.store(true, std::memory_order_seq_cst);
    os_.wait(word_, seen, next);
    sleeping_.store(false, std::memory_order_relaxed);
  }
  for (int i = 0; i < 2; ++i) take_torque([](const SerialServo&) { return true; });
}

void SerialHub::ring() noexcept {
  word_.fetch_add(1, std::memory_order_seq_cst);
  if (sleeping_.load(std::memory_order_seq_cst)) os_.wake(word_);
}

void SerialHub::poke() noexcept {
  poked_.store(true, std::memory_order_release);  // pairs with tick()'s exchange: the setpoint was written before
  ring();
}

Duration SerialHub::bytes_time(std::size_t bytes) const noexcept {
  return Duration{static_cast<std::int64_t>(bytes) * 10'000'000'000 / static_cast<std::int64_t>(config_.rate.bit_rate)};
}

Time SerialHub::step(Time now) noexcept {
  if (next_tick_.ns == 0) next_tick_ = now;
  read_line(now);
  if (waiting_.what != Waiting::For::nobody && now >= waiting_.deadline) wait_is_over(now);
  while (waiting_.what == Waiting::For::nobody && cycle_open_) {
    if (ask_next_group(now)) break;
    cycle_open_ = false;
    for (ServoOwner* owner : owners_) owner->settled(*this, false);
    const double took_s = msg::seconds(now - last_tick_);
    if (took_s > counters_.longest_s.load()) counters_.longest_s.store(took_s);
  }
  if (waiting_.what != Waiting::For::nobody) return waiting_.deadline;
  const Time earliest = last_tick_ + part_of(period_, kEarliestTick);
  const bool poked = poked_.load(std::memory_order_acquire);
  if (now >= next_tick_ || (poked && now >= earliest && last_tick_.ns != 0)) {
    if (last_tick_.ns != 0 && now - next_tick_ > period_) counters_.late_ticks.add();
    tick(now);
    if (waiting_.what != Waiting::For::nobody) return waiting_.deadline;
  }
  if (!cycle_open_ && ask_one(now, !slow_done_)) return waiting_.deadline;
  return poked ? std::min(next_tick_, last_tick_ + part_of(period_, kEarliestTick)) : next_tick_;
}

// ---- what comes in ----

void SerialHub::read_line(Time now) noexcept {
  std::array<std::uint8_t, 256> bytes;
  for (int i = 0; i < 16 && has_line(); ++i) {
    const auto n = line_->read_now(bytes);
    if (!n) {
      counters_.errors.add();
      if (n.error().code == hal::Errc::closed) line_is_gone(now);
      return;
    }
    for (std::size_t k = 0; k < *n; ++k) take_byte(bytes[k], now);
    if (*n < bytes.size()) return;
  }
}

/// An echo is what we sent, from its first byte on; anything else is an answer.
void SerialHub::take_byte(std::uint8_t byte, Time now) noexcept {
  const auto on_packet_now = [&](const DxlPacket& packet) { on_packet(packet, now); };
  if (echo_at_ < sent_size_) {
    if (byte == sent_[echo_at_]) {
      ++echo_at_;
      // Whole: it was one. Answers begin with the same bytes, but are no copy of it.
      if (echo_at_ == sent_size_)
        counters_.echoed.add(static_cast<std::uint32_t>(sent_size_)), sent_size_ = echo_at_ = 0;
      return;
    }
    const std::size_t held = echo_at_;
    sent_size_ = echo_at_ = 0;
    for (std::size_t i = 0; i < held; ++i) reader_->push(sent_[i], on_packet_now);
  }
  reader_->push(byte, on_packet_now);
}

void SerialHub::on_packet(const DxlPacket& packet, Time now) noexcept {
  const bool two = version() == DxlVersion::two;
  Waiting& w = waiting_;
  if (two && !packet.is(DxlInstruction::status)) return counters_.foreign.add();
  if (w.what == Waiting::For::nobody) return on_stray(packet, now);
  if (w.how == CycleRead::fast && w.what == Waiting::For::cycle) {
    wire::DxlFastParts parts(packet);
    wire::DxlFastPart part;
    for (; w.at < w.members.size() && parts.next(w.size, part); ++w.at)
      if (part.id == servos_[w.members[w.at]].servo->id()) on_answer(w.members[w.at], part.error, part.data, now);
    if (w.at == w.members.size()) wait_is_over(now);
    return;
  }
  // An answer without an error that has another size is to another question.
  const bool fits = packet.parameters.size() == w.size || servos_[w.members[w.at]].servo->refused(packet.error);
  for (std::size_t i = w.at; fits && i < w.members.size(); ++i) {
    if (servos_[w.members[i]].servo->id() != packet.id) continue;
    for (; w.at < i; ++w.at) {  // the answers before this one did not come
      counters_.missed.add();
      miss(w.members[w.at], now);
      servos_[w.members[w.at]].servo->on_missed();
    }
    ++w.at;
    on_answer(w.members[i], packet.error, packet.parameters, now);
    if (w.at == w.members.size()) wait_is_over(now);
    return;
  }
  on_stray(packet, now);
}

void SerialHub::miss(std::size_t servo, Time now) noexcept {
  Entry& e = servos_[servo];
  if (now - e.owed_at > kOwed) e.owed = 0;
  ++e.owed;
  e.owed_at = now;
}

/// Protocol 1.0: a whole echo of a question, of which the start was lost, is not told from an answer otherwise.
bool SerialHub::is_echo(const DxlPacket& packet) const noexcept {
  if (version() == DxlVersion::two || packet.parameters.empty() || packet.parameters[0] != question_.reg.address)
    return false;
  return packet.is(DxlInstruction::read) || packet.is(DxlInstruction::write);
}

/// An answer that nobody waits for now.
void SerialHub::on_stray(const DxlPacket& packet, Time now) noexcept {
  counters_.foreign.add();
  if (is_echo(packet)) return;
  if (packet.id == wire::kDxlBroadcast && version() == DxlVersion::two) return note_late(now);  // to a fast read
  for (std::size_t i = 0; i < servos_.size(); ++i) {
    Entry& e = servos_[i];
    if (e.servo->id() != packet.id) continue;
    if (e.owed > 0 && now - e.owed_at <= kOwed) {
      --e.owed;
      note_late(now);
    } else if (!is_late(now)) {
      e.servo->on_double(now);
      report(i);
    }
    return;
  }
}

void SerialHub::note_late(Time now) noexcept {
  counters_.late.add();
  if (now - late_at_ > 1s) lates_ = in_time_ = 0;
  late_at_ = now;
  ++lates_;
  if (!is_late(now)) return;
  quiet_until_ = now + kQuiet;
  line_late_ns_.store(now.ns);
}

/// Single ones are of bytes that were lost, or of a machine that was busy.
bool SerialHub::is_late(Time now) const noexcept {
  return lates_ >= kOftenLate && lates_ > in_time_ && now - late_at_ <= 1s;
}

void SerialHub::on_answer(std::size_t i, std::uint8_t error, std::span<const std::uint8_t> data, Time now) noexcept {
  counters_.answered.add();
  ++in_time_;
  if (waiting_.what == Waiting::For::cycle)
    servos_[i].servo->on_cycle(now, error, data);
  else
    servos_[i].servo->on_answer(now, error, data);
  report(i);
}

void SerialHub::report(std::size_t i) noexcept {
  servos_[i].owner->feedback(servos_[i].index, servos_[i].servo->feedback());
}

/// All have answered, or the time is over.
void SerialHub::wait_is_over(Time now) noexcept {
  Waiting& w = waiting_;
  if (w.at < w.members.size()) {
    // A wrong length may hide whole answers: they are looked for once, now that the line is silent.
    const std::size_t before = w.at;
    reader_->gap([&](const DxlPacket& packet) {
      if (waiting_.what != Waiting::For::nobody) on_packet(packet, now);
    });
    if (w.what == Waiting::For::nobody || (w.at > before && w.at == w.members.size())) return;
  }
  const bool cycle = w.what == Waiting::For::cycle, complete = w.at == w.members.size();
  if (cycle && w.how == CycleRead::fast) fast_failed_ = !complete;
  if (!complete) {
    counters_.missed.add(static_cast<std::uint32_t>(w.members.size() - w.at));
    for (std::size_t i = w.at; i < w.members.size(); ++i) miss(w.members[i], now);
    // These answers will come, too: not while others are waited for.
    if (is_late(now)) quiet_until_ = now + kQuiet;
    SerialServo& first = *servos_[w.members[w.at]].servo;
    if (!cycle)
      first.on_silence(now);
    else if (w.how != CycleRead::fast)
      first.on_missed();  // those behind it could not answer
    report(w.members[w.at]);
  }
  if (const std::uint64_t broken = reader_->stats().broken; broken != broken_seen_) {
    counters_.broken.add(static_cast<std::uint32_t>(broken - broken_seen_));
    broken_seen_ = broken;
  }
  w.what = Waiting::For::nobody;
  w.members.clear();
}

// ---- what goes out ----

bool SerialHub::send(DxlBuilder& packet, Time now) noexcept {
  const auto bytes = packet.finish();
  if (!has_line() || bytes.empty()) return false;
  const auto n = line_->write_now(bytes);
  if (!n || *n != bytes.size()) {
    counters_.errors.add();
    if (!n && n.error().code == hal::Errc::closed) line_is_gone(now);
    return false;
  }
  if (now >= busy_until_ && echo_at_ == 0) sent_size_ = 0;  // an echo of before would have come
  if (sent_size_ + bytes.size() <= sent_.size()) {
    std::copy(bytes.begin(), bytes.end(), sent_.begin() + static_cast<std::ptrdiff_t>(sent_size_));
    sent_size_ += bytes.size();
  }
  busy_until_ = std::max(busy_until_, now) + bytes_time(bytes.size());
  return true;
}

void SerialHub::tick(Time now) noexcept {
  const bool poked = poked_.exchange(false, std::memory_order_acq_rel);
  for (ServoOwner* owner : owners_) owner->latch(*this);
  for (std::size_t i = 0; i < servos_.size(); ++i) {
    servos_[i].servo->tick(now, servos_[i].owner->command(servos_[i].index, now));
    report(i);
  }
  last_tick_ = now;
  write_goals();
  take_torque([](const SerialServo& servo) { return servo.loses_torque(); });
  group_ = member_ = 0;
  cycle_open_ = true;
  slow_done_ = false;
  for (ServoOwner* owner : owners_) owner->settled(*this, true);
  if (poked)
    next_tick_ = now + part_of(period_, kLatestTick);  // waits for the next setpoint
  else
    next_tick_ = now - next_tick_ < period_ && now >= next_tick_ ? next_tick_ + period_ : now + period_;
  counters_.ticks.add();
  if (!ask_next_group(now)) cycle_open_ = false;
}

void SerialHub::write_goals() noexcept {
  for (const wire::ServoRegister& reg : goals_) {
    DxlBuilder packet = wire::dxl_sync_write(version(), reg.address, reg.size);
    bool any = false;
    for (const Entry& e : servos_) {
      const wire::ServoRegister& of = e.servo->goal_register();
      std::int32_t value = 0;
      if (of.address != reg.address || of.size != reg.size || !e.servo->goal(value)) continue;
      packet.byte(e.servo->id()).bytes(wire::servo_bytes(e.servo->model(), of, value));
      any = true;
    }
    if (any) send(packet, last_tick_);
  }
}

/// In one packet for all, which nobody answers.
void SerialHub::take_torque(bool (*from)(const SerialServo&)) noexcept {
  for (const wire::ServoRegister& reg : torques_) {
    DxlBuilder packet = wire::dxl_sync_write(version(), reg.address, reg.size);
    bool any = false;
    for (const Entry& e : servos_) {
      if (e.servo->model().torque_enable.address != reg.address || !from(*e.servo)) continue;
      packet.byte(e.servo->id()).byte(0);
      any = true;
    }
    if (any) send(packet, os_.now());
  }
}

/// Asks the next servos of this cycle. False: all have been asked, or the line is to be silent.
bool SerialHub::ask_next_group(Time now) noexcept {
  if (now < quiet_until_) return false;
  for (; group_ < groups_.size(); ++group_, member_ = 0) {
    const Group& group = groups_[group_];
    Waiting& w = waiting_;
    w.members.clear();
    std::array<std::uint8_t, 256> ids;
    std::size_t n = 0;
    for (; member_ < group.members.size(); ++member_) {
      const std::size_t i = group.members[member_];
      if (!servos_[i].servo->in_cycle()) continue;
      w.members.push_back(i);
      ids[n++] = servos_[i].servo->id();
      if (group.how == CycleRead::single) {
        ++member_;
        break;
      }
    }
    if (n == 0) continue;
    w.how = group.how == CycleRead::fast && fast_failed_ ? CycleRead::sync : group.how;
    fast_failed_ = false;
    w.size = group.reg.size, w.at = 0;
    const DxlVersion v = version();
    const std::span<const std::uint8_t> asked(ids.data(), n);
    DxlBuilder packet = wire::dxl_read(v, ids[0], group.reg.address, group.reg.size);
    if (w.how == CycleRead::sync || w.how == CycleRead::fast) {
      packet = wire::dxl_sync_read(v, group.reg.address, group.reg.size, asked, w.how == CycleRead::fast);
    } else if (w.how == CycleRead::bulk) {
      std::array<wire::DxlPlace, 256> places;
      for (std::size_t k = 0; k < n; ++k) places[k] = {ids[k], group.reg.address, group.reg.size};
      packet = wire::dxl_bulk_read(v, {places.data(), n});
    }
    if (!send(packet, now)) {
      w.members.clear();
      return false;
    }
    counters_.asked.add();
    w.what = Waiting::For::cycle;
    const std::size_t bytes =
        w.how == CycleRead::fast ? wire::dxl_fast_status_bytes(n, w.size) : n * wire::dxl_status_bytes(v, w.size);
    w.deadline = busy_until_ + bytes_time(bytes) + kThink * static_cast<std::int64_t>(n) + config_.rate.latency;
    return true;
  }
  return false;
}

/// One question to one servo: those that wait for one first, then all in turn. `first`: the one that each cycle has
/// time for; others only as long as the next tick does not have to wait for them.
bool SerialHub::ask_one(Time now, bool first) noexcept {
  if (now < quiet_until_) return false;
  const Duration most = bytes_time(wire::dxl_instruction_bytes(version(), 4) + wire::dxl_status_bytes(version(), 10)) +
                        kFirstDelay + kThink + config_.rate.latency;
  if (!first && now + most > last_tick_ + part_of(period_, kEarliestTick)) return false;
  slow_done_ = true;
  for (const bool urgent : {true, false}) {
    if (!urgent && !first) return false;  // time that is left goes to the urgent ones
    for (std::size_t k = 0; k < servos_.size(); ++k) {
      const std::size_t i = (turn_ + k) % servos_.size();
      SerialServo& servo = *servos_[i].servo;
      if (servo.is_urgent(now) != urgent) continue;
      LineQuestion q;
      if (!servo.ask(now, q)) continue;
      turn_ = i + 1;
      const DxlVersion v = version();
      DxlBuilder packet = wire::dxl_read(v, servo.id(), q.reg.address, q.reg.size);
      if (q.kind == LineQuestion::Kind::write)
        packet = wire::dxl_write(v, servo.id(), q.reg.address, wire::servo_bytes(servo.model(), q.reg, q.value));
      else if (q.kind == LineQuestion::Kind::reboot)
        packet = wire::dxl_reboot(v, servo.id());
      if (!send(packet, now)) {
        servo.on_silence(now);
        return false;
      }
      counters_.asked.add();
      waiting_.what = Waiting::For::question;
      waiting_.members.assign(1, i);
      waiting_.at = 0;
      waiting_.how = CycleRead::single;
      waiting_.size = q.answer_size();
      question_ = q;
      waiting_.deadline = busy_until_ + bytes_time(wire::dxl_status_bytes(v, q.answer_size())) + kThink + kFirstDelay +
                          config_.rate.latency;
      return true;
    }
  }
  return false;
}

// ---- the line itself ----

void SerialHub::line_is_gone(Time now) noexcept {
  gone_.store(true, std::memory_order_relaxed);
  next_open_ = now + kReopen;
  waiting_.what = Waiting::For::nobody;
  waiting_.members.clear();
  cycle_open_ = false;
  sent_size_ = echo_at_ = 0;
  reader_->gap();
}

void SerialHub::recover(Time now) noexcept {
  if (has_line() || !open_ || now < next_open_) return;
  line_.reset();  // held exclusively: the old one first
  next_open_ = now + kReopen;
  std::string why;
  auto line = open_(why);
  if (!line) return;
  line_ = std::move(*line);
  gone_.store(false, std::memory_order_relaxed);
}

std::string SerialHub::trouble() const {
  if (gone_.load(std::memory_order_relaxed)) return "the serial line is gone (unplugged?)";
  const std::int64_t late_ns = line_late_ns_.load();
  if (late_ns == 0 || os_.now() - Time{late_ns} > 1s) return "";
  return "answers come after their time (the adapter's latency timer? latency_ms is " +
         key_number(msg::seconds(config_.rate.latency) * 1e3) + ")";
}

SerialHubStats SerialHub::stats() const noexcept {
  SerialHubStats s;
  s.ticks = counters_.ticks.value(), s.late_ticks = counters_.late_ticks.value();
  s.asked = counters_.asked.value(), s.answered = counters_.answered.value(), s.missed = counters_.missed.value(),
  s.late = counters_.late.value();
  s.foreign = counters_.foreign.value(), s.broken = counters_.broken.value();
  s.echoed = counters_.echoed.value(), s.errors = counters_.errors.value();
  s.longest_cycle_s = counters_.longest_s.load();
  return s;
}

}  // namespace sinew::drivers
