#include "drivers/sources/sensor_source.hpp"

#include <array>

namespace sinew::drivers {

namespace {

template <class M>
hal::Result<hal::Sensor<M>*> device_of(hal::Board& board, std::string_view name) {
  return board.sensor<M>(name);
}
template <>
hal::Result<hal::Sensor<msg::Datagram>*> device_of<msg::Datagram>(hal::Board& board, std::string_view name) {
  const auto radio = board.radio(name);
  if (!radio) return radio.error();
  return static_cast<hal::Sensor<msg::Datagram>*>(*radio);
}

template <class M>
constexpr std::string_view as_drivers_say() {
  constexpr std::array<std::string_view, hal::kSensorKinds> kNames{
      "imu", "range", "baro", "battery", "mag", "gnss", "rc", "joints", "text", "soles", "referee"};  // by SensorKind
  return kNames[static_cast<std::size_t>(hal::kSensorKind<M>)];
}
template <>
constexpr std::string_view as_drivers_say<msg::Datagram>() {
  return "radio";
}

}  // namespace

template <class M>
hal::Status SensorSource<M>::configure(rt::Setup& setup) {
  auto device = device_of<M>(setup.board(), device_name_);
  if (!device) return explain_no_device(setup, device_name_, device.error());
  device_ = *device;
  return {};
}

template <class M>
void SensorSource<M>::collect(rt::Time) noexcept {
  collect_ready(raw_, *device_);
}

template <class M>
std::string_view SensorSource<M>::reads() const {
  return as_drivers_say<M>();
}

template class SensorSource<msg::ImuSample>;
template class SensorSource<msg::RangeSample>;
template class SensorSource<msg::BaroSample>;
template class SensorSource<msg::BatterySample>;
template class SensorSource<msg::MagSample>;
template class SensorSource<msg::GnssSample>;
template class SensorSource<msg::RcSample>;
template class SensorSource<msg::JointState>;
template class SensorSource<msg::TextValues>;
template class SensorSource<msg::SolePressure>;
template class SensorSource<msg::RefereeState>;
template class SensorSource<msg::Datagram>;

}  // namespace sinew::drivers
