#pragma once
#include <memory>
#include <optional>
#include <string>

#include "hal/os.hpp"
#include "hal/stream.hpp"
#include "sim_hil/plant/camera_feed.hpp"
#include "sim_hil/plant/plant_faults.hpp"
#include "sim_hil/plant/wire_devices.hpp"
#include "sim_hil/server/plant_link.hpp"
#include "sim_hil/server/plant_listener.hpp"
#include "sim_hil/server/relink.hpp"
#include "sim_hil/worlds/world.hpp"

namespace sinew::plant {

struct SessionOptions {
  WorldChoice world;                  // the camera draws its room
  std::optional<std::uint64_t> seed;  // instead of the one that the runtime asks for
  std::optional<sim_hil::Mode> only;  // refuse the other mode
  double duration_s = 0;              // plant time until the plant ends the run; 0: the runtime ends it
  std::vector<Fault> faults;          // docs/faults.md
  double relink_s = 5;                // free-running, by a listener: how long the world waits for another runtime
  int fifo_priority = 85;             // of the physics thread, free-running: above the robot's threads, like a device
  WireDevices* wire = nullptr;        // parts of the world at the wire, besides; free-running only. Not owned
};

/// How a run went, from the plant's side.
struct SessionReport {
  std::string reason;    // why it ended
  bool broken = false;   // by a lost connection or a breach of the protocol
  bool started = false;  // the runtime said Start
  std::uint64_t seed = 0;
  sim_hil::Mode mode = sim_hil::Mode::lockstep;
  double plant_s = 0, wall_s = 0, cpu_s = 0;  // cpu: of the physics thread
  std::uint64_t frames = 0, render_late = 0, steps_late = 0;
  std::int64_t imu_gap_max_ns = 0;    // free-running: between two IMU samples leaving
  std::int64_t wake_late_max_ns = 0;  // how much too late the kernel woke the physics thread
  std::int64_t work_max_ns = 0;       // from waking until the samples of a millisecond had left
  std::uint64_t lease_expiries = 0;
  std::uint32_t relinks = 0;           // runtimes that came after one that was lost
  bool stopped_by_supervisor = false;  // the stop line was pulled, at stopped_at of plant time
  hal::Time stopped_at{};
  std::uint64_t stale_actuations = 0;    // plant steps in which motors ran on a command after its lease: must be 0
  std::int64_t setpoint_age_max_ns = 0;  // oldest measurement that a running motor's command rested on
  std::vector<FaultLog::Entry> faults;   // those that have begun
  const char* world_name = "";
  bool still = false;   // World::still() at the end
  std::string outcome;  // of the world, in words
  std::string text;     // the last report as it was sent

  /// One JSON object: docs/sim-protocol.md names the keys that every plant has, docs/sinew-sim.md ours.
  std::string json(const World& world) const;
};

/// One run: the world behind one connection to a runtime, in lockstep or free-running as the runtime asks.
/// Same seed and same commands at the same times give the same bytes on the wire, in lockstep.
/// Thread:  owner; free-running makes a SCHED_FIFO thread for the physics, and the camera has its own.
class Session {
 public:
  Session(hal::Os& os, CameraFeed& camera, const SessionOptions& options);
  /// The devices of this plant, as its listener announces them to side lines.
  static sim_hil::PlantDescription description(const CameraOptions& view, const SessionOptions& options);

  /// Serves the runtime at the other end until it says Bye, goes away, or the duration is over.
  /// Errors:  those of the handshake; `report().reason` has them in words.
  hal::Status serve(std::unique_ptr<hal::Stream> stream);
  /// The same with a runtime that came by the listener; the listener's stop line ends all commands.
  hal::Status serve(sim_hil::Caller caller, sim_hil::PlantListener& plant_listener);
  const SessionReport& report() const { return report_; }

 private:
  struct PendingFrame {
    sim_hil::FrameSlot slot;  // unless frames have faults
    sim_hil::FrameMeta meta;
  };

  hal::Status serve(sim_hil::Caller caller);
  hal::Status open(sim_hil::Caller caller);
  void rehearse();
  hal::Status run_lockstep();
  hal::Status run_free();
  hal::Status go_on_without_runtime(hal::Status lost);
  hal::Status welcome_another(hal::Time start);
  bool line_closed();
  void go_on_alone();
  hal::Status advance_one_ms();
  void heed_stop_line();
  std::span<const double> act();
  hal::Status send_due(const Due& due);
  hal::Status begin_frame();
  hal::Status send_frame(const sim_hil::FrameSlot& slot, const sim_hil::FrameMeta& meta);
  hal::Status copy_frame(std::span<const std::uint8_t> pixels, const sim_hil::FrameMeta& meta);
  /// Place of a part in the Welcome. The world has it.
  std::uint16_t id(Part part) const { return ids_[static_cast<std::size_t>(part)]; }
  auto sender(Part part) {
    return [this, part](const auto& sample, hal::Time ready) { return link_->send(id(part), sample, ready); };
  }
  hal::Status release_held(hal::Time until);
  hal::Status send_frame_due_by(hal::Time until, bool wait);
  hal::Status send_truth_and_report();
  void note_imu_gap(hal::Time now);
  void refresh_report();
  bool over() const;

  hal::Os& os_;
  CameraFeed& feed_;
  SessionOptions options_;
  sim_hil::PlantListener* plant_listener_ = nullptr;
  std::unique_ptr<hal::SharedMemory> frames_;
  std::unique_ptr<sim_hil::PlantLink> link_;
  std::unique_ptr<Relink> relink_;    // once a runtime was lost
  std::uint64_t expired_before_ = 0;  // leases, of links before this one
  std::unique_ptr<World> world_;
  WorldInfo info_;
  std::array<std::uint16_t, 7> ids_{};
  std::array<double, msg::kMaxChannels> acting_{};
  std::optional<PendingFrame> pending_;
  std::unique_ptr<PlantFaults> faults_;  // made with the world, when the seed is known
  sim_hil::Setpoints commanded_;         // the newest that the link had
  std::uint32_t frame_number_ = 0;
  std::uint32_t told_news_ = 0;
  hal::Time last_imu_{-1};
  hal::Time host_zero_{};  // free-running: the host's clock at plant time 0
  SessionReport report_;
};

}  // namespace sinew::plant
