#pragma once
#include <string>

#include "msg/describe.hpp"

namespace sinew::msg {

/// Name of the type in recordings and on the network: sinew_msgs/msg/ImuSample.
std::string ros2_name(const TypeInfo& type);

/// The schema as ROS 2 tools read it ("ros2msg"): the fields of the type, then each nested type once, after a line of
/// 80 '=' and a line "MSG: sinew_msgs/Name". Units and remarks follow the fields. Time is an int64 in nanoseconds, an
/// enumeration its integer, the bulk `uint8[]`. math::fnv1a64() of the text tells two versions of a type apart.
/// RT:      configure only.
std::string ros2msg_schema(const TypeInfo& type);

}  // namespace sinew::msg
