#pragma once
#include <memory>

#include "record/copy.hpp"

namespace sinew::record {

/// Converts our messages to the ROS 2 messages of the same meaning: ImuSample to sensor_msgs/msg/Imu, RangeSample to
/// Range, BaroSample to FluidPressure, BatterySample to BatteryState, NavState to nav_msgs/msg/Odometry. Other
/// messages, and types of other versions of this program, stay as they are.
/// Frames:  base_link and odom, as in REP-105; a range is measured along x of a frame named like its topic.
/// `unix_ns`: added to the stamps of the messages for their headers.
std::unique_ptr<Conversion> to_ros2(std::int64_t unix_ns);
/// The `unix_ns` of a recorded run; 0 for any other file.
std::int64_t unix_ns_of(Reader& reader);

}  // namespace sinew::record
