#pragma once
// Where a device is, as one text: two keys that mean one place give the same text, however they are written. Only the
// key's text counts: these functions read no file, ask no name server and follow no link of /dev.
#include <string>
#include <string_view>

namespace sinew::drivers {

/// "/dev//ttyS0" and "/dev/./ttyS0" are "/dev/ttyS0"; "/" and "" stay; ".." is left, as it may go through a link.
std::string place_of_path(std::string_view path);

/// The place below the folder of a key `root`; "/" adds nothing: "camera /dev/video0 under /tmp/wire".
std::string place_under(std::string place, std::string_view root);

/// A V4L2 camera's `path` (hal::CameraSpec::path): a node, also by the name that it has below /dev/v4l/by-id.
std::string place_of_camera(std::string_view path);

/// A CAN bus's `address`: udp's "7", "007", "239.65.82.7" and "7:lo" are one; so are a socketcand server's
/// "localhost:29536/can0", "LOCALHOST:029536/can0" and "127.0.0.1:29536/can0", and "[::1]" and "::1".
std::string place_of_bus(std::string_view transport, std::string_view address);

}  // namespace sinew::drivers
