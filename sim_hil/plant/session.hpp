#pragma once
#include <memory>
#include <vector>

#include "hal/os.hpp"
#include "hal/stream.hpp"
#include "sim_hil/plant/camera_feed.hpp"
#include "sim_hil/plant/robot_session.hpp"
#include "sim_hil/plant/session_options.hpp"
#include "sim_hil/plant/session_report.hpp"
#include "sim_hil/server/plant_listener.hpp"

namespace sinew::plant {

/// One run: the world behind the connections to the runtimes of its robots, in lockstep or free-running as they ask.
/// Same seed and same commands at the same times give the same bytes on the wire, in lockstep, whichever runtime is the
/// faster one. A robot that goes away lets the others go on; the run is over when none is left.
/// Thread:  owner; free-running makes a SCHED_FIFO thread for the physics, and each camera has its own.
class Session {
 public:
  /// RobotSession::cameras_of() of them for each robot of options.world, robot after robot.
  Session(hal::Os& os, std::vector<CameraFeed*> cameras, const SessionOptions& options);
  Session(const Session&) = delete;
  /// The devices of each robot of this plant, as its listener announces them to side lines.
  static sim_hil::PlantDescription description(const CameraOptions& view, const SessionOptions& options) {
    return RobotSession::description(view, options);
  }

  /// Serves the runtime of the only robot at the other end until it says Bye, goes away, or the duration is over.
  /// Errors:  those of the handshake; `report().reason` has them in words.
  hal::Status serve(std::unique_ptr<hal::Stream> stream);
  /// The same with a runtime for each robot, in their order, that have said their Hello.
  hal::Status serve(std::vector<sim_hil::Caller> callers) { return serve(std::move(callers), nullptr); }
  /// The same with runtimes that came by the listener; its stop line ends all commands, and it lets lost ones come
  /// back.
  hal::Status serve(std::vector<sim_hil::Caller> callers, sim_hil::PlantListener& plant_listener);
  std::size_t robots() const { return robots_.size(); }
  const SessionReport& report(std::size_t robot = 0) const { return robots_[robot]->report(); }

 private:
  hal::Status serve(std::vector<sim_hil::Caller> callers, sim_hil::PlantListener* plant_listener);
  hal::Status open(std::vector<sim_hil::Caller> callers, sim_hil::PlantListener* plant_listener);
  hal::Status refuse_all(std::string why, hal::Error error);
  void rehearse();
  void run_lockstep();
  hal::Status run_free();
  void grant(hal::Time until);
  void advance_one_ms();
  void step();
  void pass_on_said(hal::Time now);
  void go_on_alone();
  /// Also closes connections, where a fault does. Neither is the time over, nor are all robots gone.
  bool goes_on();
  bool all_gone() const;

  hal::Os& os_;
  SessionOptions options_;
  std::vector<std::unique_ptr<RobotSession>> robots_;
  std::vector<RobotCommand> commands_;
  std::unique_ptr<World> world_;
  Air air_{{}, 0, 0};  // made with the world
  std::vector<Said> said_;
  PhysicsReport physics_;
  hal::Time host_zero_{};  // free-running: the host's clock at plant time 0
};

}  // namespace sinew::plant
