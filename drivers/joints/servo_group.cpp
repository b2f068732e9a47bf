#include "drivers/joints/servo_group.hpp"

#include <algorithm>
#include <cmath>

namespace sinew::drivers {
namespace {

constexpr Duration kWell = std::chrono::seconds(1);  // ready for so long on end

/// Warmth and a limit do not make a joint less ready.
bool is_ready(const ServoFeedback& f) {
  constexpr std::uint32_t kWarnings = msg::kJointDerated | msg::kJointLimit;
  return f.mode == msg::JointMode::enabled && (f.faults & ~kWarnings) == 0;
}

}  // namespace

std::size_t ServoGroup::place(JointHub& hub) {
  auto it = std::find(hubs_.begin(), hubs_.end(), &hub);
  if (it == hubs_.end()) {
    hubs_.push_back(&hub);
    latched_.emplace_back();
    it = hubs_.end() - 1;
  }
  joints_[count_].hub = static_cast<std::size_t>(it - hubs_.begin());
  return count_++;
}

// ---- the guardian's side ----

hal::Status ServoGroup::hand_over(Setpoints setpoints) noexcept {
  setpoints.number = handed_.number + 1;
  handed_ = setpoints;
  setpoints_.store(setpoints);
  for (JointHub* hub : hubs_) hub->poke();
  return {};
}

hal::Status ServoGroup::write(const msg::ActuatorCommand& command, Duration lease) noexcept {
  if (command.count != count_) return hal::Error{hal::Errc::bad_argument, "channels of a command", command.count};
  Setpoints setpoints;
  for (std::size_t i = 0; i < count_; ++i) {
    if (!std::isfinite(command.value[i])) {
      return hal::Error{hal::Errc::bad_argument, "setpoint is not finite", static_cast<std::int64_t>(i)};
    }
    setpoints.value[i] = command.value[i];
  }
  const std::int64_t now = os_.now().ns, room = hal::kNever.ns - now;
  setpoints.until_ns = lease.count() < room ? now + lease.count() : hal::kNever.ns;
  setpoints.armed = command.armed != 0;
  return hand_over(setpoints);
}

hal::Status ServoGroup::stop() noexcept { return hand_over({}); }

hal::Status ServoGroup::fall_back(hal::FallBack how) noexcept {
  Setpoints over = handed_;  // armed as it was: this neither arms nor disarms
  over.limp = how == hal::FallBack::limp;
  if (over.until_ns == 0 && over.limp == handed_.limp) return {};
  over.until_ns = 0;
  return hand_over(over);
}

void ServoGroup::request(std::size_t joint, ServoCommand::Request what) noexcept {
  if (joint >= count_) return;
  std::atomic<std::uint32_t>& word = joints_[joint].request;
  std::uint32_t before = word.load(std::memory_order_relaxed);
  while (!word.compare_exchange_weak(before, ((before >> 2) + 1) << 2 | static_cast<std::uint32_t>(what),
                                     std::memory_order_relaxed)) {  // relaxed: kind and number are one word
  }
}

// ---- the hubs' side ----

void ServoGroup::latch(const JointHub& hub) noexcept {
  for (std::size_t i = 0; i < hubs_.size(); ++i) {
    if (hubs_[i] == &hub) (void)setpoints_.load(latched_[i]);  // met the writer too often: keeps the last tick's
  }
}

ServoCommand ServoGroup::command(std::size_t index, Time now) noexcept {
  using Intent = ServoCommand::Intent;
  const Joint& joint = joints_[index];
  const Setpoints& setpoints = latched_[joint.hub];
  ServoCommand command;
  command.setpoint = setpoints.value[index];
  command.number = setpoints.number;
  command.disarmed = !setpoints.armed;
  if (setpoints.armed && !setpoints.limp) {
    command.intent = now.ns < setpoints.until_ns ? Intent::follow : Intent::stop;
  }
  watch(joints_[index], command.intent == Intent::follow, now);
  const std::uint32_t request = joint.request.load(std::memory_order_relaxed);
  command.request = static_cast<ServoCommand::Request>(request & 3);
  command.request_number = request >> 2;
  return command;
}

void ServoGroup::watch(Joint& joint, bool wanted, Time now) noexcept {
  if (!joint.ready) joint.ready_since = now;
  if (!wanted || joint.absent || now - joint.ready_since >= kWell || joint.well_at.ns == 0) joint.well_at = now;
  joint.refusing = now - joint.well_at;
}

void ServoGroup::feedback(std::size_t index, const ServoFeedback& feedback) noexcept {
  Joint& joint = joints_[index];
  joint.ready = is_ready(feedback);
  ServoFeedback said = feedback;
  said.refusing = joint.refusing;
  joint.feedback.store(said);
  joint.number = feedback.number;
  joint.absent = feedback.mode == msg::JointMode::absent;
}

void ServoGroup::settled(const JointHub& hub, bool tick) noexcept {
  if (&hub != hubs_.front()) return;
  if (tick) {
    if (!published_this_tick_) publish();
    published_this_tick_ = false;
  } else if (all_measured_anew()) {
    publish();
    published_this_tick_ = true;
  }
}

bool ServoGroup::all_measured_anew() const noexcept {
  bool any = false;
  for (std::size_t i = 0; i < count_; ++i) {
    const Joint& joint = joints_[i];
    if (joint.hub != 0 || joint.absent) continue;
    if (joint.number == joint.published) return false;
    any = true;
  }
  return any;
}

void ServoGroup::publish() noexcept {
  for (std::size_t i = 0; i < count_; ++i) {
    if (joints_[i].hub == 0) joints_[i].published = joints_[i].number;
  }
  const std::uint32_t head = head_.load(std::memory_order_relaxed);
  // acquire: pairs with read()'s release, so that the slot has been read before it is written again
  if (head - tail_.load(std::memory_order_acquire) == kRing) {
    lost_.add();
    compose(beside_.sample);
    beside_.head = head;
    beside_.any = true;
    newest_.store(beside_);
  } else {
    compose(ring_[head % kRing]);
    head_.store(head + 1, std::memory_order_release);  // pairs with read()'s acquire: the sample lies before it
  }
  wake_.ring();
}

void ServoGroup::compose(msg::JointState& out) noexcept {
  out = {};
  out.count = static_cast<std::uint32_t>(count_);
  Time oldest = hal::kNever, newest{};
  for (std::size_t i = 0; i < count_; ++i) {
    ServoFeedback& f = joints_[i].last;
    (void)joints_[i].feedback.load(f);
    out.measured[i] = f.measured;
    out.position_rad[i] = f.position_rad;
    out.velocity_radps[i] = f.velocity_radps;
    out.effort_nm[i] = f.effort_nm;
    out.temperature_c[i] = f.temperature_c;
    out.voltage_v[i] = f.voltage_v;
    out.mode[i] = f.mode;
    out.faults[i] = f.faults;
    out.fault_code[i] = f.fault_code;
    if (is_ready(f)) out.ready |= 1u << i;
    if (f.measured > newest) newest = f.measured;
    if (f.mode != msg::JointMode::absent && f.measured.ns != 0 && f.measured < oldest) oldest = f.measured;
  }
  out.stamp = oldest == hal::kNever ? newest : oldest;  // no joint is there: the newest that was
}

// ---- the reader's side ----

hal::Result<bool> ServoGroup::read(msg::JointState& out) noexcept {
  const std::uint32_t head = head_.load(std::memory_order_acquire);
  std::uint32_t tail = tail_.load(std::memory_order_relaxed);
  if (head == tail) return false;
  if (head - tail < kRing) {
    out = ring_[tail % kRing];
    tail_.store(tail + 1, std::memory_order_release);
    return true;
  }
  // The reader was away for long: only the newest sample is useful. It lies beside the ring when the ring was full.
  lost_.add(kRing - 1);
  out = ring_[(head - 1) % kRing];
  Beside beside;
  if (newest_.load(beside) && beside.any && beside.head == head) out = beside.sample;
  tail_.store(head, std::memory_order_release);
  return true;
}

Time ServoGroup::ready_at() const noexcept {
  const bool waiting = head_.load(std::memory_order_acquire) != tail_.load(std::memory_order_relaxed);
  return waiting ? Time{} : hal::kNever;
}

}  // namespace sinew::drivers
