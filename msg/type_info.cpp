// The descriptions of all messages, checked wherever the room is built.
#include "msg/actuators.hpp"
#include "msg/flight.hpp"
#include "msg/image.hpp"
#include "msg/sensors.hpp"

namespace sinew::msg {

static_assert(check_layout<ImuSample>() && check_layout<RangeSample>() && check_layout<BaroSample>());
static_assert(check_layout<Image>() && sizeof(Image) == 40);
static_assert(check_layout<ActuatorCommand>() && check_layout<GuardianState>());
static_assert(check_layout<NavState>() && check_layout<FlightSetpoint>() && check_layout<AttitudeSetpoint>());
static_assert(check_layout<WrenchSetpoint>() && check_layout<PadSighting>() && check_layout<MotionField>());
static_assert(check_layout<MissionState>());

}  // namespace sinew::msg
