#pragma once
#include <atomic>

#include "hal/clock.hpp"
#include "sim_hil/caller.hpp"
#include "sim_hil/server/plant_link.hpp"

namespace sinew::sim_hil {

/// The answers of a plant to side lines.
struct SideLineService {
  const hal::Clock& host;         // the clock that plant time follows
  const PlantDescription& plant;  // its cameras without slots: there are no frames on a side line
  std::atomic<bool>& stopped;     // set, with release order, before the answer to Stop goes out
};

/// Serves a caller who wants a side line, until it hangs up or breaks the protocol. Blocking.
void serve_side_line(Caller& caller, const SideLineService& service);

}  // namespace sinew::sim_hil
