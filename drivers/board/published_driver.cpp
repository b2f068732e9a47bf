#include "drivers/board/published_driver.hpp"

namespace sinew::drivers {
namespace {

/// Takes every setpoint: nobody is here who could refuse one, and nobody whom a lease would stop.
class PublishedActuators final : public hal::Actuators {
 public:
  hal::Status write(const msg::ActuatorCommand&, hal::Duration) noexcept override { return {}; }
  hal::Status stop() noexcept override { return {}; }
};

DeviceOpener read_published(DeviceKeys&, const DeviceSpecs&) {
  return [](DeviceContext&, std::string&) -> hal::Result<OpenedDevice> {
    auto actuators = std::make_shared<PublishedActuators>();
    OpenedDevice device;
    device.actuators = actuators.get();
    device.owner = std::move(actuators);
    return device;
  };
}

}  // namespace

DriverKind published_driver() { return {"published", "actuators", read_published}; }

}  // namespace sinew::drivers
