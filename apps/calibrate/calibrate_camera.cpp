// calibrate camera-offset: how far a camera's stamps are from the IMU's, and how it is turned against it.
#include <fmt/format.h>

#include <cmath>
#include <cstdio>

#include "apps/calibrate/calibration_bench.hpp"
#include "apps/calibrate/camera_offset.hpp"
#include "msg/image_buffer.hpp"
#include "rt/parameters.hpp"
#include "vision/image_turn.hpp"

namespace sinew::app {
namespace {

using namespace std::chrono_literals;

constexpr std::array<const char*, 4> kMount{"camera_qw", "camera_qx", "camera_qy", "camera_qz"};
constexpr double kDeg = 180 / math::kPi;

/// Parameters of the robot's modules: from the calibration, else the robot file, else the default.
class Params {
 public:
  Params(const RobotFile& robot, const Calibration& calibration, const rt::ModuleTypes& types)
      : graph_(robot.graph), types_(types) {
    for (const OverlayParam& p : calibration.params.params)
      for (auto& m : graph_.modules)
        if (m.name == p.module) m.params[p.param] = {p.value, 0};
  }
  std::optional<rt::ParamValue> get(const rt::ModuleSpec& m, std::string_view name) const {
    const auto made = types_.make(m.type);
    if (!made) return std::nullopt;
    rt::Declaration declaration;
    made->declare(declaration);
    const auto* declared = rt::find_param(declaration, name);
    if (!declared) return std::nullopt;
    const auto given = m.params.find(std::string(name));
    return given == m.params.end() ? declared->default_value : given->second.value;
  }
  std::optional<double> number(const rt::ModuleSpec& m, std::string_view name) const {
    const auto value = get(m, name);
    if (!value) return std::nullopt;
    if (const auto* real = std::get_if<double>(&*value)) return *real;
    if (const auto* whole = std::get_if<std::int64_t>(&*value)) return static_cast<double>(*whole);
    return std::nullopt;
  }
  const std::vector<rt::ModuleSpec>& modules() const { return graph_.modules; }

