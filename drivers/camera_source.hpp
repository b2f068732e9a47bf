#pragma once
#include <string>

#include "rt/module.hpp"

namespace sinew::drivers {

/// Brings the frames of one camera into the graph: raw topic `raw`. The board writes the pixels straight into the
/// topic's slot. When several frames wait, only the newest two are worth a cycle, and each gets its own message.
/// Thread:  executor.   RT: yes.
/// Errors:  configure: what opening the device says. A frame that does not fit the topic's image capacity is lost and
///          counted by the device.
class CameraSource final : public rt::DriverModule {
 public:
  void declare(rt::Declaration& d) override {
    d.raw("raw", raw_, {.burst = 2});
    d.param("device", device_name_, {.doc = "name of the device on the board"});
  }
  hal::Status configure(rt::Setup& setup) override;
  void collect(rt::Time now) noexcept override;
  rt::Status step(const rt::Step&) noexcept override { return raw_.empty() ? rt::Status::stale : rt::Status::ok; }
  hal::Device* device() override { return camera_; }

 private:
  rt::Raw<msg::Image> raw_;
  std::string device_name_ = "camera";
  hal::Camera* camera_ = nullptr;
};

}  // namespace sinew::drivers
