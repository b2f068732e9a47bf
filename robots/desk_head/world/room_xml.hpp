#pragma once
#include <string_view>

namespace sinew::robots {

/// The text of room.xml; CMake makes the source.
std::string_view room_xml_of_desk_head();

}  // namespace sinew::robots
