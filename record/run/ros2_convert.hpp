#pragma once
#include <memory>

#include "record/copy.hpp"

namespace sinew::record {

/// Messages of ours as those of ROS 2 that say the same: ImuSample as sensor_msgs/msg/Imu, RangeSample as Range,
/// BaroSample as FluidPressure, BatterySample as BatteryState, NavState as nav_msgs/msg/Odometry. Every other message
/// stays as it is. Types of other versions of this program stay as they are, too.
/// Frames:  base_link and odom, as REP-105 has them; a range is measured along x of a frame named as its topic.
/// `unix_ns`: what is added to the stamps of the messages for their headers.
std::unique_ptr<Conversion> to_ros2(std::int64_t unix_ns);
/// What a recorded run says; 0 for any other file.
std::int64_t unix_ns_of(Reader& reader);

}  // namespace sinew::record
