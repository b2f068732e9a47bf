// V4L2 on a simulated camera; libcamera as far as it can be tried without a kernel's camera.
#include <linux/videodev2.h>

#include <cerrno>

#include "hal/linux/camera/libcamera_plugin.hpp"
#include "hal/linux/camera/v4l2_camera.hpp"
#include "hal/linux/camera/v4l2_sim.hpp"
#include "hal/platform.hpp"
#include "msg/image_buffer.hpp"
#include "rig.hpp"

namespace sinew::test {
namespace {

constexpr const char* kPath = "/dev/video0";
constexpr Duration kPeriod{33'333'000};

class V4l2Rig final : public Rig {
 public:
  V4l2Rig() {
    device = measures = "camera";
    names = {kPath};
    specs.devices.push_back(table(
        device, "v4l2", {{"path", std::string(kPath)}, {"width", std::int64_t{320}}, {"height", std::int64_t{240}}}));
    connectors.open_v4l2 = [this](const hal::CameraSpec& spec,
                                  std::string& why) -> hal::Result<std::unique_ptr<hal::Camera>> {
      auto camera = hal::V4l2Camera::open(sim_, spec, os, nullptr, {}, why);
      if (!camera) return camera.error();
      return std::unique_ptr<hal::Camera>(std::move(*camera));
    };
  }
  std::vector<Way> ways(Fault fault) const override {
    if (fault == Fault::garbage) return {{.label = "marked by its driver"}, {.label = "half of each picture"}};
    return {{}};
  }
  void inject(Fault fault, std::size_t way) override {
    fault_ = fault, way_ = way;
    if (fault == Fault::absent || fault == Fault::unplugged) sim_.unplug();
    if (fault == Fault::denied) sim_.refuse(0, EACCES);
    if (fault == Fault::busy) sim_.set_busy(true);
    if (fault == Fault::silent) sim_.set_fault(hal::V4l2Fault::silent);
    if (fault == Fault::garbage) sim_.set_fault(way == 0 ? hal::V4l2Fault::corrupt : hal::V4l2Fault::short_frame);
    if (fault == Fault::slow) sim_.set_fault(hal::V4l2Fault::slow);
    if (fault == Fault::stuck) sim_.set_fault(hal::V4l2Fault::stuck);
  }
  void heal() override {
    if (fault_ == Fault::absent || fault_ == Fault::unplugged) sim_.plug_in();
    fault_.reset();
    sim_.refuse(0, 0);
    sim_.set_busy(false);
    sim_.set_fault(hal::V4l2Fault::none);
  }
  void advance(Time now) override {
    if (next_.ns == 0) next_ = now;
    for (; next_ <= now; next_ = next_ + kPeriod) {
      picture_->row(0)[0] = static_cast<std::uint8_t>(++number_);
      const Time exposed = next_ - 10ms;
      (void)sim_.deliver(*picture_, exposed);  // false: no reader streams
      if (fault_ != Fault::duplicate) continue;
      sim_.set_fault(hal::V4l2Fault::stuck);  // the same frame once more, with its number and stamp
      (void)sim_.deliver(*picture_, exposed);
      sim_.set_fault(hal::V4l2Fault::none);
    }
  }

 private:
  hal::V4l2Sim sim_;
  msg::ImageBuffer picture_{msg::PixelFormat::yuyv, 320, 240};
  std::optional<Fault> fault_;
  std::size_t way_ = 0;
  Time next_{};
  int number_ = 0;
};

class LibcameraRig final : public Rig {
 public:
  LibcameraRig() {
    device = measures = "camera";
    names = {"libcamera"};
    heals = false;
    specs.devices.push_back(table(device, "libcamera", {{"path", std::string("0")}}));
    connectors.open_libcamera = [this](const hal::CameraSpec& spec, std::string& why) {
      auto camera = hal::open_libcamera_plugin(spec, os, why);
      // Beside the program, wherever that is.
      const std::string file = hal::kLibcameraPluginFile;
      if (const auto end = why.find(file); end != std::string::npos && end > 0 && why[end - 1] == '/')
        why.erase(why.find('/'), end - why.find('/'));
      return camera;
    };
  }
  std::vector<Way> ways(Fault fault) const override {
    if (fault == Fault::absent) return {{.label = "libcamera itself"}};
    return {{.cannot = {Reason::kernel_only}}};
  }
  void inject(Fault, std::size_t) override {}  // it is absent beside this test
  void heal() override {}
  void advance(Time) override {}
};

}  // namespace

std::vector<RigKind> camera_rigs() {
  return {{"v4l2", "`v4l2`", [] { return std::make_unique<V4l2Rig>(); }},
          {"libcamera", "`libcamera`", [] { return std::make_unique<LibcameraRig>(); }}};
}

}  // namespace sinew::test
