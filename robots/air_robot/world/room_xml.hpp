#pragma once
#include <string_view>

namespace sinew::robots {

/// The texts of arena.xml, town.xml and vehicles.xml; CMake makes the sources.
std::string_view arena_xml_of_air_robot();
std::string_view town_xml_of_air_robot();
std::string_view vehicles_xml_of_air_robot();

}  // namespace sinew::robots
