#include "msg/all.hpp"

#include "msg/actuators.hpp"
#include "msg/can.hpp"
#include "msg/flight.hpp"
#include "msg/head.hpp"
#include "msg/image.hpp"
#include "msg/joints.hpp"
#include "msg/operator.hpp"
#include "msg/pilot.hpp"
#include "msg/radio.hpp"
#include "msg/safety.hpp"
#include "msg/sensors.hpp"
#include "msg/team.hpp"

namespace sinew::msg {

std::span<const TypeInfo* const> all_types() {
  static const std::array types{
      &type_info<ActuatorCommand>(), &type_info<AttitudeSetpoint>(), &type_info<BallSighting>(),
      &type_info<BaroSample>(),      &type_info<BatterySample>(),    &type_info<CanFrame>(),
      &type_info<Datagram>(),        &type_info<FlightSetpoint>(),   &type_info<GnssSample>(),
      &type_info<GuardianState>(),   &type_info<HeadState>(),        &type_info<Image>(),
      &type_info<ImuSample>(),       &type_info<JointState>(),       &type_info<MagSample>(),
      &type_info<MateState>(),       &type_info<MissionState>(),     &type_info<MotionField>(),
      &type_info<NavState>(),        &type_info<OperatorLink>(),     &type_info<PadSighting>(),
      &type_info<PilotSwitches>(),   &type_info<RangeSample>(),      &type_info<RcSample>(),
      &type_info<SafetyState>(),     &type_info<TeamPose>(),         &type_info<TeamState>(),
      &type_info<WrenchSetpoint>(),
  };
  return types;
}

const TypeInfo* find_type(std::string_view name) {
  for (const TypeInfo* t : all_types())
    if (t->name == name) return t;
  return nullptr;
}

}  // namespace sinew::msg
