#include "drivers/sources/sensor_source.hpp"

#include <array>

namespace sinew::drivers {

template <class M>
hal::Status SensorSource<M>::configure(rt::Setup& setup) {
  auto device = setup.board().sensor<M>(device_name_);
  if (!device) {
    setup.explain("device '" + device_name_ + "': " + hal::to_string(device.error().code));
    return device.error();
  }
  device_ = *device;
  return {};
}

template <class M>
void SensorSource<M>::collect(rt::Time) noexcept {
  while (M* sample = raw_.loan()) {
    const auto got = device_->read(*sample);
    if (got && *got) continue;
    raw_.cancel();
    return;  // nothing is ready, or the device failed: the next cycle goes on
  }
}

template <class M>
std::string_view SensorSource<M>::reads() const {
  constexpr std::array<std::string_view, 8> kAsDriversSay{"imu", "range", "baro", "battery",
                                                          "mag", "gnss",  "rc",   "joints"};  // by SensorKind
  return kAsDriversSay[static_cast<std::size_t>(hal::kSensorKind<M>)];
}

template class SensorSource<msg::ImuSample>;
template class SensorSource<msg::RangeSample>;
template class SensorSource<msg::BaroSample>;
template class SensorSource<msg::BatterySample>;
template class SensorSource<msg::MagSample>;
template class SensorSource<msg::GnssSample>;
template class SensorSource<msg::RcSample>;
template class SensorSource<msg::JointState>;

}  // namespace sinew::drivers
