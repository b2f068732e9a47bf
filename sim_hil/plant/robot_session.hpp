#pragma once
#include <memory>
#include <optional>
#include <string>

#include "hal/os.hpp"
#include "sim_hil/plant/camera_feed.hpp"
#include "sim_hil/plant/plant_faults.hpp"
#include "sim_hil/plant/session_options.hpp"
#include "sim_hil/plant/session_report.hpp"
#include "sim_hil/server/plant_link.hpp"
#include "sim_hil/server/plant_listener.hpp"
#include "sim_hil/server/relink.hpp"

namespace sinew::plant {

/// A datagram on its way into the air.
struct Said {
  hal::Time at;
  std::size_t robot = 0;
  std::span<const std::uint8_t> bytes;
};

/// One robot's side of a session: its connection, its devices with their delays and faults, its camera. The session
/// steps the world, and has each robot act before and tell after a step. Once the robot is gone, its functions do
/// nothing more, but its last command still acts until its lease is over.
/// Thread:  the session's.
class RobotSession {
 public:
  /// `physics` of the session is part of each report.
  /// `cameras`: as cameras_of() says.
  RobotSession(hal::Os& os, std::span<CameraFeed* const> cameras, const SessionOptions& options,
               const PhysicsReport& physics, std::size_t number);
  /// How many feeds a robot of this world has: one also without a camera, and nobody asks it for a picture.
  static std::size_t cameras_of(const WorldInfo& world) { return std::max<std::size_t>(world.count(Part::camera), 1); }

  /// The devices of one robot of this plant, as it is welcomed with them; those of the first one are announced to side
  /// lines.
  static sim_hil::PlantDescription description(const CameraOptions& view, const SessionOptions& options,
                                               std::size_t robot = 0);

  // ---- before the run
  /// Shakes hands. `listener`: by which the runtime came; null: by none. Errors: those of the handshake; not_supported:
  /// the mode is not wanted. report() has them in words.
  hal::Status open(sim_hil::Caller caller, sim_hil::PlantListener* listener);
  const sim_hil::Hello& hello() const { return link_->hello(); }
  /// The robot is in this world, which outlives the run.
  void enter(World& world, std::uint64_t seed);
  hal::Status wait_start();
  /// It cannot go on: tells the runtime why.
  hal::Status refuse(std::string why, hal::Error error);

  // ---- lockstep: what is ready by `until` goes out, then the grant; then its runtime has answered
  void begin_grant(hal::Time until);
  void wait_done();

  // ---- free-running
  /// Plant time `now` is now, when the host's clock shows `host_now`.
  void start_clock(hal::Time now, hal::Time host_now);
  /// Takes in what came, also another runtime after one that was lost.
  void hear();
  /// Sends what is ready; a lost runtime may come back.
  void tell();

  // ---- both
  /// Sends frames and held samples that are ready by then. `wait`: for a frame that is being drawn.
  void send_ready(hal::Time until, bool wait);
  /// Its radio hears what arrives by then.
  void hear_air(Air& air, hal::Time until);
  /// Appends what its radio has said since the last call; valid until the next exchange.
  void collect_said(std::vector<Said>& all);
  /// The setpoints of the step that starts now; none: the safe action.
  RobotCommand act();
  /// What the step that just ended made available.
  void send_due();
  /// Once a millisecond: the stop line, and a fault that closes the connection.
  void heed_stop_line();
  void close_by_fault();

  /// Nothing more is said or heard.
  bool gone() const { return !status_; }
  bool closed_by_fault() const { return !link_; }
  const hal::Status& status() const { return status_; }

  // ---- after the run
  /// Says why it is over, if the runtime does not know.
  void finish();
  const SessionReport& report() const { return report_; }
  SessionReport& report() { return report_; }
  const SimRobot& robot() const { return *robot_; }

 private:
  struct PendingFrame {
    sim_hil::FrameSlot slot;  // unless frames have faults
    sim_hil::FrameMeta meta;
  };
  struct Camera {
    CameraFeed* feed = nullptr;
    std::uint16_t id = 0;
    std::int64_t delay_ns = 0;
    std::size_t number = 0;  // of the robot's
    std::uint32_t frames = 0;
    std::optional<PendingFrame> pending{};
  };
  struct Group {
    std::uint16_t id = 0;
    std::uint32_t channels = 0;
    sim_hil::Setpoints commanded{};  // the newest that the link had
  };
  struct JointGroup {
    std::uint16_t id = 0;
    std::int64_t delay_ns = 0;
  };
  void keep(hal::Status s) {
    if (status_ && !s) status_ = s;
  }
  hal::Status go_on_without_runtime(hal::Status lost);
  hal::Status welcome_another();
  hal::Status begin_frame(Camera& camera);
  hal::Status send_frame(const Camera& camera, const sim_hil::FrameSlot& slot, const sim_hil::FrameMeta& meta);
  hal::Status copy_frame(const Camera& camera, std::span<const std::uint8_t> pixels, const sim_hil::FrameMeta& meta);
  bool drawing() const;
  void wait_for_drawing();
  /// Place of a part that is there once in the Welcome. The world has it.
  std::uint16_t id(Part part) const { return ids_[static_cast<std::size_t>(part)]; }
  auto sender(std::uint16_t device) {
    return [this, device](const auto& sample, hal::Time ready) { return link_->send(device, sample, ready); };
  }
  hal::Status send_samples(const Due& due);
  hal::Status release_held(hal::Time until);
  hal::Status send_frame_due_by(Camera& camera, hal::Time until, bool wait);
  hal::Status send_truth_and_report();
  void refresh_report();
  sim_hil::RobotClock clock(std::uint64_t own_seed) const;
  std::uint16_t radio() const { return static_cast<std::uint16_t>(info_.devices.size()); }  // behind the parts
  auto radio_sender() {
    return [this](const msg::Datagram& d) { return link_->send(radio(), d, d.stamp); };
  }

  hal::Os& os_;
  const CameraOptions& view_;  // of all of its cameras
  const SessionOptions& options_;
  const PhysicsReport& physics_;
  const std::size_t number_;
  const WorldInfo info_;
  sim_hil::PlantListener* listener_ = nullptr;
  std::unique_ptr<hal::SharedMemory> frames_;
  std::unique_ptr<sim_hil::PlantLink> link_;
  std::unique_ptr<Relink> relink_;    // once a runtime was lost
  std::uint64_t expired_before_ = 0;  // leases, of links before this one
  World* world_ = nullptr;
  SimRobot* robot_ = nullptr;
  std::array<std::uint16_t, kParts> ids_{};
  std::vector<Camera> cameras_;
  std::vector<Group> groups_;
  std::vector<JointGroup> joints_;
  std::array<double, kMostGroups * msg::kMaxChannels> acting_{};
  std::unique_ptr<PlantFaults> faults_;  // made with the world, when the seed is known
  std::uint32_t told_news_ = 0;
  hal::Time host_zero_{};  // free-running: the host's clock at plant time 0
  hal::Status status_;
  SessionReport report_;
};

}  // namespace sinew::plant
