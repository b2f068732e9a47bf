#include "rt/guardian.hpp"

#include <algorithm>

#include "math/elementary.hpp"

namespace sinew::rt {

using msg::GuardianMode;

struct Guardian::Group {
  explicit Group(const ActuatorSpec& s) : spec(s) {}

  std::uint32_t faults_of(const msg::ActuatorCommand& command, Time published) const;
  std::uint32_t values_of(const msg::ActuatorCommand& command) const;
  void tell_what_is_bad(msg::SafetyState& s) const;
  bool commanded() const { return command.get() && command.get()->armed; }
  bool fresh(Time now) const { return command.get() && now - command.header(0)->published < spec.lease; }
  bool good_to_arm() const;
  bool idle() const;
  bool passes() const { return mode == GuardianMode::armed || mode == GuardianMode::active; }
  bool holds() const { return mode == GuardianMode::safe && spec.safe == ActuatorSpec::Safe::hold && has_good; }
  void judge(Time now, const Arming& arming);
  void write_state(Time now);
  void act(Time now);
  hal::Status fall_back();

  ActuatorSpec spec;
  In<msg::ActuatorCommand> command;
  Out<msg::GuardianState> state;
  hal::Actuators* device = nullptr;

  GuardianMode mode = GuardianMode::standby;
  bool off = true;  // not permitted or not armed: stop() instead of a fault's fall_back()
  std::uint32_t faults = 0, fault_events = 0;
  bool device_refused = false;
  bool has_good = false;  // since it was last disarmed
  msg::ActuatorCommand good{};
  Time good_published{};
};

Guardian::Guardian(const GraphSpec& spec) : arming_(spec.guardian.arming, spec.failsafes) {
  for (const ActuatorSpec& a : spec.actuators) groups_.push_back(std::make_unique<Group>(a));
  for (const FailsafeSpec& f : spec.failsafes) failsafes_.push_back(std::make_unique<Failsafe>(f));
}

Guardian::~Guardian() = default;

Duration Guardian::check_interval(const std::vector<ActuatorSpec>& actuators) {
  Duration shortest = Duration{INT64_MAX};
  for (const ActuatorSpec& a : actuators) shortest = std::min(shortest, a.lease);
  return std::max(shortest / 2, Duration{1});
}

void Guardian::declare(Declaration& d) {
  for (const auto& g : groups_) {
    d.in(g->spec.name + "_command", g->command);
    d.out(g->spec.name, g->state);
    d.state(g->faults, g->fault_events, g->has_good, g->good, g->good_published);
  }
  d.out("state", state_);
  for (const auto& f : failsafes_) f->declare(d);
  arming_.declare_state(d);
}

hal::Status Guardian::configure(Setup& setup) {
  hal::Status first;
  for (const auto& f : failsafes_) f->configure();
  for (const auto& g : groups_) {
    auto opened = setup.board().actuators(g->spec.name);
    if (opened) {
      g->device = *opened;
    } else {
      setup.explain("actuators '" + g->spec.name + "' of the board: " + opened.error().where);
      if (first) first = opened.error();
    }
  }
  return first;
}

void Guardian::reset() {
  for (const auto& g : groups_) {
    g->mode = GuardianMode::standby;
    g->off = true;
    g->faults = g->fault_events = 0;
    g->device_refused = g->has_good = false;
    g->good = {};
  }
  for (const auto& f : failsafes_) f->reset();
  arming_.reset();
}

StepStatus Guardian::step(const Step& step) noexcept {
  Arming::Facts facts;
  facts.now = step.now;
  facts.conditions = look_at_conditions(step.now);
  facts.groups_good = facts.idle = true;
  for (const auto& g : groups_) {
    facts.groups_good = facts.groups_good && g->fresh(step.now) && g->good_to_arm() && !g->device_refused;
    facts.idle = facts.idle && g->idle();
    facts.commanded = facts.commanded || g->commanded();
  }
  arming_.step(facts);
  for (const auto& g : groups_) {
    g->judge(step.now, arming_);
    g->write_state(step.now);
  }
  write_state(step.now, facts.conditions);
  return StepStatus::ok;
}

std::uint32_t Guardian::look_at_conditions(Time now) noexcept {
  std::uint32_t conditions = 0;
  for (std::size_t i = 0; i < failsafes_.size(); ++i)
    if (failsafes_[i]->look(now)) conditions |= 1u << i;
  return conditions;
}

void Guardian::write_state(Time now, std::uint32_t conditions) noexcept {
  msg::SafetyState& s = state_.loan();
  s.stamp = now;
  s.permitted = arming_.permitted();
  s.ready = arming_.ready();
  s.action = arming_.action();
  s.conditions = conditions;
  s.latched = arming_.latched();
  s.acted = arming_.acted();
  s.disarmed = arming_.disarmed();
  for (std::size_t i = 0; i < failsafes_.size(); ++i) s.measured[i] = failsafes_[i]->measured();
  for (std::size_t i = 0; i < groups_.size(); ++i) {
    const Group& g = *groups_[i];
    const std::uint32_t bit = 1u << i;
    s.mode = std::max(s.mode, g.mode);
    if (g.mode == GuardianMode::active || g.holds()) s.groups_moving |= bit;
    if (s.permitted) continue;
    if (!g.fresh(now)) s.groups_without_command |= bit;
    if (g.command.get() && !g.good_to_arm()) {
      if (s.groups_bad_command == 0) g.tell_what_is_bad(s);
      s.groups_bad_command |= bit;
    }
    if (arming_.wants_idle() && !g.idle()) s.groups_not_idle |= bit;
    if (g.device_refused) s.groups_device_refused |= bit;
  }
}

void Guardian::emit(Time now) noexcept {
  for (const auto& g : groups_) g->act(now);
}

std::uint32_t Guardian::device_state() const noexcept {
  std::uint32_t refused = 0;
  for (std::size_t i = 0; i < groups_.size(); ++i) refused |= (groups_[i]->device_refused ? 1u : 0u) << i;
  return refused;
}

void Guardian::set_device_state(std::uint32_t refused) noexcept {
  for (std::size_t i = 0; i < groups_.size(); ++i) groups_[i]->device_refused = (refused >> i & 1) != 0;
}

void Guardian::shut_down() noexcept {
  for (const auto& g : groups_)
    if (g->device) static_cast<void>(g->device->stop());  // otherwise its lease ends it
}

std::uint32_t Guardian::Group::faults_of(const msg::ActuatorCommand& c, Time published) const {
  std::uint32_t found = values_of(c);
  if (found & msg::kFaultCount) return found;
  const bool compare = has_good && spec.rate_per_s > 0 && published != good_published;
  const double most = spec.rate_per_s * msg::seconds(published - good_published);
  for (std::uint32_t i = 0; i < c.count; ++i) {
    const double change = c.value[i] - good.value[i];
    if (compare && (change > most || change < -most)) found |= msg::kFaultRate;
  }
  return found;
}

std::uint32_t Guardian::Group::values_of(const msg::ActuatorCommand& c) const {
  if (c.count != spec.channels) return msg::kFaultCount;
  std::uint32_t found = 0;
  for (std::uint32_t i = 0; i < c.count; ++i) {
    const double v = c.value[i];
    if (!math::is_finite(v))
      found |= msg::kFaultNotFinite;
    else if (!spec.limit(i).holds(v))
      found |= msg::kFaultLimit;
  }
  return found;
}

/// Reports the first bad value that values_of() finds.
void Guardian::Group::tell_what_is_bad(msg::SafetyState& s) const {
  const msg::ActuatorCommand& c = *command.get();
  if (c.count != spec.channels) {
    s.bad_fault = msg::kFaultCount;
    s.bad_value = c.count;
    return;
  }
  for (std::uint32_t i = 0; i < c.count && s.bad_fault == 0; ++i) {
    const double v = c.value[i];
    s.bad_channel = i;
    s.bad_value = v;
    if (!math::is_finite(v))
      s.bad_fault = msg::kFaultNotFinite;
    else
      s.bad_fault = spec.limit(i).holds(v) ? msg::kFaultNone : msg::kFaultLimit;
  }
}

/// A disarmed command may hold any values, but must be one of this group.
bool Guardian::Group::good_to_arm() const {
  const msg::ActuatorCommand* c = command.get();
  return c && (c->armed ? values_of(*c) == 0 : c->count == spec.channels);
}

bool Guardian::Group::idle() const {
  const msg::ActuatorCommand* c = command.get();
  if (!c || !c->armed) return true;
  const std::size_t used = std::min<std::size_t>(c->count, c->value.size());
  return std::all_of(c->value.data(), c->value.data() + used, [](double v) { return v == 0; });
}

/// Decides from the latched command what may go out.
void Guardian::Group::judge(Time now, const Arming& arming) {
  const std::uint32_t before = faults;
  const bool permitted = arming.permitted(), stopped = arming.action() == msg::FailsafeAction::stop;
  const msg::ActuatorCommand* c = command.get();
  if (!permitted && !stopped) has_good = false;  // a command that never went out is not held
  faults = device_refused ? msg::kFaultDevice : msg::kFaultNone;
  if (!c || !c->armed) {
    has_good = false;
    mode = faults ? GuardianMode::safe : GuardianMode::standby;
  } else {
    const Time published = command.header(0)->published;
    const std::uint32_t wrong = faults_of(*c, published);
    if (!wrong && permitted) {
      good = *c;
      good_published = published;
      has_good = true;
    }
    faults |= wrong;
    if (now - published >= spec.lease) faults |= msg::kFaultLease;
    const GuardianMode live = idle() ? GuardianMode::armed : GuardianMode::active;
    mode = permitted ? live : GuardianMode::standby;
    if (faults) mode = GuardianMode::safe;
  }
  if (stopped) {
    faults |= msg::kFaultFailsafe;
    mode = GuardianMode::safe;
  }
  off = !permitted || !c || !c->armed;  // a failsafe's stop ends the permission
  if (faults && !before) ++fault_events;
}

void Guardian::Group::write_state(Time now) {
  msg::GuardianState& s = state.loan();
  s.stamp = now;
  s.count = spec.channels;
  s.mode = mode;
  s.faults = faults;
  s.fault_events = fault_events;
  if (const msg::ActuatorCommand* c = command.get()) s.command_stamp = c->stamp;
  if (passes() || holds()) s.value = good.value;
  for (std::size_t i = spec.channels; i < s.value.size(); ++i) s.value[i] = 0;
}

hal::Status Guardian::Group::fall_back() {
  const bool limp = spec.safe == ActuatorSpec::Safe::torque_off;
  return device->fall_back(limp ? hal::FallBack::limp : hal::FallBack::own);
}

void Guardian::Group::act(Time now) {
  hal::Status done;
  if (passes()) {
    const Duration left = spec.lease - (now - good_published);
    done = left > Duration{0} ? device->write(good, left) : fall_back();
  } else if (holds()) {
    done = device->write(good, spec.lease);
  } else {
    done = off ? device->stop() : fall_back();
  }
  device_refused = !done;
}

}  // namespace sinew::rt
