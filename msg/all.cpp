#include "msg/all.hpp"

#include <memory>
#include <new>
#include <string>
#include <vector>

#include "msg/actuators.hpp"
#include "msg/behaviour.hpp"
#include "msg/camera_model.hpp"
#include "msg/camera_pose.hpp"
#include "msg/can.hpp"
#include "msg/flight.hpp"
#include "msg/gait.hpp"
#include "msg/gaze.hpp"
#include "msg/ground_motion.hpp"
#include "msg/head.hpp"
#include "msg/image.hpp"
#include "msg/joints.hpp"
#include "msg/kick.hpp"
#include "msg/motion.hpp"
#include "msg/navigation.hpp"
#include "msg/operator.hpp"
#include "msg/pilot.hpp"
#include "msg/place.hpp"
#include "msg/policy.hpp"
#include "msg/radio.hpp"
#include "msg/referee.hpp"
#include "msg/safety.hpp"
#include "msg/sensors.hpp"
#include "msg/soccer.hpp"
#include "msg/team.hpp"
#include "msg/text_values.hpp"

namespace sinew::msg {
namespace {

template <class... T>
struct Types {
  static std::span<const TypeInfo* const> all() {
    static const std::array types{&type_info<T>()...};
    return types;
  }
  /// Gives a FromMate of the type at the same place in all() its defaults.
  static constexpr std::array<void (*)(void*), sizeof...(T)> kResetFromMate{[](void* p) { new (p) FromMate<T>(); }...};
};

// In order of name.
using Known =
    Types<ActuatorCommand, AltitudeState, AttitudeSetpoint, BallModel, BallSighting, BaroSample, BatterySample,
          BehaviourPlan, BehaviourState, CameraModel, CameraPose, CanFrame, Datagram, FieldPose, FlightSetpoint,
          GaitState, GazeCommand, GazeState, GnssSample, GroundMotion, GuardianState, HeadState, Image, ImuSample,
          JointState, JointTrajectory, KickRequest, MagSample, MateState, MissionState, MotionField, NavReport,
          NavState, ObstacleModel, OperatorLink, PadSighting, PilotSwitches, PlaceEstimate, PolicyState, PolicyVectors,
          RangeSample, RcSample, RefereeState, SafetyState, SoccerReport, SoccerSight, SolePressure, TeamModel,
          TeamPose, TeamState, TextValues, VelocityCommand, WrenchSetpoint>;

/// The FromMate of a known type, put together from its description: a static one for each would cost every robot more
/// memory than its messages, and only programs that look at robots ask.
struct FromMateOf {
  explicit FromMateOf(const TypeInfo& type, void (*reset)(void*))
      : name(std::string(type.name) + "FromMate"), info(type_info<FromMate<MateState>>()) {
    fields.assign(info.fields.begin(), info.fields.end());
    fields.back().nested = &type;
    floats.assign(type.floats.begin(), type.floats.end());
    for (FloatRun& run : floats) run.offset += fields.back().offset;
    info.name = name;
    info.size = fields.back().offset + type.size;
    info.fields = fields;
    info.floats = floats;
    info.reset = reset;
  }
  FromMateOf(const FromMateOf&) = delete;

  std::string name;
  std::vector<FieldInfo> fields;
  std::vector<FloatRun> floats;
  TypeInfo info;
};

const TypeInfo* find_from_mate(std::string_view name) {
  static const std::vector<std::unique_ptr<const FromMateOf>> all = [] {
    std::vector<std::unique_ptr<const FromMateOf>> made;
    for (std::size_t i = 0; i < Known::all().size(); ++i)
      if (const TypeInfo& type = *Known::all()[i]; !type.has_bulk())
        made.push_back(std::make_unique<FromMateOf>(type, Known::kResetFromMate[i]));
    return made;
  }();
  for (const auto& one : all)
    if (one->name == name) return &one->info;
  return nullptr;
}

}  // namespace

std::span<const TypeInfo* const> all_types() { return Known::all(); }

const TypeInfo* find_type(std::string_view name) {
  for (const TypeInfo* t : all_types())
    if (t->name == name) return t;
  return name.ends_with("FromMate") ? find_from_mate(name) : nullptr;
}

}  // namespace sinew::msg
