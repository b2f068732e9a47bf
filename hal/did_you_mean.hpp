#pragma once
// A hint for a name that does not exist: the names that the writer may have meant.
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace sinew::hal {

/// The names nearest to `asked`: the nearest one, or the first two where they are equally near; empty when none is
/// near. Near: at most a third of the letters differ, and at most three; two neighbours that changed places count once.
/// Also near, but less, is a name of which `asked` is the beginning ("search_height" of "search_height_m", "imu" of
/// "imu.raw") or the last part ("Mixer" of "control::Mixer"), which may differ as much ("Mixxer"). Capital letters
/// count as small ones, '-' as '_'. Thread:  any.   RT: no.
std::vector<std::string> near_names(std::string_view asked, std::span<const std::string> names);

/// "; did you mean imu.raw?", "; did you mean kp_yaw or kd_yaw?", to append to a message that lists what is allowed;
/// empty when no name is near.
/// Thread:  any.   RT: no.
std::string did_you_mean(std::string_view asked, std::span<const std::string> names);

/// What is allowed, as it is written in a file: "\"sim\", \"linux\"".
/// Thread:  any.   RT: no.
std::string quoted(std::span<const std::string> names);

}  // namespace sinew::hal
