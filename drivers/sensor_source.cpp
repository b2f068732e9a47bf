#include "drivers/sensor_source.hpp"

namespace sinew::drivers {

template <>
hal::Result<hal::Imu*> SensorSource<msg::ImuSample>::open(hal::Board& board) const {
  return board.imu(device_name_);
}
template <>
hal::Result<hal::Range*> SensorSource<msg::RangeSample>::open(hal::Board& board) const {
  return board.range(device_name_);
}
template <>
hal::Result<hal::Baro*> SensorSource<msg::BaroSample>::open(hal::Board& board) const {
  return board.baro(device_name_);
}
template <>
hal::Result<hal::Battery*> SensorSource<msg::BatterySample>::open(hal::Board& board) const {
  return board.battery(device_name_);
}

template <class M>
hal::Status SensorSource<M>::configure(rt::Setup& setup) {
  auto device = open(setup.board());
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

template class SensorSource<msg::ImuSample>;
template class SensorSource<msg::RangeSample>;
template class SensorSource<msg::BaroSample>;
template class SensorSource<msg::BatterySample>;

}  // namespace sinew::drivers
