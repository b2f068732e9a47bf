#pragma once
// Commands to actuators, and the guardian's decisions about them.
#include "msg/geometry.hpp"

namespace sinew::msg {

inline constexpr std::size_t kMaxChannels = 8;

/// Setpoints for one actuator group (e.g. four motors), in the unit that the robot file gives the group.
struct ActuatorCommand {
  Time stamp;  // of the measurement behind the command, so that latency stays visible downstream
  std::array<double, kMaxChannels> value{};
  std::uint32_t count = 0;  // channels in use
  std::uint32_t armed = 0;  // 1: the controller wants the motors live; 0: stop them
};

enum class GuardianMode : std::uint32_t { standby = 0, armed = 1, active = 2, safe = 3 };

inline constexpr ValueName kGuardianModeNames[] = {{"standby", GuardianMode::standby},
                                                   {"armed", GuardianMode::armed},
                                                   {"active", GuardianMode::active},
                                                   {"safe", GuardianMode::safe}};

/// Why a command was not passed on as it came; bits, or-ed.
enum GuardianFault : std::uint32_t {
  kFaultNone = 0,
  kFaultLease = 1,      // no valid command for longer than the lease
  kFaultNotFinite = 2,  // NaN or infinity
  kFaultLimit = 4,      // outside limits
  kFaultRate = 8,       // changed faster than allowed
  kFaultCount = 16,     // not the configured number of channels
  kFaultDevice = 32,    // the device refused or is gone
  kFaultFailsafe = 64,  // a failsafe of the robot file stopped the robot
};

inline constexpr ValueName kGuardianFaultNames[] = {
    {"lease", kFaultLease}, {"not finite", kFaultNotFinite}, {"limit", kFaultLimit},      {"rate", kFaultRate},
    {"count", kFaultCount}, {"device", kFaultDevice},        {"failsafe", kFaultFailsafe}};

/// What really went out to one actuator group, and why.
struct GuardianState {
  Time stamp;
  Time command_stamp;  // stamp of the command behind it
  std::array<double, kMaxChannels> value{};
  std::uint32_t count = 0;
  GuardianMode mode = GuardianMode::standby;
  std::uint32_t faults = 0;        // GuardianFault bits now
  std::uint32_t fault_events = 0;  // faults since the start
};

template <>
struct Description<ActuatorCommand> {
  static constexpr std::string_view name = "ActuatorCommand", doc = "Setpoints for one actuator group.";
  static constexpr auto fields = describe(
      field<&ActuatorCommand::stamp>("ns", "of the measurement behind it"), field<&ActuatorCommand::value>(""),
      field<&ActuatorCommand::count>("1", "channels in use"), field<&ActuatorCommand::armed>("1", "1: motors live"));
};

template <>
struct Description<GuardianState> {
  static constexpr std::string_view name = "GuardianState", doc = "What went out to one actuator group, and why.";
  static constexpr auto fields = describe(
      field<&GuardianState::stamp>("ns"), field<&GuardianState::command_stamp>("ns"), field<&GuardianState::value>(""),
      field<&GuardianState::count>("1"), enum_field<&GuardianState::mode>(kGuardianModeNames),
      bits_field<&GuardianState::faults>(kGuardianFaultNames, "now"),
      field<&GuardianState::fault_events>("1", "faults since the start"));
};

}  // namespace sinew::msg
