// sinew-sim: a simulated world, as a process that speaks the simulator protocol.
#include <cstdio>
#include <fstream>

#include "apps/sim/redraw.hpp"
#include "apps/sim/render_test.hpp"
#include "apps/sim/scene_record.hpp"
#include "apps/sim/sim_options.hpp"
#include "apps/sim/simspark_serve.hpp"
#include "apps/sim/usarsim_serve.hpp"
#include "apps/sim/wire_open.hpp"
#include "hal/linux/process.hpp"
#include "hal/linux/socket.hpp"
#include "hal/platform.hpp"
#include "sim_hil/plant/session.hpp"
#include "sim_hil/plant/wire_run.hpp"
#include "sim_hil/worlds/json_object.hpp"

namespace {

using namespace sinew;

int fail(const std::string& what, const hal::Error& error) {
  std::fprintf(stderr, "sinew-sim: %s: %s (%s, %lld)\n", what.c_str(), hal::to_string(error.code), error.where,
               static_cast<long long>(error.detail));
  return 1;
}

void print(const plant::SessionReport& r) {
  if (!r.robot_name.empty()) std::printf("%s ", r.robot_name.c_str());
  std::printf("ended: %s\n", r.reason.c_str());
  std::printf("%s, seed %llu: %.2f s of plant time in %.2f s, physics thread %.1f ms of CPU per second, %llu frames\n",
              r.mode == sim_hil::Mode::lockstep ? "lockstep" : "real time", static_cast<unsigned long long>(r.seed),
              r.plant_s, r.wall_s, r.plant_s > 0 ? 1e3 * r.cpu_s / r.plant_s : 0.0,
              static_cast<unsigned long long>(r.frames));
  if (r.mode == sim_hil::Mode::free_running)
    std::printf(
        "largest gap between IMU samples %.3f ms, %llu steps late, %llu frames late, %u runtimes lost and followed\n",
        1e-6 * static_cast<double>(r.imu_gap_max_ns), static_cast<unsigned long long>(r.steps_late),
        static_cast<unsigned long long>(r.render_late), r.relinks);
  std::printf("leases that ran out: %llu\n", static_cast<unsigned long long>(r.lease_expiries));
  if (r.stopped_by_supervisor) std::printf("stopped by a supervisor at %.3f s\n", msg::seconds(r.stopped_at));
  std::printf("%s\n", r.outcome.c_str());
  for (const plant::FaultLog::Entry& e : r.faults)
    std::printf("fault %s: struck %llu times\n", plant::to_string(e.fault).c_str(),
                static_cast<unsigned long long>(e.affected));
}

int list_faults(const plant::WorldInfo& world) {
  for (const plant::FaultDevice device : plant::kFaultDevices) {
    if (!world.has(device)) continue;
    for (const plant::FaultKind kind : plant::kFaultKinds) {
      const char* reason = plant::why_not(device, kind);
      std::printf("%s %s%s%s\n", std::string(to_string(device)).c_str(), std::string(to_string(kind)).c_str(),
                  reason ? " - " : "", reason ? reason : "");
    }
  }
  return 0;
}

bool write_report(const std::string& path, const std::string& json) {
  if (path == "-") return std::printf("%s\n", json.c_str()) >= 0 && std::fflush(stdout) == 0;
  std::ofstream out(path);
  out << json << '\n';
  out.close();
  if (!out) std::fprintf(stderr, "sinew-sim: cannot write the report to %s\n", path.c_str());
  return static_cast<bool>(out);
}

/// The last report of the only robot, or of each by its name.
std::string last_report(const plant::Session& session) {
  if (session.report().robot_name.empty()) return session.report().text;
  plant::JsonObject robots, all;
  for (std::size_t i = 0; i < session.robots(); ++i)
    robots.object(session.report(i).robot_name.c_str(), session.report(i).text);
  all.object("robots", robots.done());
  return all.done();
}

bool write_reports(const std::vector<std::string>& paths, const std::string& json) {
  bool written = true;
  for (const std::string& path : paths) written = write_report(path, json) && written;
  return written;
}

/// The cameras of each robot; empty: it cannot be had, as was said.
std::vector<std::unique_ptr<plant::CameraFeed>> open_cameras(const plant::SimulatorOptions& s, hal::Os& os) {
  std::vector<std::unique_ptr<plant::CameraFeed>> cameras;
  const plant::WorldChoice& world = s.session.world;
  for (std::size_t i = 0; i < world.robot_count() * plant::RobotSession::cameras_of(world.type->info); ++i) {
    std::string why;
    auto camera = plant::CameraFeed::start(os, s.view, why);
    if (!camera) {
      fail("no camera: " + why, camera.error());
      return {};
    }
    cameras.push_back(std::move(*camera));
  }
  return cameras;
}

std::string camera_text(const plant::SimulatorOptions& s, const plant::CameraFeed& camera) {
  if (!s.session.world.type->info.find(plant::Part::camera)) return "no camera";
  return "camera " + s.camera + " " + s.format + " drawn by " + camera.backend();
}

/// A world without a runtime.
int run_alone(const plant::SimulatorOptions& s, hal::Os& os, plant::WireDevices& wire) {
  static_cast<void>(hal::stop_requested());  // from here on a signal only asks for the end
  const auto cameras = open_cameras(s, os);
  if (cameras.empty()) return 1;
  std::printf("%s runs alone, %s\n", s.world.c_str(), camera_text(s, *cameras[0]).c_str());
  std::fflush(stdout);
  plant::WireRun run(os, *cameras[0], wire, s.session);
  if (const hal::Status done = run.run(&hal::stop_requested); !done) return fail(run.report().reason, done.error());
  print(run.report());
  return write_reports(s.reports, run.report().text) ? 0 : 1;
}

/// The runtimes of all robots, in their order; empty: one has not come, as was said.
std::vector<sim_hil::Caller> wait_runtimes(const plant::SimulatorOptions& s, sim_hil::PlantListener& plant_listener,
                                           hal::Time give_up) {
  std::vector<sim_hil::Caller> callers;
  for (std::size_t i = 0; i < s.session.world.robot_count(); ++i) {
    auto caller = plant_listener.wait_runtime(give_up - hal::system_os().now(), i);
    if (!caller) {
      const bool several = !s.session.world.robots.empty();
      fail(several ? "robot '" + s.session.world.robots[i].name + "' has not connected" : "no runtime has connected",
           caller.error());
      return {};
    }
    callers.push_back(std::move(*caller));
  }
  return callers;
}

/// The file of --scenes; null: none is asked for, or it cannot be made, as was said.
std::unique_ptr<plant::SceneRecord> open_scenes(const plant::SimulatorOptions& s) {
  if (s.scenes.empty()) return nullptr;
  std::string why;
  auto scenes = plant::SceneRecord::open(s.scenes, plant::scene_world_of(s), why);
  if (!scenes) std::fprintf(stderr, "sinew-sim: --scenes %s: %s\n", s.scenes.c_str(), why.c_str());
  return scenes;
}

int serve(plant::SimulatorOptions& s) {
  hal::Os& os = hal::system_os();
  plant::WireDevices wire;
  if (!plant::open_wire(s, os, wire)) return 1;
  if (s.alone) return run_alone(s, os, wire);
  if (s.wire.any()) s.session.wire = &wire;
  plant::GameSender game;
  if (!plant::open_game(s.game, s.session.world.robot_count(), os, game)) return 1;
  s.session.game = game.feed.get();
  auto listener = hal::listen_stream(s.listen);
  if (!listener) return fail("cannot listen on " + s.listen, listener.error());
  // The listener first: a stop line does not wait for pixels.
  hal::ThreadOptions lines;
  lines.name = "plant_listener";
  lines.fifo_priority = s.lines_priority();
  std::vector<std::string> names;
  for (const plant::NamedRobot& robot : s.session.world.robots) names.push_back(robot.name);
  auto plant_listener = sim_hil::PlantListener::open(os, std::move(*listener),
                                                     plant::Session::description(s.view, s.session), lines, names);
  if (!plant_listener) return fail("cannot serve " + s.listen, plant_listener.error());
  const auto cameras = open_cameras(s, os);
  if (cameras.empty()) return 1;
  std::vector<plant::CameraFeed*> feeds;
  for (const auto& camera : cameras) feeds.push_back(camera.get());
  std::printf("listening on %s, %s\n", (*plant_listener)->endpoint().c_str(), camera_text(s, *feeds[0]).c_str());
  std::fflush(stdout);
  const auto scenes = open_scenes(s);
  if (!s.scenes.empty() && !scenes) return 1;
  s.session.scenes = scenes.get();
  const hal::Time give_up = os.now() + hal::Duration{static_cast<std::int64_t>(s.wait_s * 1e9)};
  for (;;) {
    auto callers = wait_runtimes(s, **plant_listener, give_up);
    if (callers.empty()) return 1;
    plant::Session session(os, feeds, s.session);
    static_cast<void>(session.serve(std::move(callers), **plant_listener));  // the report has the reason
    if (session.report().started) {
      bool broken = false;
      for (std::size_t i = 0; i < session.robots(); ++i) {
        print(session.report(i));
        broken = broken || session.report(i).broken;
      }
      if (game.feed) std::printf("%s\n", game.feed->text().c_str());
      std::string why;
      if (scenes && !scenes->finish(why)) {
        std::fprintf(stderr, "sinew-sim: --scenes %s: %s\n", s.scenes.c_str(), why.c_str());
        broken = true;
      }
      return write_reports(s.reports, last_report(session)) && !broken ? 0 : 1;
    }
    // A runtime asked for another mode, or left before the start, as one that only looks for its plant: wait for the
    // next.
    std::fprintf(stderr, "sinew-sim: no run: %s\n", session.report().reason.c_str());
    for (std::size_t i = 0; i < session.robots(); ++i) (*plant_listener)->let_go(i);
  }
}

}  // namespace

int main(int argc, char** argv) {
  plant::SimulatorOptions s;
  int exit_code = 0;
  if (!plant::read_command_line(argc, argv, s, exit_code)) return exit_code;
  if (!s.redraw.file.empty()) return plant::redraw(s.redraw);
  if (s.list_faults) return list_faults(s.session.world.type->info);
  if (!s.render_test.empty()) return plant::render_test(s.render_test, s.view, s.session.world);
  if (s.serve != "sinew") {
    std::string report;
    const int code = s.serve == "usarsim" ? plant::serve_usarsim(s, report) : plant::serve_simspark(s, report);
    if (code != 0) return code;
    return write_reports(s.reports, report) ? 0 : 1;
  }
  return serve(s);
}
