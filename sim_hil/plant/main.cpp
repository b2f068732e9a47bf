// sinew-sim: a simulated world, as a process that speaks the simulator protocol.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <fstream>

#include "hal/linux/can.hpp"
#include "hal/linux/os.hpp"
#include "hal/linux/process.hpp"
#include "hal/linux/serial.hpp"
#include "hal/linux/socket.hpp"
#include "hal/linux/v4l2_source.hpp"
#include "sim_hil/plant/render_test.hpp"
#include "sim_hil/plant/session.hpp"
#include "sim_hil/plant/wire_options.hpp"
#include "sim_hil/plant/wire_run.hpp"
#include "sim_hil/wire/socketcand_server.hpp"

namespace {

using namespace sinew;

struct Settings {
  std::string listen = "unix:sinew-sim.sock";
  std::string world = "quad", camera = "320x240", format = "yuyv", render_test;
  bool lockstep = false, free_running = false, list_faults = false;
  double wait_s = 60;
  plant::CameraOptions view;
  plant::SessionOptions session;
  std::uint64_t seed = 0;
  std::vector<std::string> faults;
  std::string report;
  plant::WireOptions wire;
  bool alone = false;
};

/// "640x480"; an empty text when it is one.
std::string check_size(const std::string& text) {
  unsigned w = 0, h = 0;
  char rest = 0;
  if (std::sscanf(text.c_str(), "%ux%u%c", &w, &h, &rest) == 2 && w >= 16 && h >= 16 && w <= msg::kMaxImageWidth &&
      h <= msg::kMaxImageHeight && w % 2 == 0)
    return "";
  return "'" + text + "' is not WIDTHxHEIGHT with an even width of 16..1280 and a height of 16..960";
}

msg::PixelFormat format_of(const std::string& name) {
  if (name == "rgb8") return msg::PixelFormat::rgb8;
  if (name == "mono8") return msg::PixelFormat::mono8;
  return msg::PixelFormat::yuyv;
}

void describe(CLI::App& app, Settings& s) {
  app.add_option("--listen", s.listen, "unix:PATH or tcp:HOST:PORT; port 0: the system chooses")->capture_default_str();
  auto* lockstep = app.add_flag("--lockstep", s.lockstep, "serve only runtimes that ask for lockstep");
  app.add_flag("--free", s.free_running, "serve only runtimes that ask for real time")->excludes(lockstep);
  app.add_option("--world", s.world,
                 "which world: quad (a quadrotor in a room), desk_head (a head on a desk, and a ball)")
      ->check(CLI::IsMember({"quad", "desk_head"}))
      ->capture_default_str();
  app.add_option("--seed", s.seed, "start, wind, spread and noise (default: what the runtime asks for)");
  app.add_option("--camera", s.camera, "size of the camera's frames")->check(check_size)->capture_default_str();
  app.add_option("--format", s.format, "of its pixels")
      ->check(CLI::IsMember({"yuyv", "rgb8", "mono8"}))
      ->capture_default_str();
  app.add_option("--camera-noise", s.view.noise, "sigma of the pixels, grey levels")
      ->check(CLI::Range(0.0, 20.0))
      ->capture_default_str();
  app.add_option("--gust", s.session.world.quad.gust_mps, "quad: wind never exceeds this, m/s; 0: still air")
      ->check(CLI::Range(0.0, 15.0))
      ->capture_default_str();
  app.add_option("--spread", s.session.world.quad.spread, "quad: of mass and motors, as a share, either way")
      ->check(CLI::Range(0.0, 0.3))
      ->capture_default_str();
  app.add_option("--start-offset", s.session.world.quad.start_offset_m,
                 "quad: largest distance of the start from the pad, m")
      ->check(CLI::Range(0.0, 3.0))
      ->capture_default_str();
  app.add_option("--rock", s.session.world.head.rock_deg, "desk_head: the platform tilts by up to this, deg")
      ->check(CLI::Range(0.0, 20.0))
      ->capture_default_str();
  app.add_option("--ball-speed", s.session.world.head.ball_speed, "desk_head: share of the ball's usual speed")
      ->check(CLI::Range(0.0, 3.0))
      ->capture_default_str();
  app.add_option("--fault", s.faults,
                 "DEVICE:KIND[(AMOUNT)]@FROM[+LENGTH|..UNTIL], e.g. imu:stuck@5+0.5; may be repeated")
      ->allow_extra_args(false);
  app.add_flag("--list-faults", s.list_faults,
               "print every device with every kind, and why those that are none are none");
  s.wire.describe(app);
  app.add_flag(
      "--alone", s.alone,
      "real time: no runtime connects; the world begins at once, with its devices at the wire, until --duration "
      "is over or a signal comes");
  app.add_option("--report", s.report, "write the last report (JSON) into this file");
  app.add_option("--duration", s.session.duration_s, "end the run after so many seconds of plant time; 0: never")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  app.add_option("--priority", s.session.fifo_priority,
                 "SCHED_FIFO priority of the physics thread in real time; 0: none")
      ->check(CLI::Range(0, 99))
      ->capture_default_str();
  app.add_option("--relink", s.session.relink_s,
                 "real time: when the runtime is lost, the world waits so many seconds for another; 0: it ends")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  app.add_option("--wait", s.wait_s, "give up when no runtime has come after so many seconds")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_option("--render-test", s.render_test,
                 "write pictures of the world into this folder, time a frame, and exit");
}

int fail(const std::string& what, const hal::Error& error) {
  std::fprintf(stderr, "sinew-sim: %s: %s (%s, %lld)\n", what.c_str(), hal::to_string(error.code), error.where,
               static_cast<long long>(error.detail));
  return 1;
}

void print(const plant::SessionReport& r) {
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

bool read_faults(Settings& s) {
  std::string why;
  for (const std::string& text : s.faults) {
    const auto fault = plant::parse_fault(text, why);
    if (!fault) {
      std::fprintf(stderr, "sinew-sim: --fault: %s\n", why.c_str());
      return false;
    }
    if (const plant::WorldInfo world = plant::world_info(s.session.world.kind); !world.has(fault->device)) {
      std::fprintf(stderr, "sinew-sim: --fault: fault '%s': the world %s has no device '%s'\n", text.c_str(),
                   world.name, std::string(to_string(fault->device)).c_str());
      return false;
    }
    s.session.faults.push_back(*fault);
  }
  return true;
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
  std::ofstream out(path);
  out << json << '\n';
  out.close();
  if (!out) std::fprintf(stderr, "sinew-sim: cannot write the report to %s\n", path.c_str());
  return static_cast<bool>(out);
}

/// The door's and the video node's threads: a stop line does not wait for pixels, nor do these for physics.
int lines_priority(const Settings& s) {
  return s.session.fifo_priority > 0 ? std::min(s.session.fifo_priority + 1, 99) : 0;
}

hal::Time plant_time(double seconds) { return hal::Time{static_cast<std::int64_t>(seconds * 1e9)}; }

/// The world's camera behind a V4L2 device.
class VideoNode final : public plant::WireCamera {
 public:
  explicit VideoNode(std::unique_ptr<hal::V4l2Source> source) : source_(std::move(source)) {}
  std::span<std::uint8_t> canvas() noexcept override { return source_->canvas(); }
  void deliver(hal::Time middle, std::uint32_t number) noexcept override { source_->deliver(middle, number); }
  void set_plugged(bool plugged) noexcept override { source_->set_plugged(plugged); }

 private:
  std::unique_ptr<hal::V4l2Source> source_;
};

/// False after it was said why; so do the next two.
bool open_imu_and_camera(const Settings& s, hal::Os& os, plant::WireDevices& wire) {
  std::string why;
  if (!s.wire.iio.empty()) {
    sim_hil::IioTreeSpec spec;
    spec.root = s.wire.iio;
    auto tree = sim_hil::IioTree::make(spec);
    if (!tree) return std::fprintf(stderr, "sinew-sim: --iio %s: cannot be made\n", s.wire.iio.c_str()), false;
    auto pipe = hal::make_pipe((*tree)->buffer_path());
    if (!pipe) {
      std::fprintf(stderr, "sinew-sim: --iio %s: %s\n", (*tree)->buffer_path().c_str(),
                   hal::to_string(pipe.error().code));
      return false;
    }
    (*tree)->attach(std::move(*pipe));
    wire.add_imu(std::move(*tree));
  }
  wire.add_gyro_bias(s.wire.gyro_bias_radps());
  if (s.wire.v4l2.empty()) return true;
  hal::V4l2SourceSpec spec;
  spec.root = s.wire.v4l2;
  spec.format = s.view.format, spec.width = s.view.width, spec.height = s.view.height;
  spec.rate_hz = plant::kCameraHz;
  hal::ThreadOptions thread;
  thread.name = "plant_video";
  thread.fifo_priority = lines_priority(s);
  auto source = hal::V4l2Source::open(os, spec, thread, why);
  if (!source) return std::fprintf(stderr, "sinew-sim: --v4l2: %s\n", why.c_str()), false;
  wire.add_camera(std::make_unique<VideoNode>(std::move(*source)));
  wire.delay_stamps(hal::Duration{static_cast<std::int64_t>(1e6 * s.wire.camera_late_ms)});
  if (double from = 0, until = 0; s.wire.unplugged(from, until))
    wire.unplug_camera(plant_time(from), plant_time(until));
  return true;
}

/// The drives are on a bus of this process, and a server lets others onto it.
bool serve_bus(const std::string& address, hal::Os& os, plant::WireDevices& wire,
               std::vector<plant::WireServo> servos) {
  const auto refuse = [&](const hal::Error& e) {
    std::fprintf(stderr, "sinew-sim: --can: socketcand-server:%s: %s (%s)\n", address.c_str(), hal::to_string(e.code),
                 e.where);
    return false;
  };
  const bool port_alone = address.find(':') == std::string::npos;
  auto listener = hal::listen_stream("tcp:" + (port_alone ? "127.0.0.1:" + address : address));
  if (!listener) return refuse(listener.error());
  auto server = sim_hil::SocketcandServer::open(os, std::move(*listener), {"can0"});
  if (!server) return refuse(server.error());
  auto bus = (*server)->bus("can0");
  if (!bus) return refuse(bus.error());
  wire.add_servos(std::move(*bus), std::move(servos));
  wire.keep(std::move(*server));
  return true;
}

bool open_wire(const Settings& s, hal::Os& os, plant::WireDevices& wire) {
  std::string why;
  if (!s.wire.can.empty()) {
    std::vector<plant::WireServo> servos;
    for (const std::string& text : s.wire.servos) {
      const auto servo = plant::parse_wire_servo(text, why);
      if (!servo) return std::fprintf(stderr, "sinew-sim: --servo: %s\n", why.c_str()), false;
      servos.push_back(*servo);
    }
    if (constexpr std::string_view kServe = "socketcand-server:"; s.wire.can.starts_with(kServe))
      return serve_bus(s.wire.can.substr(kServe.size()), os, wire, std::move(servos)) &&
             open_imu_and_camera(s, os, wire);
    const auto colon = s.wire.can.find(':');
    const hal::CanSpec spec{s.wire.can.substr(0, colon),
                            colon == std::string::npos ? "" : s.wire.can.substr(colon + 1)};
    auto watch = hal::FdWatch::start(os, {"sim_devices", 0, {}, std::size_t{64} * 1024, 0});
    if (!watch) return std::fprintf(stderr, "sinew-sim: --can: no thread\n"), false;
    auto bus = hal::open_can(spec, os, *watch, why);
    if (!bus) return std::fprintf(stderr, "sinew-sim: --can: %s\n", why.c_str()), false;
    wire.add_servos(std::move(*bus), std::move(servos));
  }
  return open_imu_and_camera(s, os, wire);
}

/// A world without a runtime.
int run_alone(const Settings& s, hal::Os& os, plant::WireDevices& wire) {
  static_cast<void>(hal::stop_requested());  // from here on a signal asks
  std::string why;
  auto camera = plant::CameraFeed::start(os, s.view, why);
  if (!camera) return fail("no camera: " + why, camera.error());
  std::printf("%s runs alone, camera %s %s drawn by %s\n", s.world.c_str(), s.camera.c_str(), s.format.c_str(),
              (*camera)->backend().c_str());
  std::fflush(stdout);
  plant::WireRun run(os, **camera, wire, s.session);
  if (const hal::Status done = run.run(&hal::stop_requested); !done) return fail(run.report().reason, done.error());
  print(run.report());
  return s.report.empty() || write_report(s.report, run.report().text) ? 0 : 1;
}

int serve(Settings& s) {
  hal::Os& os = hal::linux_os();
  plant::WireDevices wire;
  if (!open_wire(s, os, wire)) return 1;
  if (s.alone) return run_alone(s, os, wire);
  if (s.wire.any()) s.session.wire = &wire;
  auto listener = hal::listen_stream(s.listen);
  if (!listener) return fail("cannot listen on " + s.listen, listener.error());
  // The door first: a stop line does not wait for pixels.
  hal::ThreadOptions lines;
  lines.name = "plant_door";
  lines.fifo_priority = lines_priority(s);
  auto door = sim_hil::PlantDoor::open(os, std::move(*listener), plant::Session::description(s.view, s.session), lines);
  if (!door) return fail("cannot serve " + s.listen, door.error());
  std::string why;
  auto camera = plant::CameraFeed::start(os, s.view, why);
  if (!camera) return fail("no camera: " + why, camera.error());
  std::printf("listening on %s, camera %s %s drawn by %s\n", (*door)->endpoint().c_str(), s.camera.c_str(),
              s.format.c_str(), (*camera)->backend().c_str());
  std::fflush(stdout);
  const hal::Time give_up = os.now() + hal::Duration{static_cast<std::int64_t>(s.wait_s * 1e9)};
  for (;;) {
    auto caller = (*door)->wait_runtime(give_up - os.now());
    if (!caller) return fail("no runtime has connected", caller.error());
    plant::Session session(os, **camera, s.session);
    static_cast<void>(session.serve(std::move(*caller), **door));  // the report has the reason
    if (session.report().started) {
      print(session.report());
      if (!s.report.empty() && !write_report(s.report, session.report().text)) return 1;
      return session.report().broken ? 1 : 0;
    }
    // One that asked for another mode, or left before the start, as one does that looks for its plant: not the last.
    std::fprintf(stderr, "sinew-sim: no run: %s\n", session.report().reason.c_str());
    (*door)->let_go();
  }
}

}  // namespace

int main(int argc, char** argv) {
  Settings s;
  CLI::App app(
      "Simulated worlds for Sinew: a quadrotor in a room with a landing pad, a head on a desk that follows a ball.\n"
      "Waits for one runtime, serves it until it says good-bye, and exits 0 when it did.",
      "sinew-sim");
  describe(app, s);
  CLI11_PARSE(app, argc, argv);
  std::sscanf(s.camera.c_str(), "%ux%u", &s.view.width, &s.view.height);
  s.view.format = format_of(s.format);
  s.view.turned_rad = s.wire.camera_turned_rad();
  s.view.world = s.session.world.kind = plant::find_world(s.world).value_or(plant::WorldKind::quad);
  if (app.count("--seed") > 0) s.session.seed = s.seed;
  if (s.lockstep) s.session.only = sim_hil::Mode::lockstep;
  if (s.free_running) s.session.only = sim_hil::Mode::free_running;
  if (s.list_faults) return list_faults(plant::world_info(s.session.world.kind));
  if (!read_faults(s)) return 1;
  if (s.alone && (!s.faults.empty() || s.lockstep))
    return std::fprintf(stderr, "sinew-sim: --alone: %s\n",
                        s.lockstep ? "in real time only, not with --lockstep"
                                   : "--fault strikes what goes to a runtime, and none connects"),
           1;
  if (!s.render_test.empty()) return plant::render_test(s.render_test, s.view);
  return serve(s);
}
