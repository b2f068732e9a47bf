#include "apps/sim/wire_open.hpp"

#include <cstdio>
#include <filesystem>

#include "hal/linux/camera/v4l2_source.hpp"
#include "hal/linux/can/can.hpp"
#include "hal/linux/devices/serial.hpp"
#include "hal/linux/socket.hpp"
#include "sim_hil/wire/socketcand_server.hpp"

namespace sinew::plant {
namespace {

hal::Time plant_time(double seconds) { return hal::Time{static_cast<std::int64_t>(seconds * 1e9)}; }

/// The world's camera behind a V4L2 device.
class VideoNode final : public WireCamera {
 public:
  explicit VideoNode(std::unique_ptr<hal::V4l2Source> source) : source_(std::move(source)) {}
  std::span<std::uint8_t> canvas() noexcept override { return source_->canvas(); }
  void deliver(hal::Time middle, std::uint32_t number) noexcept override { source_->deliver(middle, number); }
  void set_plugged(bool plugged) noexcept override { source_->set_plugged(plugged); }

 private:
  std::unique_ptr<hal::V4l2Source> source_;
};

/// False after printing why, as in the next two functions.
bool open_imu_and_camera(const SimulatorOptions& s, hal::Os& os, WireDevices& wire) {
  std::string why;
  if (!s.wire.iio.empty()) {
    sim_hil::IioTreeSpec spec;
    spec.root = s.wire.iio;
    auto tree = sim_hil::IioTree::make(spec);
    if (!tree) {
      std::fprintf(stderr, "sinew-sim: --iio %s: cannot be made\n", s.wire.iio.c_str());
      return false;
    }
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
  spec.rate_hz = kCameraHz;
  hal::ThreadOptions thread;
  thread.name = "plant_video";
  thread.fifo_priority = s.lines_priority();
  auto source = hal::V4l2Source::open(os, spec, thread, why);
  if (!source) {
    std::fprintf(stderr, "sinew-sim: --v4l2: %s\n", why.c_str());
    return false;
  }
  wire.add_camera(std::make_unique<VideoNode>(std::move(*source)));
  wire.delay_stamps(hal::Duration{static_cast<std::int64_t>(1e6 * s.wire.camera_late_ms)});
  if (double from = 0, until = 0; s.wire.unplugged(from, until))
    wire.unplug_camera(plant_time(from), plant_time(until));
  return true;
}

/// The name of a pseudo terminal, taken back at the end.
class LineName {
 public:
  explicit LineName(std::string path) : path_(std::move(path)) {}
  ~LineName() {
    std::error_code gone;
    std::filesystem::remove(path_, gone);
  }
  LineName(const LineName&) = delete;
  LineName& operator=(const LineName&) = delete;

 private:
  std::string path_;
};

/// Each line is a pseudo terminal under the name that was asked for. A link that an earlier run left is replaced.
bool open_lines(const SimulatorOptions& s, hal::Os& os, WireDevices& wire) {
  namespace fs = std::filesystem;
  for (const WireLineSpec& spec : s.lines) {
    const auto refuse = [&](const std::string& why) {
      std::fprintf(stderr, "sinew-sim: --serial %s: %s\n", spec.path.c_str(), why.c_str());
      return false;
    };
    auto pseudo = hal::make_pseudo_serial();
    if (!pseudo) return refuse("no pseudo terminal");
    std::error_code error;
    if (fs::is_symlink(fs::symlink_status(spec.path, error))) fs::remove(spec.path, error);
    fs::create_symlink(pseudo->path, spec.path, error);
    if (error) return refuse(error.message());
    wire.keep(std::make_shared<LineName>(spec.path));
    wire.add_line(std::make_unique<WireLine>(os, std::move(pseudo->end), spec, s.lines_priority()));
  }
  return true;
}

/// The drives are on a bus of this process, and a server lets others onto it.
bool serve_bus(const std::string& address, hal::Os& os, WireDevices& wire, std::vector<WireServo> servos) {
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

}  // namespace

bool open_wire(const SimulatorOptions& s, hal::Os& os, WireDevices& wire) {
  wire.add_faults(s.wire_faults);
  if (!open_lines(s, os, wire)) return false;
  if (s.wire.can.empty()) {
    wire.add_servos(nullptr, s.servos);
    return open_imu_and_camera(s, os, wire);
  }
  if (constexpr std::string_view kServe = "socketcand-server:"; s.wire.can.starts_with(kServe))
    return serve_bus(s.wire.can.substr(kServe.size()), os, wire, s.servos) && open_imu_and_camera(s, os, wire);
  std::string why;
  const auto colon = s.wire.can.find(':');
  const hal::CanSpec spec{s.wire.can.substr(0, colon), colon == std::string::npos ? "" : s.wire.can.substr(colon + 1)};
  auto watch = hal::FdWatch::start(os, {"sim_devices", 0, {}, std::size_t{64} * 1024, 0});
  if (!watch) {
    std::fprintf(stderr, "sinew-sim: --can: no thread\n");
    return false;
  }
  auto bus = hal::open_can(spec, os, *watch, why);
  if (!bus) {
    std::fprintf(stderr, "sinew-sim: --can: %s\n", why.c_str());
    return false;
  }
  wire.add_servos(std::move(*bus), s.servos);
  return open_imu_and_camera(s, os, wire);
}

}  // namespace sinew::plant
