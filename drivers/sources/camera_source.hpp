#pragma once
#include <optional>
#include <string>

#include "drivers/device_reader.hpp"
#include "hal/camera_controls.hpp"
#include "hal/camera_memory.hpp"
#include "rt/module.hpp"

namespace sinew::drivers {

/// Brings the frames of one camera into the graph: raw topic `raw`. The board writes the pixels straight into the
/// topic's slot; where camera and driver can, the driver does (hal::CameraMemory): the source then lends the camera
/// some slots for as long as it runs, and nothing copies a pixel. When several frames wait, one cycle brings two, each
/// as a message of its own. Exposure and gain are parameters that reach the camera while it runs, where it has such
/// controls (hal::CameraControls); the camera sets them on a thread of its own, some frames later. configure() narrows
/// both to what this camera allows; a control that the camera lacks or cannot set only allows "left alone". These
/// ranges stay for the whole run: when a camera comes back with others, the device itself complains.
/// Thread:  executor.   RT: yes.
/// Stamps:  the device's, and `time_offset_ms` on top.
/// Errors:  configure: what opening the device says; bad_argument when exposure or gain is not what this camera allows,
///          and when the camera's table demands lent slots and they cannot be had. A later value that it does not
///          allow is refused by Graph::set_param(). A frame that does not fit the topic's image capacity is lost and
///          counted by the device.
class CameraSource final : public rt::DriverModule, public DeviceReader {
 public:
  void declare(rt::Declaration& d) override {
    d.raw("raw", raw_, {.burst = kBurst});
    d.param("device", device_name_, {.doc = "name of the device on the board"});
    d.param("exposure_us", exposure_us_,
            {.unit = "us", .min = 0, .max = 1e6, .doc = "exposure time; 0 leaves it to the camera"});
    d.param(
        "time_offset_ms", time_offset_ms_,
        {.unit = "ms", .min = -200, .max = 200, .doc = "added to the device's stamps: sinew calibrate camera-offset"});
    d.param("gain", gain_, {.min = -1, .max = 1e6, .doc = "in the camera's own units; -1 leaves it as it is"});
  }
  hal::Status configure(rt::Setup& setup) override;
  void collect(rt::Time now) noexcept override;
  void rest(rt::Time now) noexcept override;
  void end() noexcept override;
  rt::StepStatus step(const rt::Step&) noexcept override {
    return raw_.empty() ? rt::StepStatus::stale : rt::StepStatus::ok;
  }
  hal::Device* device() override { return camera_; }
  std::string_view reads() const override { return "camera"; }

 private:
  static constexpr std::uint32_t kBurst = 2;
  static constexpr double kLeftAloneUs = 0, kLeftAlone = -1;
  hal::Status find_memory(rt::Setup& setup);
  bool collect_lent() noexcept;
  void take_back() noexcept;
  void shift(msg::Image& image) const noexcept;  // by time_offset_ms
  hal::Status find_controls(rt::Setup& setup);
  rt::ParamRange range_of(std::optional<std::size_t> control, double unit, double left_alone) const;
  rt::ParamRange exposure_range() const;
  rt::ParamRange gain_range() const;
  double unit_us() const noexcept;  // what one of the exposure control's units is
  void set_what_changed() noexcept;
  hal::Status set_exposure() noexcept;

  rt::Raw<msg::Image> raw_;
  std::string device_name_ = "camera";
  double exposure_us_ = kLeftAloneUs, gain_ = kLeftAlone, time_offset_ms_ = 0;
  hal::Camera* camera_ = nullptr;
  hal::CameraMemory* memory_ = nullptr;  // null: pictures are read()
  // What the camera was asked for last.
  hal::CameraControls* controls_ = nullptr;
  std::optional<hal::CameraControls::Exposure> exposure_;
  std::optional<std::size_t> gain_control_;
  double asked_exposure_us_ = kLeftAloneUs, asked_gain_ = kLeftAlone;
};

}  // namespace sinew::drivers
