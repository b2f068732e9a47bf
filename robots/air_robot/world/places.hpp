#pragma once
#include <cstddef>
#include <string_view>

#include "sim_hil/places/place.hpp"

namespace sinew::plant {

/// The places of the world air_robot, as its option `place` counts them.
enum class PlaceNumber : std::size_t { arena = 1, empty_arena = 2, town = 3, room = 4 };

/// MuJoCo's XML of a place, with all that can move in it as mocap bodies in the order of SceneOrder. It lives as long
/// as the process. Thread: any.
std::string_view place_xml(PlaceNumber number);

/// Its solids, as its XML has them, and where vehicles start. Errors: bad_data.
hal::Result<PlaceMap> load_place(PlaceNumber number);

}  // namespace sinew::plant
