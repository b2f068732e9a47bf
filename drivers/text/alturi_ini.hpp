#pragma once
#include <string_view>
#include <vector>

#include "drivers/device_spec.hpp"

namespace sinew::drivers {

/// Reads altURI's configuration files as they are: [connection], [drives], [driveN], [commands], [commandN],
/// [messages], [messageN]. They become the keys and tables of `link` (driver "text"), with the line of the INI file in
/// each.
///
/// As altURI: section and key names in any case; lines with ; or # before any = or [ are comments; what is not counted
/// by a total is not there; [commandgroups...] are not looked at. The prefix has a blank behind it. A drive is called
/// as the first word of its text ("AltitudeVelocity"), a message as its key and index ("Location_2"), a command
/// "command1". DriveNormalize=1 makes the limits -100 to 100.
/// Files with DriveFirstParameter or SimSensorPort speak UDP, the others TCP. With DriveFirstParameter=2 the first
/// conversion of each text is the sequence number, and %d of limits or increments that are not whole is the bits of a
/// float (AR.Drone); each drive is then a command of its own.
///
/// Errors:  problems with the line of the INI file: what altURI would refuse or misread.
void read_alturi_ini(std::string_view text, DeviceSpec& link, std::vector<rt::Problem>& problems);

}  // namespace sinew::drivers
