#pragma once
#include <string>

#include "drivers/device_reader.hpp"
#include "hal/radio.hpp"
#include "rt/module.hpp"

namespace sinew::drivers {

/// Brings the samples of one sensor (or radio) into the graph: raw topic `raw`, one message a sample, in the order of
/// arrival. Thread:  executor.   RT: yes. Errors:  configure: what opening the device says. A sample that the device
/// reports as lost is counted by the board
///          and ends this cycle's reading; while nothing arrives the step is stale, so that whoever watches this module
///          sees a silent sensor.
template <class M>
class SensorSource : public rt::DriverModule, public DeviceReader {
 public:
  explicit SensorSource(std::string default_device) : device_name_(std::move(default_device)) {}
  void declare(rt::Declaration& d) override {
    d.raw("raw", raw_, {.burst = kBurst});
    d.param("device", device_name_, {.doc = "name of the device on the board"});
  }
  hal::Status configure(rt::Setup& setup) override;
  void collect(rt::Time now) noexcept override;
  rt::StepStatus step(const rt::Step&) noexcept override {
    return raw_.empty() ? rt::StepStatus::stale : rt::StepStatus::ok;
  }
  hal::Device* device() override { return device_; }
  std::string_view reads() const override;

 private:
  // A 1 kHz sensor read every 20 ms still fits; what is left stays in the device for the next cycle.
  static constexpr std::uint32_t kBurst = 20;

  rt::Raw<M> raw_;
  std::string device_name_;
  hal::Sensor<M>* device_ = nullptr;
};

class ImuSource final : public SensorSource<msg::ImuSample> {
 public:
  ImuSource() : SensorSource("imu") {}
};
class RangeSource final : public SensorSource<msg::RangeSample> {
 public:
  RangeSource() : SensorSource("range") {}
};
class BaroSource final : public SensorSource<msg::BaroSample> {
 public:
  BaroSource() : SensorSource("baro") {}
};
class BatterySource final : public SensorSource<msg::BatterySample> {
 public:
  BatterySource() : SensorSource("battery") {}
};
class MagSource final : public SensorSource<msg::MagSample> {
 public:
  MagSource() : SensorSource("mag") {}
};
class GnssSource final : public SensorSource<msg::GnssSample> {
 public:
  GnssSource() : SensorSource("gnss") {}
};
class RcSource final : public SensorSource<msg::RcSample> {
 public:
  RcSource() : SensorSource("rc") {}
};
/// The datagrams of a radio; a stale step heard nobody. In a thread with a period: a flood then takes no more than one
/// cycle's share of them, kBurst.
class RadioSource final : public SensorSource<msg::Datagram> {
 public:
  RadioSource() : SensorSource("radio") {}
};
class JointSource final : public SensorSource<msg::JointState> {
 public:
  JointSource() : SensorSource("joints") {}
};
class SoleSource final : public SensorSource<msg::SolePressure> {
 public:
  SoleSource() : SensorSource("soles") {}
};
/// What the referee of a game says; a stale step heard nothing new.
class RefereeSource final : public SensorSource<msg::RefereeState> {
 public:
  RefereeSource() : SensorSource("referee") {}
};
/// All values of a text robot (docs/text-robots.md).
class TextSource final : public SensorSource<msg::TextValues> {
 public:
  TextSource() : SensorSource("link") {}
};

}  // namespace sinew::drivers
