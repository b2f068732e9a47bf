#include "sim_hil/plant/actuator_faults.hpp"

#include <algorithm>

namespace sinew::plant {

sim_hil::Setpoints ActuatorFaults::act(const sim_hil::Setpoints& commanded, hal::Time now) {
  if (!faults_.any()) {
    acting_ = commanded;
  } else if (commanded.commit != last_commit_) {
    last_commit_ = commanded.commit;
    hear(commanded, now);
  }
  for (; !held_.empty() && held_.front().at <= now; held_.pop_front()) acting_ = held_.front().setpoints;
  sim_hil::Setpoints out = acting_;
  out.valid = acting_.valid && now < acting_.commit + acting_.lease;
  out.lease_over = acting_.valid && !out.valid;
  return out;
}

void ActuatorFaults::hear(sim_hil::Setpoints command, hal::Time now) {
  const FaultEffect effect = faults_.next(command.commit);
  if (effect.lost) return;
  if (effect.stuck && acting_.count > 0) command.value = acting_.value;
  if (effect.wrong) command.value[0] *= 1.0 - *effect.wrong;
  if (effect.garbage)
    for (double& value : command.value) value = faults_.random().uniform(least_, most_);
  last_at_ = std::max(now + effect.delay, last_at_);
  held_.push_back({command, last_at_});
}

}  // namespace sinew::plant
