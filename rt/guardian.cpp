#include "rt/guardian.hpp"

#include <algorithm>

namespace sinew::rt {

using msg::GuardianMode;

struct Guardian::Group {
  explicit Group(const ActuatorSpec& s) : spec(s) {}

  std::uint32_t faults_of(const msg::ActuatorCommand& command, Time published) const;
  void judge(Time now);
  void write_state(Time now);
  void act(Time now);

  ActuatorSpec spec;
  In<msg::ActuatorCommand> command;
  Out<msg::GuardianState> state;
  hal::Actuators* device = nullptr;

  GuardianMode mode = GuardianMode::standby;
  std::uint32_t faults = 0, fault_events = 0;
  bool device_refused = false;
  bool has_good = false;  // since it was last disarmed
  msg::ActuatorCommand good{};
  Time good_published{};
};

Guardian::Guardian(const std::vector<ActuatorSpec>& actuators) {
  for (const ActuatorSpec& a : actuators) groups_.push_back(std::make_unique<Group>(a));
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
  }
}

hal::Status Guardian::configure(Setup& setup) {
  hal::Status first;
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
    g->faults = g->fault_events = 0;
    g->device_refused = g->has_good = false;
    g->good = {};
  }
}

Status Guardian::step(const Step& step) noexcept {
  for (const auto& g : groups_) {
    g->judge(step.now);
    g->write_state(step.now);
  }
  return Status::ok;
}

void Guardian::emit(Time now) noexcept {
  for (const auto& g : groups_) g->act(now);
}

std::uint32_t Guardian::Group::faults_of(const msg::ActuatorCommand& c, Time published) const {
  if (c.count != spec.channels) return msg::kFaultCount;
  std::uint32_t found = 0;
  const bool compare = has_good && spec.rate_per_s > 0 && published != good_published;
  const double most = spec.rate_per_s * msg::seconds(published - good_published);
  for (std::uint32_t i = 0; i < c.count; ++i) {
    const double v = c.value[i];
    if (v - v != 0) {
      found |= msg::kFaultNotFinite;
      continue;
    }
    if (v < spec.min || v > spec.max) found |= msg::kFaultLimit;
    const double change = v - good.value[i];
    if (compare && (change > most || change < -most)) found |= msg::kFaultRate;
  }
  return found;
}

/// Decides from the latched command what may go out.
void Guardian::Group::judge(Time now) {
  const std::uint32_t before = faults;
  const msg::ActuatorCommand* c = command.get();
  faults = device_refused ? msg::kFaultDevice : msg::kFaultNone;
  if (!c || !c->armed) {
    has_good = false;
    mode = faults ? GuardianMode::safe : GuardianMode::standby;
  } else {
    const Time published = command.header(0)->published;
    const std::uint32_t wrong = faults_of(*c, published);
    if (!wrong) {
      good = *c;
      good_published = published;
      has_good = true;
    }
    faults |= wrong;
    if (now - published >= spec.lease) faults |= msg::kFaultLease;
    const bool idle = std::all_of(c->value.begin(), c->value.begin() + std::min<std::size_t>(c->count, c->value.size()),
                                  [](double v) { return v == 0; });
    mode = faults ? GuardianMode::safe : idle ? GuardianMode::armed : GuardianMode::active;
  }
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
  const bool passes = mode == GuardianMode::armed || mode == GuardianMode::active;
  const bool holds = mode == GuardianMode::safe && spec.safe == ActuatorSpec::Safe::hold && has_good;
  if (passes || holds) s.value = good.value;
  for (std::size_t i = spec.channels; i < s.value.size(); ++i) s.value[i] = 0;
}

void Guardian::Group::act(Time now) {
  hal::Status done;
  if (mode == GuardianMode::armed || mode == GuardianMode::active) {
    const Duration left = spec.lease - (now - good_published);
    done = left > Duration{0} ? device->write(good, left) : device->stop();
  } else if (mode == GuardianMode::safe && spec.safe == ActuatorSpec::Safe::hold && has_good) {
    done = device->write(good, spec.lease);
  } else {
    done = device->stop();
  }
  device_refused = !done;
}

}  // namespace sinew::rt
