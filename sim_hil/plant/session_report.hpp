#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "sim_hil/protocol.hpp"
#include "sim_hil/worlds/air.hpp"
#include "sim_hil/worlds/world.hpp"

namespace sinew::plant {

/// How the world ran, for all of its robots.
struct PhysicsReport {
  double plant_s = 0, wall_s = 0, cpu_s = 0;  // cpu: of the physics thread
  std::uint64_t steps_late = 0;
  std::int64_t imu_gap_max_ns = 0;    // free-running: between two IMU samples leaving
  std::int64_t wake_late_max_ns = 0;  // how much too late the kernel woke the physics thread
  std::int64_t work_max_ns = 0;       // from waking until the samples of a millisecond had left
};

/// How a run went for one robot, from the plant's side.
struct SessionReport : PhysicsReport {
  std::string reason;    // why it ended
  bool broken = false;   // by a lost connection or a breach of the protocol
  bool started = false;  // the runtime said Start
  std::uint64_t seed = 0;
  sim_hil::Mode mode = sim_hil::Mode::lockstep;
  std::uint64_t frames = 0, render_late = 0;
  std::uint64_t lease_expiries = 0;
  std::uint32_t relinks = 0;           // runtimes that came after one that was lost
  bool stopped_by_supervisor = false;  // the stop line was pulled, at stopped_at of plant time
  hal::Time stopped_at{};
  std::uint64_t stale_actuations = 0;    // plant steps in which motors ran on a command after its lease: must be 0
  std::int64_t setpoint_age_max_ns = 0;  // oldest measurement that a running motor's command rested on
  std::vector<FaultLog::Entry> faults;   // those that have begun
  const char* world_name = "";
  std::string robot_name;  // in a world with several
  Air::Counts radio;       // likewise
  bool still = false;      // SimRobot::still() at the end
  std::string outcome;     // of the robot, in words
  std::string text;        // the last report as it was sent

  /// One JSON object: docs/sim-protocol.md names the keys that every plant has, docs/sinew-sim.md ours.
  std::string json(const SimRobot& robot) const;
};

}  // namespace sinew::plant
