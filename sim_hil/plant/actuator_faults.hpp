#pragma once
#include <deque>

#include "sim_hil/server/plant_link.hpp"
#include "sim_hil/worlds/world.hpp"

namespace sinew::plant {

/// Stands between the newest command and the actuators, and treats a command as a sample for them, with its commit as
/// stamp. The lease still counts from the commit.
/// Thread:  owner.
class ActuatorFaults {
 public:
  /// `actuators`: the group of the world, with the range of garbage setpoints.
  ActuatorFaults(FaultLog& log, const WorldDevice& actuators)
      : least_(actuators.least), most_(actuators.most), faults_(log, actuators.fault) {}
  /// What the actuators do in the plant step that starts at `now`, when `commanded` is the newest command. The lease
  /// runs here too, whether or not commands still come in.
  sim_hil::Setpoints act(const sim_hil::Setpoints& commanded, hal::Time now);

 private:
  struct Held {
    sim_hil::Setpoints setpoints;
    hal::Time at;
  };
  void hear(sim_hil::Setpoints command, hal::Time now);

  const double least_, most_;
  DeviceFaults faults_;
  std::deque<Held> held_;
  sim_hil::Setpoints acting_;
  hal::Time last_commit_{-1}, last_at_{0};
};

}  // namespace sinew::plant
