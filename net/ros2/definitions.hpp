#pragma once
// The ROS 2 types that this room knows by itself, field for field as the distribution has them.
// Source:  ros2/common_interfaces, ros2/rcl_interfaces, ros2/rmw_dds_common, ros2/geometry2,
// ros-perception/vision_msgs,
//          branches humble and jazzy.
#include <cstdint>
#include <memory>
#include <string_view>
#include <utility>

#include "net/ros2/schema.hpp"

namespace sinew::ros2 {

enum class Distro : std::uint8_t { humble, jazzy };

inline constexpr std::pair<std::string_view, Distro> kDistros[] = {{"humble", Distro::humble},
                                                                   {"jazzy", Distro::jazzy}};

/// All of them, and sinew_msgs of each message of msg::all_types() and of mates.
const Types& known_types(Distro distro);

}  // namespace sinew::ros2