 private:
  rt::GraphSpec graph_;
  const rt::ModuleTypes& types_;
};

struct Wanted {
  std::string source, mount;  // modules
  math::Quat q_nominal;
  double fov_y_rad = 0;
};

/// False after printing what is missing.
bool find_modules(const CalibrateOptions& o, const Params& params, Wanted& wanted) {
  std::string mounts;
  std::size_t count = 0;
  for (const auto& m : params.modules()) {
    if (const auto device = params.get(m, "device"); device && m.type == "drivers::CameraSource")
      if (const auto* name = std::get_if<std::string>(&*device); name && *name == o.camera) wanted.source = m.name;
    if (const auto fov = params.number(m, "fov_y_rad"); fov && wanted.fov_y_rad == 0) wanted.fov_y_rad = *fov;
    if (!params.number(m, kMount[0])) continue;
    mounts += (count++ ? ", " : "") + m.name;
    if (o.mount.empty() || m.name == o.mount) wanted.mount = m.name;
  }
  if (o.fov_y_deg > 0) wanted.fov_y_rad = o.fov_y_deg / kDeg;
  if (wanted.source.empty()) {
    fail("no drivers::CameraSource has the device '" + o.camera + "'");
    return false;
  }
  if (wanted.fov_y_rad <= 0) {
    fail("no module has fov_y_rad: say --fov DEG");
    return false;
  }
  if (wanted.mount.empty() || (o.mount.empty() && count > 1)) {
    fail("--mount MODULE: name the module whose camera_qw, ... say how the camera is mounted; candidates: " +
         (count ? mounts : "none"));
    return false;
  }
  for (const auto& m : params.modules())
    if (m.name == wanted.mount)
      wanted.q_nominal = math::Quat{*params.number(m, kMount[0]), *params.number(m, kMount[1]),
                                    *params.number(m, kMount[2]), *params.number(m, kMount[3])}
                             .normalized();
  return true;
}

/// A grey picture, small enough to find turns quickly.
struct Taken {
  msg::Time stamp;
  msg::ImageBuffer grey;
};

std::optional<Taken> reduced(const msg::Image& image, vision::Luma& luma) {
  const std::uint32_t bin = image.width > 400 ? 4 : image.width > 200 ? 2 : 1;
  if (!luma.take(vision::view(image), bin)) return std::nullopt;
  const vision::ImageView view = luma.view();
  Taken taken{image.stamp, msg::ImageBuffer(msg::PixelFormat::mono8, view.width, view.height)};
  for (std::uint32_t y = 0; y < view.height; ++y) std::copy_n(view.row(y), view.width, taken.grey->row(y));
  return taken;
}

/// Reads both devices for --seconds. Only keeps the pictures meanwhile, so that it misses none. False after printing
/// why.
bool watch(hal::Imu& imu, hal::Camera& camera, const CalibrateOptions& o, CameraOffset& offset,
           std::vector<Taken>& pictures) {
  hal::Os& os = hal::system_os();
  msg::ImageBuffer image;
  vision::Luma luma(std::size_t{msg::kMaxImageWidth} * msg::kMaxImageHeight);
  const hal::Time begin = os.now();
  hal::Time imu_last = begin, image_last = begin;
  const auto length = hal::Duration{static_cast<std::int64_t>(o.seconds * 1e9)};
  while (os.now() - begin < length) {
    if (hal::stop_requested()) {
      fail("ended by a signal", kFailed);
      return false;
    }
    msg::ImuSample sample;
    for (auto got = imu.read(sample); got && *got; got = imu.read(sample)) offset.add(sample), imu_last = os.now();
    if (const auto got = camera.read(*image); got && *got) {
      image_last = os.now();
      auto taken = reduced(*image, luma);
      if (!taken) {
        fail("device '" + o.camera + "': its format has no grey values: yuyv or mono8");
        return false;
      }
      pictures.push_back(std::move(*taken));
      continue;  // another picture may wait
    }
    for (const auto& [last, name] : {std::pair{imu_last, &o.device}, std::pair{image_last, &o.camera}})
      if (os.now() - last > kSilent) {
        fail("device '" + *name + "': nothing came for 2 s", kFailed);
        return false;
      }
    os.sleep_until(os.now() + 1ms);
  }
  return true;
}

/// Finds the turn of each picture against the one three before it: the error of a fit then counts only a third. At 30
/// Hz these two are 0.1 s apart, and no motion of a hand reverses within that time.
void find_turns(const std::vector<Taken>& pictures, double fov_y_rad, CameraOffset& offset) {
  constexpr std::size_t kApart = 3;
  std::vector<vision::ImageTurn> turns(kApart, vision::ImageTurn(fov_y_rad));
  for (std::size_t i = 0; i < pictures.size(); ++i)
    if (const auto turn = turns[i % kApart].add(vision::view(*pictures[i].grey)); turn && i >= kApart)
      offset.add(pictures[i - kApart].stamp, pictures[i].stamp, turn->rotation_rad);
  std::printf("%zu pictures, %zu turns between two of them\n", pictures.size(), offset.pairs());
}

}  // namespace

int calibrate_camera_offset(const CalibrateOptions& o, const rt::ModuleTypes& types) {
  CalibrationBench bench;
  if (!bench.open(o, {})) return kNotBegun;
  Wanted wanted;
  if (!find_modules(o, Params(bench.robot, bench.old, types), wanted)) return kNotBegun;
  auto imu = bench.board->board().sensor<msg::ImuSample>(o.device);
  auto camera = bench.board->board().camera(o.camera);
  if (!imu || !camera || !bench.board->start()) return fail(bench.board->problem());
  std::printf("turn the robot about all three axes, in front of something with texture, for %g s\n", o.seconds);
  std::fflush(stdout);
  CameraOffset offset;
  std::vector<Taken> pictures;
  if (!watch(**imu, **camera, o, offset, pictures)) return kFailed;
  find_turns(pictures, wanted.fov_y_rad, offset);
  std::string why;
  const auto found = offset.solve(wanted.q_nominal, why);
  if (!found) return fail(why, kFailed);
  std::printf(
      "stamps of the camera: %+.2f ms (1 sigma %.2f ms)\n"
      "mount against '%s': turned by %.2f deg right, %.2f deg down, %.2f deg forward axis\n"
      "%zu turns, residual %.4f rad/s RMS; across the line of sight the pictures turn by %.3f of the gyro's\n",
      found->time_offset_ms, found->time_sigma_ms, wanted.mount.c_str(), found->turned_deg.x, found->turned_deg.y,
      found->turned_deg.z, found->pairs, found->residual_radps, found->scale);
  if (std::abs(found->scale - 1) > 0.15)
    std::printf("warning: a scale so far from 1 means a wrong --fov, or a scene too near\n");
  bench.set_param(wanted.source, "time_offset_ms", found->time_offset_ms);
  const math::Quat& q = found->q_imu_optical;
  for (const auto& [name, value] :
       {std::pair{kMount[0], q.w}, std::pair{kMount[1], q.x}, std::pair{kMount[2], q.y}, std::pair{kMount[3], q.z}})
    bench.set_param(wanted.mount, name, value);
  return bench.write(o.dry);
}

}  // namespace sinew::app
